"""compensate: from a program and a set-up to a program with which the machine, its known errors included, cuts the part right.

program -> moves with traces -> corrected points (fixed point) -> lines and arcs -> words of the blocks -> proof
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from pathlib import Path

import numpy as np

from vcmm.compensating.contours import length_of
from vcmm.compensating.field import Field, Known, field_of, known_errors_of
from vcmm.compensating.frame import AXES, CENTRES
from vcmm.compensating.header import digest, file_parts, header, machine_parts, place
from vcmm.compensating.holes import drill
from vcmm.compensating.loading import loaded
from vcmm.compensating.numbers import decimals_of
from vcmm.compensating.offsets import with_shifts
from vcmm.compensating.proof import (
    block_rate,
    compare,
    compare_comments,
    departure,
    departures,
    end_departures,
    errors_on,
    spans,
    walk,
)
from vcmm.compensating.refusals import (
    check_dialect,
    check_mark,
    check_program,
    check_state,
    check_travel,
    codes_of,
)
from vcmm.compensating.result import Blocks, Compensation, Departure, Rounding
from vcmm.compensating.source import SourceText
from vcmm.compensating.targets import Targets, moves_of, targets
from vcmm.compensating.writer import SHORT, Writer
from vcmm.errors import DataError, ModelLimit, UsageError
from vcmm.machine import Machine
from vcmm.nc.dialects import G_CODE, Dialect
from vcmm.nc.interpret import interpret
from vcmm.nc.moves import Program
from vcmm.nc.setup import Setup
from vcmm.nc.trace import Trace
from vcmm.sampling import Progress

FIT_SHARE = 0.7  # of the tolerance for what lies between the ends of blocks; the rest is for the ends
SLACK = 0.3  # of the tolerance: an axis that a block does not name is corrected only where it is off by more
GROWTH = 20.0  # blocks after / before, beyond which the tolerance is relaxed
RELAXED, MOST_RELAXED = 2.0, 10


@dataclass(frozen=True, eq=False)
class Work:
    """Everything that is known before rewriting."""

    source: SourceText
    program: Program
    dialect: Dialect
    setup: Setup
    machine: Machine
    known: Known
    field: Field
    decimals: tuple[int, int]
    hashed: str
    notes: tuple[str, ...]
    carry: bool


def compensate(
    program: str | Path,
    setup: str | Path | Setup,
    machine: Machine | None = None,
    *,
    dialect: str | None = None,
    tolerance: float = 1e-3,
    decimals: int | None = None,
    set_here: bool = True,
    carry: bool = True,
    growth: float = GROWTH,
    constants: Mapping[str, float] | None = None,
    progress: Progress | None = None,
) -> Compensation:
    """Rewrite a program. tolerance: mm. machine: instead of that of the set-up. set_here: the work offset was set on this machine.
    carry: rounding errors are carried along chains of short blocks; else every number is rounded by itself.

    Raises DataError, UsageError and ModelLimit, with file and line, for whatever cannot be rewritten for certain.
    """
    if not tolerance > 0:
        raise UsageError(f"tolerance = {tolerance:g} mm must be a positive length")
    report = progress or (lambda text, share: None)
    report("reading the program", 0.0)
    work = prepare(program, setup, machine, dialect, decimals, set_here, constants, carry)
    used, notes = tolerance, list(work.notes)
    for _ in range(MOST_RELAXED):
        report("correcting", 0.3)
        text, lines, found, writer, new = _read_back(work, used, notes)
        grown = len(new.traces) / max(len(work.program.traces), 1)
        if grown <= growth:
            break
        notes.append(
            f"a tolerance of {used * 1e3:g} um makes {grown:.1f} times as many blocks (limit {growth:g}); relaxed to {used * RELAXED * 1e3:g} um"
        )
        used *= RELAXED
    else:
        raise UsageError(
            f"the program grows beyond {growth:g} times its blocks at every tolerance; raise --growth"
        )
    report("running it again", 0.7)
    return _proved(work, text, lines, found, writer, new, tolerance, used, notes)


def _read_back(
    work: Work, tolerance: float, notes: list[str]
) -> tuple[str, list[int], Targets, Writer, Program]:
    """Rewrite and read again; where radius compensation cannot follow the added blocks, without blocks added there."""
    for beside in (True, False):
        text, lines, found, writer = rewrite(work, tolerance, beside)
        try:
            new = interpret(text, work.dialect.name, work.setup, work.source.name, trace=True)
        except (ModelLimit, DataError) as error:
            if not beside:
                raise ModelLimit(
                    f"the rewritten program cannot be read again (lines of the new program): {error}; nothing was written"
                ) from None
            continue
        if not beside:
            notes.append(
                "radius compensation (G41, G42) cannot follow blocks added to its contours; none were added there"
            )
        break
    return text, lines, found, writer, new


def prepare(
    program: str | Path, setup: str | Path | Setup, machine: Machine | None, dialect: str | None,
    decimals: int | None, set_here: bool, constants: Mapping[str, float] | None, carry: bool = True,
) -> Work:  # fmt: skip
    """Read everything and refuse what must be refused."""
    source, setup, machine, machine_file, name = loaded(program, setup, machine, dialect)
    check_dialect(name)
    check_mark(source)
    notes = check_state(machine, machine_file, setup)
    read = interpret(source.text, name, setup, source.name, trace=True)
    check_program(read, machine, setup, source.name)
    check_travel(read, machine, False, source.name)
    known = known_errors_of(machine)
    language = G_CODE[name]
    field = field_of(
        known,
        setup,
        read.moves,
        set_here=set_here,
        constants={**setup.constants, **(constants or {})},
        lathe=language.lathe,
    )
    if setup.decimal_point:
        language = replace(language, decimal_point=setup.decimal_point)
    own = [] if machine_file else machine_parts(machine)
    hashed = digest([*file_parts([setup.path, machine_file]), *own, source.text.encode("utf-8")])
    said = (*notes, *known.left, *(f"{source.name}:{w.line}: {w.text}" for w in read.warnings))
    return Work(
        source,
        read,
        language,
        setup,
        machine,
        known,
        field,
        _decimals(read.traces, decimals),
        hashed,
        said,
        carry,
    )


def _decimals(traces: Sequence[Trace], asked: int | None) -> tuple[int, int]:
    out = []
    for inch in (False, True):
        words = [
            w
            for t in traces
            if (t.after.unit > 1.0) == inch
            for k, w in t.words.items()
            if k in AXES + CENTRES + "R" and w.plain
        ]
        out.append(decimals_of(words, inch, asked))
    return out[0], out[1]


def rewrite(work: Work, tolerance: float, beside: bool = True) -> tuple[str, list[int], Targets, Writer]:
    """The new text, the source line (from 1, 0 for the mark) of each of its lines, the fits, and the writer's tallies."""
    traces = work.program.traces
    codes = codes_of(work.source)
    index = moves_of(traces, work.program.moves)
    own = [codes[t.line - 1] for t in traces]
    found = targets(traces, work.field, index, FIT_SHARE * tolerance, own, beside)
    first = traces[0].contour
    writer = Writer(
        work.source,
        work.dialect,
        work.decimals,
        np.array(first.start) + np.array(first.tool_offset),
        "".join(work.machine.axes),
        work.carry,
        slack=SLACK * tolerance,
    )
    at = 0
    while at < len(traces):
        to = at + 1
        while to < len(traces) and traces[to].line == traces[at].line and to - at < len(traces):
            to += 1
        following = traces[to].contour if to < len(traces) else None
        cuts = following is not None and following.kind in ("line", "arc")
        writer.rapid = FIT_SHARE * tolerance if cuts else math.inf
        writer.chain_ends = following is None or following.kind != "line" or length_of(following) > SHORT
        _block(writer, traces[at:to], found.fits[at:to], work)
        at = to
    return (*_assembled(work, writer, tolerance), found, writer)


def _block(writer: Writer, traces: Sequence[Trace], fits: Sequence[object], work: Work) -> None:
    """One block of the source with all its moves."""
    one = traces[0]
    if one.contour.kind == "dwell" and not one.cycle:
        return
    if not one.contour.rewritable:
        _machine_move(writer, traces, work.dialect)
        return
    if one.runs > 1 and not work.known.machine.effects:
        last = traces[-1].contour
        writer.q = np.array(last.end) + np.array(last.tool_offset)
        return
    if one.runs > 1:
        raise DataError(
            f"{one.file}:{one.line}:{one.contour.source.first}: the block is executed {one.runs} times (loop or subprogram), and the "
            "correction depends on the place: write it out for each place, or post the program without subprograms and loops"
        )
    if one.cycle:
        drill(writer, traces, fits)  # type: ignore[arg-type]
        return
    writer.cycle.clear()
    begin = writer.q.copy()
    writer.move(one, fits[0])  # type: ignore[arg-type]
    if len(traces) > 1:
        back = traces[-1].contour
        if len(traces) > 2 or back.kind != "thread" or back.end != one.contour.start:
            raise DataError(
                f"{one.file}:{one.line}:{one.contour.source.first}: a block of several moves ({one.after.motion}) is not rewritten; write its moves one by one"
            )
        writer.q = begin  # a rigid tap comes back to where it began


def _machine_move(writer: Writer, traces: Sequence[Trace], dialect: Dialect) -> None:
    """G28, G30, G53: the named axes go to a machine position, the others stay where the new program has them."""
    last = traces[-1]
    named = [a for a in AXES if a in last.words]
    everything = not any(a in last.words for a in "XYZABC") and dialect.words == "o"
    end = np.array(last.contour.end) + np.array(last.contour.tool_offset)
    for i, letter in enumerate(AXES):
        if everything or letter in named:
            writer.q[i] = end[i]
    writer.cycle.clear()


def _assembled(work: Work, writer: Writer, tolerance: float) -> tuple[str, list[int]]:
    """The text with its mark."""
    mark = header(work.machine.name, tolerance, work.hashed, work.dialect)
    at, text, lines = place(work.source), [], []
    body = writer.lines()
    for number, (line, index) in enumerate([*body, ("", len(work.source.lines))]):
        if index == at and (number == 0 or body[number - 1][1] != at):
            text += [m + work.source.end for m in mark]
            lines += [0] * len(mark)
        text.append(line)
        lines.append(index + 1)
    return "".join(text), lines[:-1]


def _proved(
    work: Work, text: str, lines: list[int], found: Targets, writer: Writer, new: Program, tolerance: float, used: float,
    notes: list[str],
) -> Compensation:  # fmt: skip
    """Read back, compare, run again."""
    mark = header(work.machine.name, used, work.hashed, work.dialect)
    compare(work.program, new, lines, work.source.name)
    compare_comments(work.source.text, text, mark)
    check_travel(new, work.machine, True, work.source.name, lines)
    before, offset_only, shifts = with_shifts(work.program.moves, work.field)
    after = _departed(work, work.known, new, lines)
    whole = None
    if work.known.dynamic:
        full = work.known.whole()
        whole = (_departed(work, full, work.program, ()), _departed(work, full, new, lines))
    rounding = _rounding(work, writer, after)
    met = after.largest <= used + min(rounding.largest, math.sqrt(3.0) * rounding.step) + 1e-9
    if not met:
        notes.append(
            f"line {after.line}: {after.largest * 1e3:.2f} um are left, more than the tolerance of {used * 1e3:g} um and the rounding of "
            f"{rounding.largest * 1e3:.2f} um together"
        )
    for index in sorted(writer.expressions)[:5]:
        notes.append(f"{work.source.name}:{index + 1}: an expression has been replaced by its number")
    return Compensation(
        work.source.name, work.dialect.name, work.machine.name, text, work.source.encoded(text), tolerance, used,
        met and used == tolerance, before, offset_only, after, shifts, rounding, _counted(work, writer, new, lines), work.hashed,
        tuple(notes), tuple(lines), whole,
    )  # fmt: skip


def _departed(work: Work, known: Known, program: Program, lines: Sequence[int]) -> Departure:
    """The program run on the machine, against the path of the original; lines: empty for the original itself."""
    field = field_of(
        known, work.setup, program.moves, set_here=work.field.set_here, constants=work.field.constants,
        lathe=work.dialect.lathe,
    )  # fmt: skip
    w = walk(program.moves)
    low, high = spans(work.program, program, lines) if lines else (np.arange(len(program.moves)),) * 2
    actual = w.tip + errors_on(field, w)
    gap = departures(actual, work.program.moves, low[w.move], high[w.move])
    gap = np.maximum(gap, end_departures(actual, w, program.moves, work.program.moves, low, high))
    at = [program.moves[i].source.line for i in w.move.tolist()]
    return departure(gap, w.weight, [lines[line - 1] for line in at] if lines else at)


def _rounding(work: Work, writer: Writer, after: Departure) -> Rounding:
    """Ends as written against ends as wanted; axes that a block does not name and that were left off are in it too."""
    size = np.linalg.norm(np.array(writer.rounding).reshape(-1, 3), axis=1)
    step = max(writer.step(t.after.unit > 1.0) * t.after.unit for t in work.program.traces)
    rms = float(np.sqrt(np.mean(size**2))) if len(size) else 0.0
    share = min((rms / after.rms) ** 2, 1.0) if after.rms > 0 else 0.0
    return Rounding(step, float(size.max(initial=0.0)), rms, share)


def _counted(work: Work, writer: Writer, new: Program, lines: Sequence[int]) -> Blocks:
    old_rate, _ = block_rate(work.program.moves)
    rate, line = block_rate(new.moves)
    return Blocks(
        len({t.line for t in work.program.traces}), len({t.line for t in new.traces}), len(writer.edits),
        sum(len(v) for v in writer.added.values()), old_rate, rate, lines[line - 1] if line else 0,
    )  # fmt: skip
