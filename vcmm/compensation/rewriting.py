"""Rewrite every block of the source with its new numbers, and put the mark in front."""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.compensation.contours import length_of
from vcmm.compensation.drilling_cycles import drill_here, straighten_holes
from vcmm.compensation.field import KnownErrors, PathErrors
from vcmm.compensation.fitting import BlockFit
from vcmm.compensation.frame import AXES
from vcmm.compensation.header import SEMICOLON, header, place
from vcmm.compensation.holes import drill
from vcmm.compensation.languages import writer_of
from vcmm.compensation.refusals import codes_of
from vcmm.compensation.source import SourceText, at_line
from vcmm.compensation.targets import moves_of, targets
from vcmm.compensation.writer import CHAINED_BLOCK_MM, Writer
from vcmm.core.errors import DataError
from vcmm.core.machine import Machine
from vcmm.program.dialects import Dialect
from vcmm.program.moves import PLANES, Program
from vcmm.program.setup import Setup
from vcmm.program.trace import Trace

FIT_SHARE = 0.7  # of the tolerance for what lies between the ends of blocks; the rest is for the ends
SLACK = 0.3  # of the tolerance: an axis that a block does not name is corrected only where it is off by more


@dataclass(frozen=True, eq=False)
class Work:
    """Everything that is known before rewriting."""

    source: SourceText  # written out where blocks are executed several times
    origin: tuple[int, ...]  # line of the file that each line of `source` comes from
    program: Program
    dialect: Dialect
    setup: Setup
    machine: Machine
    known_errors: KnownErrors
    field: PathErrors
    decimals: tuple[int, int]
    digest: str
    notes: tuple[str, ...]
    carry: bool
    follow: bool = False  # keep the paths with their errors
    aim: Program | None = None  # as the tool was to point, where its angles have been corrected

    @property
    def corrects(self) -> bool:
        """Whether there is anything that a path can correct."""
        return bool(self.known_errors.machine.effects) or self.field.surface is not None


def rewrite(work: Work, tolerance: float, beside: bool = True) -> tuple[str, list[int], Writer]:
    """Return the new text, the source line (from 1, 0 for the mark) of each of its lines, and the writer's tallies."""
    traces = work.program.traces
    codes = codes_of(work.source, work.dialect)
    index = moves_of(traces, work.program.moves)
    of_lines = [codes[t.line - 1] for t in traces]
    fits: Sequence[BlockFit | None] = targets(
        traces, work.field, index, FIT_SHARE * tolerance, of_lines, beside
    )
    first = traces[0].contour
    if work.dialect.name in SEMICOLON:
        fits = straighten_holes(traces, fits)
    writer = writer_of(work.dialect)(
        work.source,
        work.dialect,
        work.decimals,
        np.array(first.start) + np.array(first.tool_offset),
        "".join(work.machine.axes),
        work.carry,
        slack=SLACK * tolerance,
    )
    at, moving = 0, np.array([i for i, t in enumerate(traces) if t.contour.kind != "dwell"], dtype=np.intp)
    while at < len(traces):
        to = at + 1
        while to < len(traces) and traces[to].line == traces[at].line and to - at < len(traces):
            to += 1
        before, behind = np.searchsorted(moving, (at, to))
        left = traces[moving[before - 1]] if before else None
        then = traces[moving[behind]] if behind < len(moving) else None
        _look_ahead(writer, traces[at:to], left, then, work, tolerance)
        _block(writer, traces[at:to], fits[at:to], work)
        at = to
    return (*_assemble(work, writer, tolerance), writer)


def _look_ahead(
    writer: Writer, traces: Sequence[Trace], left: Trace | None, then: Trace | None, work: Work, tolerance: float
) -> None:  # fmt: skip
    """Compute how far off a block may leave an axis that it does not name, from the moves before it (left) and behind it (then)."""
    following = None if then is None else then.contour
    cuts = any(
        m is not None and m.kind in ("line", "arc")
        for m in (None if left is None else left.contour, following)
    )
    writer.rapid = FIT_SHARE * tolerance if cuts else math.inf
    writer.chain_ends = (
        following is None or following.kind != "line" or length_of(following) > CHAINED_BLOCK_MM
    )
    hole = next((t for t in (*traces[1:], then) if t is not None and t.cycle), None)
    writer.above = None
    if hole is not None and work.dialect.name in SEMICOLON and not traces[0].cycle:
        writer.rapid, writer.above = writer.slack, PLANES[hole.contour.plane][2]


def _block(writer: Writer, traces: Sequence[Trace], fits: Sequence[BlockFit | None], work: Work) -> None:
    """Write one block of the source with all its moves."""
    first = traces[0]
    if first.contour.kind == "dwell" and not first.cycle:
        return
    if not first.contour.rewritable:
        _machine_move(writer, traces, work.dialect)
        return
    if first.runs > 1 and not work.corrects:
        last = traces[-1].contour
        writer.q = np.array(last.end) + np.array(last.tool_offset)
        return
    if first.runs > 1:
        message = (
            f"the block is executed {first.runs} times (loop or subprogram), and the correction depends on the place: have the "
            "program written out (--inline), or post it without subprograms and loops"
        )
        raise at_line(DataError, first.file, first.line, message, first.contour.source.first)
    if work.dialect.name in SEMICOLON:
        _with_holes(writer, traces, fits)
        return
    if first.cycle:
        drill(writer, traces, fits)
        return
    writer.cycle.clear()
    begin = writer.q.copy()
    assert fits[0] is not None
    writer.move(first, fits[0])
    if len(traces) > 1:
        back = traces[-1].contour
        if len(traces) > 2 or back.kind != "thread" or back.end != first.contour.start:
            message = f"a block of several moves ({first.after.motion}) is not rewritten; write its moves one by one"
            raise at_line(DataError, first.file, first.line, message, first.contour.source.first)
        writer.q = begin  # a rigid tap comes back to where it began


def _with_holes(writer: Writer, traces: Sequence[Trace], fits: Sequence[BlockFit | None]) -> None:
    """Write a block of Sinumerik or Klartext: its own moves, then the hole that it calls."""
    from vcmm.compensation.klartext_writer import KlartextWriter

    moves = [i for i, t in enumerate(traces) if not t.cycle and t.contour.kind != "dwell"]
    holes = [i for i, t in enumerate(traces) if t.cycle]
    last = fits[moves[-1]] if moves else None
    if moves and last is not None:
        if (
            isinstance(writer, KlartextWriter)
            and "path" in traces[0].words
            and traces[0].words["path"].text == "DEP"
        ):
            writer.leave([traces[i] for i in moves], last)
        elif len(moves) == 1:
            writer.move(traces[moves[0]], last)
        else:
            first = traces[0]
            message = "a block of several moves is not rewritten; write its moves one by one"
            raise at_line(DataError, first.file, first.line, message, first.contour.source.first)
    if holes:
        drill_here(writer, [traces[i] for i in holes], [fits[i] for i in holes])


def _machine_move(writer: Writer, traces: Sequence[Trace], dialect: Dialect) -> None:
    """Write G28, G30, G53: the named axes go to a machine position, the others stay where the new program has them."""
    last = traces[-1]
    named = [a for a in AXES if a in last.words or f"{a}1" in last.words]
    everything = not any(a in last.words for a in "XYZABC") and dialect.words == "o"
    end = np.array(last.contour.end) + np.array(last.contour.tool_offset)
    for i, letter in enumerate(AXES):
        if everything or letter in named:
            writer.q[i] = end[i]
    writer.cycle.clear()


def _assemble(work: Work, writer: Writer, tolerance: float) -> tuple[str, list[int]]:
    """Return the text with its mark."""
    mark = header(work.machine.name, tolerance, work.digest, work.dialect)
    at, text, lines = place(work.source, work.dialect), [], []
    body = writer.lines()
    for number, (line, index) in enumerate([*body, ("", len(work.source.lines))]):
        if index == at and (number == 0 or body[number - 1][1] != at):
            text += [m + work.source.end for m in mark]
            lines += [0] * len(mark)
        text.append(line)
        lines.append(index + 1)
    return "".join(text), lines[:-1]
