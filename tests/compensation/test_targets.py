"""Radius compensation where two arcs meet whose tangents differ by the rounding of I and J alone."""

from __future__ import annotations

import math

import pytest

from vcmm.program.offsetting import ContourPiece, NoMeeting, corner


def quarter(centre: tuple[float, float], sweep: float = math.pi / 2) -> tuple[ContourPiece, ContourPiece]:
    """A quarter about the origin to (0, 15), then an arc from there about a centre that is off by rounding."""
    first = ContourPiece((15.0, 0.0), (0.0, 15.0), (0.0, 0.0), sweep)
    cx, cy = centre
    return first, ContourPiece((0.0, 15.0), (cx - (15.0 - cy), cy), centre, sweep)


@pytest.mark.parametrize("centre", [(0.001, 0.001), (0.0005, -0.001), (0.0001, 0.002)])
def test_the_joint_stays_at_the_corner(centre):
    # parallel circles of radius 5 that nearly coincide cross anywhere: (0.001, 0.001) gives 3.5 mm along (1, 1) / sqrt 2
    first, second = quarter(centre)
    joint = corner(first, second, 10.0, "lines")
    assert math.dist(joint.end, (0.0, 5.0)) < 10.0 * 1.5e-4  # h times the kink, 1e-3 / 15 rad and less
    for piece in (first, second):
        assert math.dist(joint.end, piece.centre) == pytest.approx(
            math.dist(piece.start, piece.centre) - 10.0, abs=1e-5
        )


def test_a_true_inside_corner_without_a_meeting_is_still_refused():
    first = ContourPiece((15.0, 0.0), (0.0, 15.0), (0.0, 0.0), math.pi / 2)
    second = ContourPiece((0.0, 15.0), (0.0, 27.0), (0.5, 21.0), math.pi)  # turns by a right angle and more
    with pytest.raises(NoMeeting):
        corner(first, second, 5.9, "lines")
