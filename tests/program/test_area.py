"""Areas of any shape: cleared wholly, and never cut beyond their walls. The check knows circles and rectangles alone."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from vcmm.core.errors import DataError, ModelLimit
from vcmm.program.area import Area, area
from vcmm.program.interpret import interpret
from vcmm.program.moves import Move
from vcmm.program.radius import HEIDENHAIN
from vcmm.program.setup import Setup

SQUARE = "G0 X0 Y0\nG1 X60\nY40\nX0\nY0"
ISLAND = "G0 X40 Y20\nG3 I-10"  # about (30, 20)
EAR = "G0 X0 Y0\nG1 X60\nY10\nG3 X50 Y20 I-10 J0\nG1 X20\nY40\nX0\nY0"  # an L, one corner rounded


def contour(text: str) -> list[Move]:
    moves = interpret(f"G21 G90 G17 F100\n{text}\nM30\n", "fanuc", Setup()).moves
    return [m for m in moves if m.kind in ("line", "arc")]


def points(made: Area, step: float, along: int) -> np.ndarray:
    """The path in steps of 0.1 mm at most, from the strokes alone."""
    out: list[tuple[float, float]] = []
    for stroke in made.strokes(step, along):
        here = stroke.start
        for piece in stroke.path:
            if piece.centre is None:
                n = max(2, math.ceil(math.dist(here, piece.end) / 0.1))
                out += [
                    (here[0] + (piece.end[0] - here[0]) * k / n, here[1] + (piece.end[1] - here[1]) * k / n)
                    for k in range(n + 1)
                ]
            else:
                c = piece.centre
                r, first = math.dist(here, c), math.atan2(here[1] - c[1], here[0] - c[0])
                last = math.atan2(piece.end[1] - c[1], piece.end[0] - c[0])
                sweep = (first - last if piece.clockwise else last - first) % (2 * math.pi) or 2 * math.pi
                n = max(2, math.ceil(r * sweep / 0.1))
                sign = -1 if piece.clockwise else 1
                out += [
                    (
                        c[0] + r * math.cos(first + sign * sweep * k / n),
                        c[1] + r * math.sin(first + sign * sweep * k / n),
                    )
                    for k in range(n + 1)
                ]
            here = piece.end
    return np.array(out)


def to_wall_of_ring(p: np.ndarray) -> np.ndarray:
    """Distance from the walls of the square pocket with its island, negative outside of the area."""
    x, y = p.T
    return np.minimum.reduce([x, 60 - x, y, 40 - y, np.hypot(x - 30, y - 20) - 10])


@pytest.mark.parametrize(("step", "along"), [(9.9, 0), (5.0, 0), (5.0, 1), (3.3, 0)])
def test_pocket_with_an_island_is_cleared_and_its_walls_stay(step: float, along: int):
    made = area([(contour(SQUARE), "left"), (contour(ISLAND), "right")], 5.0, HEIDENHAIN, "x")
    path = points(made, step, along)
    assert to_wall_of_ring(path).min() > 5.0 - 1e-6
    grid = np.stack(np.meshgrid(np.arange(0.25, 60, 0.5), np.arange(0.25, 40, 0.5)), -1).reshape(-1, 2)
    centres, tree = cKDTree(grid[to_wall_of_ring(grid) >= 5.0]), cKDTree(path)
    # asked for: what the tool can reach at all, a place of the centre within 5 mm. Corners of the square are not
    reach = grid[(to_wall_of_ring(grid) > 0) & (centres.query(grid)[0] < 4.9)]
    assert len(reach) > 6000
    assert tree.query(reach)[0].max() < 5.0 + 0.01


def test_an_l_is_cleared_round_its_inside_corner():
    made = area([(contour(EAR), "left")], 4.0, HEIDENHAIN, "x")
    path = points(made, 4.0, 0)
    x, y = path.T
    assert min(x.min(), y.min()) == pytest.approx(4.0)
    assert x.max() == pytest.approx(56.0)
    # the corner at (20, 20) stands out: no place of the centre within 4 mm of it
    assert np.hypot(x - 20, y - 20)[(x > 20) & (y > 20)].size == 0
    assert np.hypot(x - 20, y - 20).min() == pytest.approx(4.0, abs=1e-3)


def test_ways_that_cross_an_island_lift():
    made = area([(contour(SQUARE), "left"), (contour(ISLAND), "right")], 5.0, HEIDENHAIN, "x")
    assert not made.is_clear((5, 20), (55, 20))
    assert made.is_clear((5, 5), (55, 5))
    assert made.is_clear((5, 5), (5, 35))
    assert not made.is_clear((5, 5), (2, 5))


@pytest.mark.parametrize(
    ("contours", "distance", "message"),
    [
        ([(SQUARE, "left")], 25.0, "does not fit|inside corner|too"),
        ([("G0 X0 Y0\nG1 X60\nY40", "left")], 5.0, "ends where it begins; close it"),
        ([(SQUARE, "left"), ("G0 X52 Y20\nG3 I-5", "right")], 5.0, "the ways 5 mm beside the contours cross"),
        ([(SQUARE, "left"), ("G0 X152 Y20\nG3 I-5", "right")], 5.0, "an island lies outside the pockets"),
        ([(SQUARE, "left"), ("G0 X42 Y20\nG3 I-12", "left")], 5.0, "a pocket lies within another contour"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(contours, distance, message):
    with pytest.raises((DataError, ModelLimit), match=message):
        area([(contour(text), side) for text, side in contours], distance, HEIDENHAIN, "x")
