"""Areas of any shape: cleared wholly, and never cut beyond their walls. The check knows circles and rectangles alone."""

from __future__ import annotations

import math

import numpy as np
import pytest
from scipy.spatial import cKDTree

from vcmm.core.errors import DataError
from vcmm.program.area import Area, area
from vcmm.program.interpret import interpret
from vcmm.program.moves import Move
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
    made = area([(contour(SQUARE), "left"), (contour(ISLAND), "right")], 5.0)
    path = points(made, step, along)
    assert to_wall_of_ring(path).min() > 5.0 - 1e-6
    grid = np.stack(np.meshgrid(np.arange(0.25, 60, 0.5), np.arange(0.25, 40, 0.5)), -1).reshape(-1, 2)
    centres, tree = cKDTree(grid[to_wall_of_ring(grid) >= 5.0]), cKDTree(path)
    # asked for: what the tool can reach at all, a place of the centre within 5 mm. Corners of the square are not
    reach = grid[(to_wall_of_ring(grid) > 0) & (centres.query(grid)[0] < 4.9)]
    assert len(reach) > 6000
    assert tree.query(reach)[0].max() < 5.0 + 0.01


def test_an_l_is_cleared_round_its_inside_corner():
    made = area([(contour(EAR), "left")], 4.0)
    path = points(made, 4.0, 0)
    x, y = path.T
    assert min(x.min(), y.min()) == pytest.approx(4.0)
    assert x.max() == pytest.approx(56.0)
    # the corner at (20, 20) stands out: no place of the centre within 4 mm of it
    assert np.hypot(x - 20, y - 20)[(x > 20) & (y > 20)].size == 0
    assert np.hypot(x - 20, y - 20).min() == pytest.approx(4.0, abs=1e-3)


def test_ways_that_cross_an_island_lift():
    made = area([(contour(SQUARE), "left"), (contour(ISLAND), "right")], 5.0)
    assert not made.is_clear((5, 20), (55, 20))
    assert made.is_clear((5, 5), (55, 5))
    assert made.is_clear((5, 5), (5, 35))
    assert not made.is_clear((5, 5), (2, 5))


@pytest.mark.parametrize(
    ("contours", "distance", "message"),
    [
        ([(SQUARE, "left")], 25.0, "the tool fits in nowhere"),
        ([("G0 X0 Y0\nG1 X60\nY40", "left")], 5.0, "ends where it begins; close it"),
        ([(SQUARE, "right")], 5.0, "outside of every contour"),
        ([(SQUARE, "left"), ("G0 X80 Y20\nG3 I-50", "right")], 5.0, "the tool fits in nowhere"),
    ],
)  # fmt: skip
def test_what_does_not_fit_is_refused(contours, distance, message):
    with pytest.raises(DataError, match=message):
        area([(contour(text), side) for text, side in contours], distance)


def check_free(path: np.ndarray, walls, off: float) -> None:
    """walls: distance of points from the wall, negative outside. Nothing too near, and all that can be reached is cut."""
    assert walls(path).min() > off - 1e-6
    grid = np.stack(np.meshgrid(np.arange(-59.75, 100, 0.5), np.arange(-49.75, 60, 0.5)), -1).reshape(-1, 2)
    reach = grid[(walls(grid) > 0) & (cKDTree(grid[walls(grid) >= off]).query(grid)[0] < off - 0.1)]
    assert len(reach) > 1000
    assert cKDTree(path).query(reach)[0].max() < off + 0.06


def test_pockets_that_overlap_are_one():
    """Manual, "overlapping contours": circles of 25 about (0, 0) and (30, 0); their walls meet at (15, +-20), which the tool rounds."""

    def walls(p: np.ndarray) -> np.ndarray:
        x, y = p.T
        one, two = 25 - np.hypot(x, y), 25 - np.hypot(x - 30, y)
        tips = np.minimum(np.hypot(x - 15, y - 20), np.hypot(x - 15, y + 20))
        # a wall of one circle counts where it lies outside of the other; seen from a point, where its foot does
        foot_one = 25 * np.stack([x, y]) / np.maximum(np.hypot(x, y), 1e-12)
        foot_two = 25 * np.stack([x - 30, y]) / np.maximum(np.hypot(x - 30, y), 1e-12) + np.array([[30], [0]])
        d1 = np.where(np.hypot(foot_one[0] - 30, foot_one[1]) >= 25, np.abs(one), np.inf)
        d2 = np.where(np.hypot(*foot_two) >= 25, np.abs(two), np.inf)
        return np.where((one > 0) | (two > 0), np.minimum.reduce([d1, d2, tips]), -1.0)

    made = area([(contour("G0 X25 Y0\nG3 I-25"), "left"), (contour("G0 X55 Y0\nG3 I-25"), "left")], 6.0)
    assert len(made.rings) == 1
    check_free(points(made, 6.0, 0), walls, 6.0)


def test_an_island_at_the_wall_leaves_two_sides():
    """The island of 10 mm about (30, 12) leaves 2 mm to the wall: the tool of 5 mm does not pass there, and goes round the other way."""

    def walls(p: np.ndarray) -> np.ndarray:
        x, y = p.T
        return np.minimum.reduce([x, 60 - x, y, 40 - y, np.hypot(x - 30, y - 12) - 10])

    made = area([(contour(SQUARE), "left"), (contour("G0 X40 Y12\nG3 I-10"), "right")], 5.0)
    assert len(made.rings) == 1
    check_free(points(made, 5.0, 0), walls, 5.0)


def test_a_neck_makes_two_areas():
    """Two squares of 30 joined by a neck of 8: with 5 mm from each wall there are two rings; the way from one to the other is not clear.
    They reach to 3 mm before the neck (3, 4, 5: 4 mm beside its corners)."""
    text = "G0 X0 Y0\nG1 X30\nY11\nX50\nY0\nX80\nY30\nX50\nY19\nX30\nY30\nX0\nY0"
    made = area([(contour(text), "left")], 5.0)
    assert len(made.rings) == 2
    assert not made.is_clear((20, 15), (60, 15))
    assert {round(p.start[0], 6) for r in made.rings for p in r} == {5, 25, 27, 53, 55, 75}
