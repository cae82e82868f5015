"""Compensate a program: with the new program the machine, its known errors included, cuts the part correctly.

program -> moves with traces -> corrected points (fixed point) -> lines and arcs -> words of the blocks -> proof
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import pairwise
from pathlib import Path

import numpy as np

from vcmm.compensation.block_skip import check_expressions
from vcmm.compensation.field import KnownErrors, field_of, known_errors_of
from vcmm.compensation.frame import AXES, CENTRES
from vcmm.compensation.header import SEMICOLON, digest, file_parts, header, machine_parts
from vcmm.compensation.inlining import INLINE, check_written_out, must_be_written_out, written_out
from vcmm.compensation.languages import LANGUAGES
from vcmm.compensation.loading import MachineOfFile, load_program, machine_of
from vcmm.compensation.numbers import decimals_of
from vcmm.compensation.offsets import with_shifts
from vcmm.compensation.pointing import correct_orientation, with_angles
from vcmm.compensation.proof import block_rate, compare, compare_comments
from vcmm.compensation.refusals import (
    check_channels,
    check_dialect,
    check_face,
    check_mark,
    check_moves,
    check_program,
    check_state,
    check_travel,
    check_words,
    check_wound,
)
from vcmm.compensation.result import BlockCounts, CompensatedProgram, Departure, Rounding
from vcmm.compensation.rewriting import Work, rewrite
from vcmm.compensation.run_again import both_paths, departure_by_run, pointing_of
from vcmm.compensation.source import SourceText, at_origin
from vcmm.compensation.surface import SurfaceErrors, what_is_left, with_surface
from vcmm.compensation.temperatures import with_temperatures
from vcmm.compensation.writer import Writer
from vcmm.core.blocks import Progress
from vcmm.core.effect import required
from vcmm.core.errors import DataError, ModelLimit, UsageError
from vcmm.core.machine import Machine
from vcmm.program.dialects import Dialect
from vcmm.program.interpret import interpret, read_for
from vcmm.program.moves import Program
from vcmm.program.sensible import length_missing, without_length
from vcmm.program.setup import Setup
from vcmm.program.trace import Trace
from vcmm.shop.motion.tool_centre import leads

GROWTH = 20.0  # blocks after / before, beyond which the tolerance is relaxed
RELAXED, MOST_RELAXED = 2.0, 10


def compensate(
    program: str | Path,
    setup: Setup,
    machine: MachineOfFile | Machine,
    *,
    dialect: str | None = None,
    tolerance: float = 1e-3,
    decimals: int | None = None,
    set_here: bool = True,
    carry: bool = True,
    growth: float = GROWTH,
    constants: Mapping[str, float] | None = None,
    inline: float = INLINE,
    surface: SurfaceErrors | None = None,
    follow: bool = False,
    orientation: bool = False,
    progress: Progress | None = None,
) -> CompensatedProgram:
    """Rewrite a program. tolerance: mm. surface: also correct the effects of the tool on the finished surface beside its path.
    machine: with its errors. set_here: the work offset was set on this machine.
    carry: rounding errors are carried along chains of short blocks; else every number is rounded by itself. inline: blocks that
    are executed several times are written out, up to so many blocks for each line of the program; 0 refuses them. orientation: angles
    and directions of the tool are corrected too, where the tip is led. follow: keep both paths with their errors.

    Raises DataError, UsageError and ModelLimit, with file and line, for whatever cannot be rewritten for certain.
    """
    if not tolerance > 0:
        raise UsageError(f"tolerance = {tolerance:g} mm must be a positive length")
    report = progress or (lambda text, share: None)
    report("reading the program", 0.0)
    work = prepare(
        program=program,
        setup=setup,
        machine=machine,
        dialect=dialect,
        decimals=decimals,
        set_here=set_here,
        constants=constants,
        carry=carry,
        inline=inline,
        surface=surface,
        orientation=orientation,
    )
    try:
        return _rewritten(replace(work, follow=follow), tolerance, growth, report)
    except (DataError, ModelLimit) as error:
        raise at_origin(error, work.source.name, work.origin) from None


def _rewritten(work: Work, tolerance: float, growth: float, report: Progress) -> CompensatedProgram:
    """Return the new program with as many blocks as are allowed, and its proof."""
    used, notes = tolerance, list(work.notes)
    for _ in range(MOST_RELAXED):
        report("correcting", 0.3)
        text, lines, writer, new = _read_back(work, used, notes)
        grown = len(new.traces) / max(len(work.program.traces), 1)
        if grown <= growth:
            break
        notes.append(
            f"a tolerance of {used * 1e3:g} um makes {grown:.1f} times as many blocks (limit {growth:g}); relaxed to {used * RELAXED * 1e3:g} um; "
            "--growth allows more blocks, if the control reads so many per second"
        )
        used *= RELAXED
    else:
        raise UsageError(
            f"the program grows beyond {growth:g} times its blocks at every tolerance; raise --growth"
        )
    report("running it again", 0.7)
    return _prove(work, text, lines, writer=writer, new=new, tolerance=tolerance, used=used, notes=notes)


def _read_back(work: Work, tolerance: float, notes: list[str]) -> tuple[str, list[int], Writer, Program]:
    """Rewrite and read again; where radius compensation cannot follow the added blocks, without blocks added there."""
    for beside in (True, False):
        text, lines, writer = rewrite(work, tolerance, beside)
        try:
            new = interpret(text, work.dialect.name, work.setup, work.source.name, trace=True)
            new = with_angles(new, work.machine, work.source.name)
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
    return text, lines, writer, new


def prepare(
    program: str | Path, setup: Setup, machine: MachineOfFile | Machine, dialect: str | None,
    decimals: int | None, set_here: bool, constants: Mapping[str, float] | None, carry: bool = True,
    inline: float = INLINE, surface: SurfaceErrors | None = None, orientation: bool = False,
) -> Work:  # fmt: skip
    """Read everything and refuse what must be refused."""
    source, setup, stated, name = load_program(program, setup, machine, dialect)
    _check_source(source, name)
    notes = check_state(stated, setup)
    machine, machine_file = machine_of(stated), stated.file if isinstance(stated, MachineOfFile) else None
    read = read_for("compensate", source.text, name, setup, name=source.name, trace=True)
    check_face(read, source.name)
    read = with_angles(read, machine, source.name)
    known_errors, language = _in_states(known_errors_of(machine), read), LANGUAGES[name]
    given = read, source
    short = without_length(read.moves, setup.tools)
    if short is not None:
        raise UsageError(f"{source.name}: {length_missing(short, setup.tools)}")
    check_travel(read, machine, False, source.name)
    check_moves([t.contour for t in read.traces], machine, setup, source.name)
    check_words(read, source, language)
    inline = inline if known_errors.machine.effects or surface is not None else 0.0
    source, read, origin = _flat(source, read, setup, language, inline=inline, notes=notes)
    check_program(read, machine, setup, source.name)

    columns, unsaid = with_temperatures(known_errors.machine, setup, {**setup.constants, **(constants or {})})
    field = field_of(
        known_errors, setup, read.moves, set_here=set_here, constants=columns, lathe=language.lathe
    )
    field = with_surface(field, surface, source.name)
    aim = read if orientation else None
    if orientation:
        source, read, field = correct_orientation(
            source, read, field, name, decimals=decimals, origin=origin, notes=notes
        )
    if setup.decimal_point:
        language = replace(language, decimal_point=setup.decimal_point)
    machine_data = [] if machine_file else machine_parts(machine)
    files = file_parts([setup.path, machine_file, setup.log.path if setup.log else None])
    hashed = digest([*files, *machine_data, given[1].text.encode("utf-8")])
    remarks = (
        *(*notes, *unsaid),
        *what_is_left(known_errors.left_out, surface),
        *(f"{source.name}:{w.line}: {w.text}" for w in given[0].warnings),
    )
    return Work(
        source=source,
        origin=origin,
        program=read,
        dialect=language,
        setup=setup,
        machine=machine,
        known_errors=known_errors,
        field=field,
        decimals=_decimals(given[0].traces, decimals),
        digest=hashed,
        notes=remarks,
        carry=carry,
        aim=aim,
    )


def _check_source(source: SourceText, name: str) -> None:
    check_dialect(name)
    check_mark(source)
    check_channels(source, name)
    check_wound(source, LANGUAGES[name])


def _in_states(known_errors: KnownErrors, read: Program) -> KnownErrors:
    """Return the errors that are corrected: where the tip is led over the workpiece, those that follow from the position of the axes alone."""
    if not leads(read.moves):
        return known_errors
    kept = tuple(e for e in known_errors.machine.effects if not required(e))
    rest = [e for e in known_errors.machine.effects if required(e)]
    remarks = tuple(
        f"{e.id} needs more than the position of the axes: not corrected where the tip is led" for e in rest
    )
    machine = replace(known_errors.machine, effects=kept)
    return KnownErrors(machine, machine, (*known_errors.left_out, *remarks))


def _flat(
    source: SourceText, read: Program, setup: Setup, language: Dialect, inline: float, notes: list[str]
) -> tuple[SourceText, Program, tuple[int, ...]]:  # fmt: skip
    """Return the program written out where that is needed (inline: 0, never), its meaning, and the origin of its lines."""
    traced = must_be_written_out(read.traces, source.name) if inline > 0 else None
    if traced is None:
        return source, read, tuple(range(1, len(source.lines) + 1))
    flat, origin = written_out(read, source, language, inline)
    try:
        again = interpret(flat.text, language.name, setup, source.name, trace=True)
    except (DataError, ModelLimit) as error:
        raise ModelLimit(
            f"{traced.file}:{traced.line}: the block is executed {traced.runs} times, and the program cannot be written out for each place "
            f"(lines of the written-out program: {error}); post it without subprograms and loops"
        ) from None
    check_written_out(read, again, origin, source.name)
    notes.append(
        f"blocks are executed several times (first: line {traced.line}, {traced.runs} times): the program is written out, {len(flat.lines)} lines "
        f"for {len(source.lines)}, each block with its own numbers"
    )
    return flat, again, origin


def _decimals(traces: Sequence[Trace], decimals: int | None) -> tuple[int, int]:
    out = []
    for inch in (False, True):
        words = [
            w
            for t in traces
            if (t.after.unit > 1.0) == inch
            for k, w in t.words.items()
            if k in AXES + CENTRES + "R" and w.plain
        ]
        out.append(decimals_of(words, inch, decimals))
    return out[0], out[1]


def _prove(
    work: Work, text: str, lines: list[int], writer: Writer, new: Program, tolerance: float, used: float,
    notes: list[str],
) -> CompensatedProgram:  # fmt: skip
    """Read back, compare, run again."""
    check_expressions(work.program, work.source, writer.expressions)
    mark = header(work.machine.name, used, work.digest, work.dialect)
    origin = (0, *work.origin)
    compare(work.program, new, lines, work.source.name)
    compare_comments(work.source.text, text, mark, work.dialect.name in SEMICOLON)
    check_travel(new, work.machine, True, work.source.name, lines)
    before, offset_only, shifts = with_shifts(work.program.moves, work.field)
    after = departure_by_run(work, work.known_errors, new, lines)
    paths = both_paths(work, new, lines) if work.follow else None
    whole = None
    if work.known_errors.dynamic and work.field.surface is None:
        full = work.known_errors.whole()
        whole = (
            _at(departure_by_run(work, full, work.program, ()), origin), _at(departure_by_run(work, full, new, lines), origin)
        )  # fmt: skip
    before, offset_only, after = _at(before, origin), _at(offset_only, origin), _at(after, origin)
    pointing = None if work.aim is None else pointing_of(work, work.aim, new, lines)
    rounding = _rounding(work, writer, after)
    digits = min(rounding.largest, math.sqrt(3.0) * rounding.step)  # mm that the last digit can cost
    met = after.largest <= used + digits + 1e-9
    if not met:
        _check_better(work, before, after, digits)
        notes.append(
            f"line {after.line}: {after.largest * 1e3:.2f} um are left, more than the tolerance of {used * 1e3:g} um and the rounding of "
            f"{digits * 1e3:.2f} um together{_in_one_piece(work, after.line)}"
        )
    elif after.largest > used + 1e-9:
        notes.append(_more_decimals(work, after, digits, used))
    for index in sorted(writer.expressions)[:5]:
        notes.append(f"{work.source.name}:{origin[index + 1]}: an expression has been replaced by its number")
    return CompensatedProgram(
        name=work.source.name,
        dialect=work.dialect.name,
        machine=work.machine.name,
        text=text,
        data=work.source.encode(text),
        tolerance=tolerance,
        tolerance_used=used,
        is_met=met and used == tolerance,
        before=before,
        offset_only=offset_only,
        after=after,
        shifts=shifts,
        rounding=rounding,
        blocks=_count_blocks(work, writer, new, lines),
        digest=work.digest,
        warnings=tuple(dict.fromkeys(notes)),
        source_lines=tuple(origin[n] for n in lines),
        whole=whole,
        paths=paths,
        orientation=pointing,
    )


def _check_better(work: Work, before: Departure, after: Departure, digits: float) -> None:
    """Raises ModelLimit where the new program is further off than the original. A hole and a way into radius compensation have one
    correction for two places: as large as the largest error at most, so up to twice that may be left at the other place."""
    here = [t for t in work.program.traces if work.origin[t.line - 1] == after.line]
    is_one_piece = any(t.cycle for t in here) or bool(_in_one_piece(work, after.line))
    if after.largest <= (2.0 * before.largest + digits if is_one_piece else before.largest):
        return
    raise ModelLimit(
        f"{work.source.name}: the compensated program would be worse than the original: {after.largest * 1e3:.2f} um off at line "
        f"{after.line}, where the original is off by no more than {before.largest * 1e3:.2f} um (line {before.line}); nothing was written. "
        "Write the block of that line as single moves, or see what a shift of the work offset does (--offset-only)"
    )


def _in_one_piece(work: Work, line: int) -> str:
    """Return why the block of a line of the file was not split, where radius compensation starts or ends along it."""
    traces = work.program.traces
    for before, here in pairwise(traces):
        switched = (before.compensation is None) != (here.compensation is None)
        if switched and work.origin[here.line - 1] == line and here.contour.kind == "line":
            return (
                "; radius compensation starts or ends in this block, which is one piece therefore: give it a short way in and out of "
                "its own"
            )
    return ""


def _more_decimals(work: Work, after: Departure, digits: float, used: float) -> str:
    """Return advice on decimals where the remaining error is rounding: half a digit in three axes is sqrt(3)/2 of the last one, which
    must come below the tolerance."""
    units = {t.after.unit > 1.0: t.after.unit for t in work.program.traces}
    inch = max(units, key=lambda i: units[i] * 10.0 ** -work.decimals[i])
    enough = math.ceil(math.log10(units[inch] * math.sqrt(3.0) / 2.0 / used))
    return (
        f"line {after.line}: {after.largest * 1e3:.2f} um are left, more than the tolerance of {used * 1e3:g} um by no more than the rounding "
        f"of the program's numbers ({digits * 1e3:.2f} um): write more digits, --decimals {max(work.decimals[inch] + 1, enough)}, if the "
        "control takes them; the number of blocks hangs on the tolerance, not on the digits"
    )


def _at(departed: Departure, origin: Sequence[int]) -> Departure:
    """Return the departure with the line of the file."""
    return replace(departed, line=origin[departed.line])


def _rounding(work: Work, writer: Writer, after: Departure) -> Rounding:
    """Ends as written against ends as wanted; axes that a block does not name and that were left off are in it too."""
    size = np.linalg.norm(np.array(writer.rounding).reshape(-1, 3), axis=1)
    step = max(writer.step(t.after.unit > 1.0) * t.after.unit for t in work.program.traces)
    rms = float(np.sqrt(np.mean(size**2))) if len(size) else 0.0
    share = min((rms / after.rms) ** 2, 1.0) if after.rms > 0 else 0.0
    return Rounding(step, float(size.max(initial=0.0)), rms, share)


def _count_blocks(work: Work, writer: Writer, new: Program, lines: Sequence[int]) -> BlockCounts:
    old_rate, _ = block_rate(work.program.moves)
    rate, line = block_rate(new.moves)
    return BlockCounts(
        before=len({t.line for t in work.program.traces}),
        after=len({t.line for t in new.traces}),
        changes=len(writer.edits),
        additions=sum(len(v) for v in writer.added_blocks.values()),
        rate_before=old_rate,
        rate_after=rate,
        rate_line=(0, *work.origin)[lines[line - 1]] if line else 0,
    )
