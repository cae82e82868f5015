"""Pieces of a contour and their parallel curves, by hand."""

from __future__ import annotations

import math

import pytest

from vcmm.program.moves import Move, Source
from vcmm.program.offsetting import (
    ContourPiece,
    NoMeeting,
    _beside_both,
    corner,
    in_space,
    is_inside,
    parallel_radius,
    piece_of,
    planar,
    sweep_of,
    tangent,
    trimmed_sweep,
    turn_between,
)

EAST, NORTH = ContourPiece((0.0, 0.0), (10.0, 0.0)), ContourPiece((10.0, 0.0), (10.0, 10.0))
QUARTER = ContourPiece((10.0, 0.0), (0.0, 10.0), (0.0, 0.0), math.pi / 2)


def test_corners_of_two_lines():
    # h = 2 to the left is inside: the parallels y = 2 and x = 8 meet in (8, 2); to the right outside, (12, -2) as lines
    assert turn_between(EAST, NORTH) == pytest.approx(math.pi / 2)
    assert is_inside(EAST, NORTH, 2.0)
    assert not is_inside(EAST, NORTH, -2.0)
    assert corner(EAST, NORTH, 2.0, "arc").end == pytest.approx((8.0, 2.0))
    round_way = corner(EAST, NORTH, -2.0, "arc")
    assert (round_way.end, round_way.start, round_way.pivot) == ((10.0, -2.0), (12.0, 0.0), (10.0, 0.0))
    assert corner(EAST, NORTH, -2.0, "lines").end == pytest.approx((12.0, -2.0))


def test_a_line_that_meets_no_parallel_arc():
    # the half circle of radius 5 about (5, 0): inside by 4 it has radius 1 and stays below y = 4
    half = ContourPiece((10.0, 0.0), (0.0, 0.0), (5.0, 0.0), math.pi)
    assert corner(EAST, half, 2.0, "arc").end == pytest.approx((5.0 + math.sqrt(5.0), 2.0))
    with pytest.raises(NoMeeting):
        corner(EAST, half, 4.0, "arc")


def test_arcs():
    assert tangent(QUARTER, QUARTER.start) == pytest.approx((0.0, 1.0))
    assert parallel_radius(QUARTER, 3.0) == pytest.approx(7.0)  # to the left of a counterclockwise arc
    assert parallel_radius(QUARTER, -3.0) == pytest.approx(13.0)
    assert sweep_of((10.0, 0.0), (0.0, 10.0), (0.0, 0.0), True, 1) == pytest.approx(-1.5 * math.pi)
    assert sweep_of((10.0, 0.0), (10.0, 0.0), (0.0, 0.0), False, 2) == pytest.approx(4 * math.pi)
    middle = 5 * math.sqrt(2.0)
    assert trimmed_sweep(QUARTER, (10.0, 0.0), (middle, middle)) == pytest.approx(math.pi / 4)


def test_moves_as_pieces():
    move = Move(
        "arc",
        Source(1, 1, 2),
        (5.0, 10.0, 0.0),
        (5.0, 0.0, 10.0),
        plane="YZ",
        centre=(5.0, 0.0, 0.0),
        clockwise=False,
    )
    piece = piece_of(move)
    assert piece[:3] == QUARTER[:3]
    assert piece.sweep == pytest.approx(math.pi / 2)
    assert planar(move)
    assert not planar(Move("line", Source(1, 1, 2), (0.0, 0.0, 1.0), (0.0, 0.0, 2.0)))
    assert in_space("ZX", (1.0, 2.0), 3.0) == (2.0, 3.0, 1.0)


def test_a_shared_point_of_two_smooth_pieces_by_hand():
    # h 5, turn 0.01: 5 x 1e-4 / 8 = 6.25e-5 inside the rounding; beside a parallel arc of 15 + 5 = 20: 0.05^2 / 160 = 1.5625e-5
    before = ContourPiece((0.0, 0.0), (10.0, 0.0))
    after = ContourPiece((10.0, 0.0), (25.0, -15.0), (10.0, -15.0), -math.pi / 2)
    assert _beside_both(before, before, 5.0, 0.01) == pytest.approx(6.25e-5)
    assert _beside_both(before, after, 5.0, 0.01) == pytest.approx(6.25e-5 + 1.5625e-5)
    assert _beside_both(after, after, 5.0, 0.01) == pytest.approx(6.25e-5 + 2 * 1.5625e-5)
