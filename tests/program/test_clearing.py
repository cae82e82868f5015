"""Rings and rows that clear a pocket."""

from __future__ import annotations

import math

import pytest

from vcmm.program.clearing import PathPiece, circle, rectangle, rings, rows, shift_pieces, turn_piece


def test_rings_are_equal_and_at_most_a_step_apart():
    assert rings(10.0, 4.0) == pytest.approx([10 / 3, 20 / 3, 10])
    assert rings(10.0, 0.0) == [10.0]
    assert rings(0.0, 4.0) == [0.0]


def test_a_rectangle_from_the_middle_outwards():
    """15 x 10 by 5: rings 10 x 5 and 15 x 10, the last with corners of 2."""
    path = rectangle((15.0, 10.0), 5.0, corner=2.0)
    assert path[0].end == (10.0, 0.0)
    assert max(p.end[0] for p in path) == 15
    assert min(p.end[1] for p in path) == -10
    arcs = [p for p in path if p.centre is not None]
    assert len(arcs) == 4
    assert not any(p.clockwise for p in arcs)
    assert arcs[0].centre == (13.0, 8.0)
    back = rectangle((15.0, 10.0), 5.0, corner=2.0, clockwise=True)
    assert back[2].end[1] < 0
    assert all(p.clockwise for p in back if p.centre is not None)


def test_turned_and_moved():
    (piece,) = shift_pieces([turn_piece(PathPiece((1.0, 0.0), (2.0, 0.0)), math.pi / 2)], (10.0, 20.0))
    assert piece.end == pytest.approx((10, 21))
    assert piece.centre == pytest.approx((10, 22))


def test_circles_and_rows():
    assert [p.end[0] for p in circle(6.0, 3.0)] == [3, 3, 6, 6]
    assert rows((0.0, 0.0), (10.0, 4.0), 2) == [(0, 0), (10, 0), (10, 4), (0, 4)]
