"""The page of an NC program: its path, its time and extents, tools, assumptions; and the page of a folder of programs."""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import TYPE_CHECKING

from vcmm import __version__
from vcmm.core.errors import UsageError
from vcmm.program.moves import PLANES, Move, Program
from vcmm.program.summary import ProgramSummary, arc_angle
from vcmm.show.pages.header import facts
from vcmm.show.report import blocks as r
from vcmm.show.report.path import PathPicture, path_picture
from vcmm.show.tables import program as tables
from vcmm.show.tables.answers_machine import program_answers
from vcmm.show.tables.table import html

if TYPE_CHECKING:
    from vcmm.core.machine import Machine
    from vcmm.shop.motion.toolpath import Toolpath

MOST_PIECES = 200_000  # with more a browser stops responding
CHORD_ANGLE = math.radians(6.0)


def program_page(
    name: str,
    program: Program,
    total: ProgramSummary,
    text: str,
    machine: Machine | None,
    path: Toolpath | None = None,
) -> str:
    """Return one self-contained HTML file. text: of the program, for the line under the pointer; path: its motion in time, where asked for.

    Raises UsageError without a motion.
    """
    if not program.moves:
        raise UsageError(f"{name} has no motion: there is no path to be shown")
    blocks = [r.heading("Path"), path_picture(_picture(program, text)), r.heading("Moves and extents")]
    blocks += [html(tables.kinds(name, program, total)), html(tables.extents(program, total))]
    if path is not None:
        blocks += [r.heading("Time"), html(tables.times(path))]
    if machine is not None:
        blocks += [r.heading("Travels"), html(tables.travels(program, machine))]
    if program.assumed:
        blocks += [r.heading("Assumed"), html(tables.assumption_table(name, program))]
    if program.warnings:
        blocks += [r.heading("Remarks"), html(tables.remarks(name, program))]
    why = f": {program.dialect_reason}" if program.dialect_reason else ""
    return r.page(
        f"NC program report: {name}",
        blocks,
        footer=f"vcmm {__version__}",
        answers=program_answers(program, total, path),
        facts=facts(
            "",
            machine.name if machine is not None else "",
            None,
            None,
            [("control", f"{program.dialect}{why}")],
        ),
    )


def _picture(program: Program, text: str) -> PathPicture:
    moves = program.moves if len(program.moves) <= MOST_PIECES else program.moves[:MOST_PIECES]
    points, pieces = [moves[0].start], []
    for move in moves:
        chain = _chain(move)
        points += chain
        pieces += [move] * len(chain)
    lines = text.splitlines()
    used = sorted({m.source.line for m in moves})
    shown = {n: lines[n - 1].strip()[:100] for n in used if n <= len(lines)}
    flat = all(abs(p[1] - points[0][1]) < 1e-9 for p in points)
    return PathPicture(
        points=points, line=[m.source.line for m in pieces], tool=[m.tool for m in pieces],
        feed=[None if m.feed is None else round(m.feed, 3) for m in pieces], rapid=[m.kind == "rapid" for m in pieces],
        text=shown, view="lathe" if flat else "space",
    )  # fmt: skip


def _chain(move: Move) -> list[tuple[float, float, float]]:
    """Return points behind the start of a move: chords of an arc."""
    if move.centre is None or move.clockwise is None:
        return [move.end]
    a, b, n = PLANES[move.plane]
    sweep = arc_angle(move) * (-1.0 if move.clockwise else 1.0)
    count = max(1, math.ceil(abs(sweep) / CHORD_ANGLE))
    first = math.atan2(move.start[b] - move.centre[b], move.start[a] - move.centre[a])
    r1, r2 = (math.hypot(p[a] - move.centre[a], p[b] - move.centre[b]) for p in (move.start, move.end))
    out = []
    for k in range(1, count):
        share, point = k / count, [0.0, 0.0, 0.0]
        radius, angle = r1 + (r2 - r1) * share, first + sweep * share
        point[a], point[b] = (
            move.centre[a] + radius * math.cos(angle),
            move.centre[b] + radius * math.sin(angle),
        )
        point[n] = move.start[n] + (move.end[n] - move.start[n]) * share
        out.append((point[0], point[1], point[2]))
    return [*out, move.end]


def folder_page(title: str, rows: Sequence[tables.FolderRow]) -> str:
    """Return the table over a folder, with the counts by reason."""
    blocks = [html(tables.folder_counts(rows)), html(tables.folder(title, rows))]
    if any(row.reason for row in rows):
        blocks.insert(1, html(tables.folder_reasons(rows)))
    return r.page(f"NC programs of {title}", blocks, footer=f"vcmm {__version__}")
