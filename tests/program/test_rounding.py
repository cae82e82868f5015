"""Rounded and chamfered corners, by hand."""

from __future__ import annotations

import math

import pytest

from vcmm.program.faults import ProgramLimit
from vcmm.program.moves import Move, Source
from vcmm.program.rounding import RoundedCorner, round_corners

AT = Source(3, 1, 9)


def line(start, end):
    return Move("line", Source(2, 1, 2), start, end, feed=100.0)


LEFT_TURN = [line((0.0, 0.0, 5.0), (10.0, 0.0, 5.0)), line((10.0, 0.0, 5.0), (10.0, 10.0, 5.0))]


def test_a_radius_touches_both_lines():
    # radius 3 at a left turn of 90 deg: from (7, 0) to (10, 3) about (7, 3)
    moves, states = round_corners(LEFT_TURN, "ab", [RoundedCorner(0, "round", 3.0, AT, 50.0)])
    assert [m.end for m in moves] == [(7.0, 0.0, 5.0), (10.0, 3.0, 5.0), (10.0, 10.0, 5.0)]
    assert (moves[1].kind, moves[1].centre, moves[1].clockwise, moves[1].feed) == (
        "arc",
        (7.0, 3.0, 5.0),
        False,
        50.0,
    )
    assert states == ["a", "b", "b"]


def test_chamfers_along_and_across():
    # 2 off each side; 2 across a right angle is sqrt 2 off each side
    moves, _ = round_corners(LEFT_TURN, "ab", [RoundedCorner(0, "chamfer", 2.0, AT)])
    assert [m.end[:2] for m in moves] == [(8.0, 0.0), (10.0, 2.0), (10.0, 10.0)]
    moves, _ = round_corners(LEFT_TURN, "ab", [RoundedCorner(0, "width", 2.0, AT)])
    assert moves[0].end[0] == pytest.approx(10.0 - math.sqrt(2.0))
    assert moves[1].feed == 100.0


@pytest.mark.parametrize(
    ("size", "what"), [(11.0, "does not fit"), (3.0, "a move in the plane before and after")]
)
def test_what_does_not_fit_is_refused_at_its_block(size, what):
    moves = LEFT_TURN if size > 10 else LEFT_TURN[:1]
    with pytest.raises(ProgramLimit, match=what) as limit:
        round_corners(moves, "ab"[: len(moves)], [RoundedCorner(0, "round", size, AT)], "p.h")
    assert (limit.value.file, limit.value.line, limit.value.column) == ("p.h", 3, 1)
