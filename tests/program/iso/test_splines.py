"""G5 and G5.1 of LinuxCNC: Bezier curves by de Casteljau's construction, which shares nothing with the sum of the program."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup

HEAD = "G21 G90 G17\nG1 X0 Y0 F100\n"


def path(text: str) -> np.ndarray:
    moves = interpret(HEAD + text + "\nM2\n", "linuxcnc", Setup(strict=True)).moves
    return np.array([m.end[:2] for m in moves])


def casteljau(points, t: float) -> np.ndarray:
    points = np.array(points, dtype=float)
    while len(points) > 1:
        points = (1 - t) * points[:-1] + t * points[1:]
    return points[0]


def farthest(points, ends: np.ndarray) -> float:
    """Largest distance of the curve from the chords, mm."""
    a, b = ends[:-1], ends[1:]
    worst = 0.0
    for t in np.linspace(0, 1, 801):
        p = casteljau(points, t)
        share = np.clip(((p - a) * (b - a)).sum(axis=1) / ((b - a) ** 2).sum(axis=1), 0, 1)
        worst = max(worst, np.linalg.norm(a + share[:, None] * (b - a) - p, axis=1).min())
    return worst


def test_a_cubic_spline_by_pencil():
    """The example of the manual, I0 J3 P0 Q-3 X1 Y1: control points (0, 3) and (1, -2). At 1/4: x = 3 (1/4)^2 (3/4) + (1/4)^3 = 0.15625,
    y = 9 (1/4) (3/4)^2 - 6 (1/4)^2 (3/4) + (1/4)^3 = 1.0."""
    points = [(0, 0), (0, 3), (1, -2), (1, 1)]
    assert casteljau(points, 0.25) == pytest.approx([0.15625, 1.0])
    ends = path("G5 I0 J3 P0 Q-3 X1 Y1")
    assert ends[-1] == pytest.approx([1, 1])
    assert farthest(points, ends) < 1.0e-3
    assert np.linalg.norm(ends - [0.15625, 1.0], axis=1).min() < 0.05  # a chord ends near it


def test_a_spline_goes_on_in_the_direction_of_the_one_before():
    """Behind Q-3 the next begins with J+3: control points (1, 4), (4, 4), end (3, 3)."""
    first = len(path("G5 I0 J3 P0 Q-3 X1 Y1"))
    ends = path("G5 I0 J3 P0 Q-3 X1 Y1\nG5 P1 Q1 X3 Y3")[first - 1 :]
    assert farthest([(1, 1), (1, 4), (4, 4), (3, 3)], ends) < 1.0e-3
    with pytest.raises(DataError, match="G5 without I and J goes on from another G5"):
        path("G5 P1 Q1 X3 Y3")


def test_a_quadratic_spline_by_pencil():
    """The parabola of the manual: from (-2, 4) by the control point (0, -4) to (2, 4) it is y = x^2."""
    ends = path("G1 X-2 Y4\nG5.1 X2 I2 J-8")[1:]
    assert ends[:, 1] == pytest.approx(ends[:, 0] ** 2, abs=1e-12)
    assert farthest([(-2, 4), (0, -4), (2, 4)], ends) < 1.0e-3


@pytest.mark.parametrize(
    ("block", "said"),
    [
        ("G5 I0 J3 X1 Y1", "G5 needs P and Q"), ("G5 I1 P1 Q1 X3 Y3", "G5 takes I and J together"),
        ("G5 I0 J3 P0 Q-3 X1 Y1 Z1", "G5 moves X and Y alone"), ("G18 G5 I0 J3 P0 Q-3 X1 Y1", "lies in the plane XY"),
        ("G5.1 X2", "G5.1 needs I or J"),
    ],
)  # fmt: skip
def test_where_the_control_stops(block, said):
    with pytest.raises(DataError, match=said):
        path(block)
