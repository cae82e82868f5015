"""Paths worked out by hand from the manuals, written short, and compared with what a program is read as.

`R 10 0 5 ; L . . -1 ; A 0 10 . (0 0 +)`: a rapid, a line and an arc by their ends in mm; a point is the coordinate as before, and
the bracket holds the centre in both axes of the plane and the sense, + counter-clockwise. T is a thread, D a dwell in seconds.
"""

from __future__ import annotations

import re
from collections.abc import Sequence

import pytest

from vcmm.program.interpret import interpret
from vcmm.program.moves import PLANES, Move
from vcmm.program.setup import Setup, Tool

SETUP = Setup(
    offsets={"G54": (0.0, 0.0, 0.0), "G55": (100.0, 50.0, -10.0)},
    tools={1: Tool(1, 0.0, 10.0), 2: Tool(2, 20.0, 8.0), 3: Tool(3, 0.0, 4.0)},
    strict=False,
)
KINDS = {"R": "rapid", "L": "line", "A": "arc", "T": "thread", "D": "dwell"}
Row = tuple[str, tuple[float, ...], tuple[float, float] | None, bool | None]


def expected(path: str) -> list[Row]:
    rows: list[Row] = []
    here = [0.0, 0.0, 0.0]
    for one in filter(None, (part.strip() for part in re.split(r"[;\n]", path))):
        text, _, arc = one.partition("(")
        kind, *words = text.split()
        if kind == "D":
            rows.append(("dwell", (float(words[0]),), None, None))
            continue
        here = [here[i] if word == "." else float(word) for i, word in enumerate(words)]
        centre = arc.rstrip(" )").split()
        at = (float(centre[0]), float(centre[1])) if centre else None
        rows.append((KINDS[kind], tuple(here), at, centre[2] == "-" if centre else None))
    return rows


def found(moves: Sequence[Move]) -> list[Row]:
    rows: list[Row] = []
    for m in moves:
        if m.kind == "dwell":
            rows += [("dwell", (m.seconds,), None, None)] if m.seconds else []
        elif m.kind == "arc" or m.start != m.end:
            a, b, _ = PLANES[m.plane]
            at = None if m.centre is None else (m.centre[a], m.centre[b])
            rows.append((m.kind, m.end, at, m.clockwise))
    return rows


def check(dialect: str, text: str, path: str, setup: Setup = SETUP) -> None:
    """The whole path, to 0.1 um of what was written down."""
    have, want = found(interpret(text, dialect, setup).moves), expected(path)
    for i, (one, two) in enumerate(zip(have, want)):
        assert (one[0], one[3]) == (two[0], two[3]), f"move {i}: {one}, by hand {two}"
        assert one[1] == pytest.approx(two[1], abs=1e-4), f"move {i}: {one}, by hand {two}"
        assert one[2] == (two[2] if two[2] is None else pytest.approx(two[2], abs=1e-4)), f"move {i}: {one}, by hand {two}"  # fmt: skip
    assert len(have) == len(want), f"by hand {len(want)} moves; over: {have[len(want) :]} {want[len(have) :]}"
