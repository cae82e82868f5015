"""Arcs that fit but for the rounding of their numbers: kept while a program is read, and noted in one line of each kind."""

from __future__ import annotations

from typing import NamedTuple

from vcmm.program.moves import Remark
from vcmm.program.recorder import Recorder

MOST_NAMED = 5  # lines that are named
MANY = {
    "radii": "{n} arcs have radii at start and end that differ by more than 1 um, by {most:.1f} um at most (line {line}); the end points "
    "are kept, the radii change evenly on the way; lines {lines}",
    "R": "{n} arcs have an R that is smaller than half the distance, by {most:.2f} um at most (line {line}); half circles are taken; lines {lines}",
}  # fmt: skip


class ArcMisfit(NamedTuple):
    """kind: a key of MANY. um: by how much; text: the sentence where it is the only one."""

    kind: str
    line: int
    column: int
    um: float
    text: str


def tell_misfits(c: Recorder, misfits: list[ArcMisfit]) -> None:
    """Add one remark of each kind, at the first of its arcs."""
    for kind, text in MANY.items():
        rows = [m for m in misfits if m.kind == kind]
        if not rows:
            continue
        lines = list(dict.fromkeys(m.line for m in rows))
        more = f" and {len(lines) - MOST_NAMED} more" if len(lines) > MOST_NAMED else ""
        places = ", ".join(map(str, lines[:MOST_NAMED])) + more
        worst = max(rows, key=lambda m: m.um)
        message = text.format(n=len(rows), most=worst.um, line=worst.line, lines=places)
        c.remarks.append(Remark(rows[0].line, rows[0].column, rows[0].text if len(rows) == 1 else message))
