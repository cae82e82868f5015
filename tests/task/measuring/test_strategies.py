from __future__ import annotations

import math
from typing import Any

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.part.part import Feature, normal, signed_distance
from vcmm.task.measuring.strategies import (
    Around,
    Birdcage,
    Even,
    Grid,
    Helix,
    Iso10360,
    Latitudes,
    Levels,
    Polar,
    Ring,
    Spiral,
    Spread,
    choose,
    plan_points,
)

Z = np.array([0.0, 0.0, 1.0])
NONE = np.array([])
TOP = Feature("top", "plane", np.array([0.0, 0.0, 20.0]), Z, NONE, False, (80.0, 60.0))
BORE = Feature("bore", "cylinder", np.zeros(3), Z, np.array([15.0]), True, (20.0,))
CONE = Feature("cone", "cone", np.zeros(3), Z, np.array([5.0, math.pi / 4]), False, (20.0,))
BALL = Feature("ball", "sphere", np.array([1.0, 2.0, 3.0]), np.zeros(3), np.array([10.0]))
TORUS = Feature("tyre", "torus", np.zeros(3), Z, np.array([20.0, 4.0]))
EDGE = Feature("edge", "line", np.zeros(3), np.array([1.0, 0.0, 0.0]), NONE, False, (50.0,))
RING = Feature("ring", "circle", np.zeros(3), Z, np.array([10.0]), True)


def test_grid_runs_to_and_fro_inside_the_margin() -> None:
    points, normals = plan_points(TOP, Grid(n=(3, 2), margin=5.0))
    # 80 - 2*5 = 70 along x, 60 - 2*5 = 50 along y
    x, y = [-35, 0, 35, 35, 0, -35], [-25, -25, -25, 25, 25, 25]
    np.testing.assert_allclose(points, np.stack([x, y, [20] * 6], axis=1))
    np.testing.assert_allclose(normals, np.tile(Z, (6, 1)))


def test_one_row_of_a_grid_is_the_middle() -> None:
    points, _ = plan_points(TOP, Grid(n=(3, 1)))
    np.testing.assert_allclose(points[:, 1], 0.0)


def test_polar_rings_fit_the_shorter_side() -> None:
    points, _ = plan_points(TOP, Polar(rings=2, n=4, margin=10.0))
    radius = np.linalg.norm(points[:, :2], axis=1)  # 60/2 - 10 = 20, and half of it
    np.testing.assert_allclose(radius, [0, 10, 10, 10, 10, 20, 20, 20, 20], atol=1e-12)
    np.testing.assert_allclose(points[5], [20, 0, 20], atol=1e-12)
    assert len(plan_points(TOP, Polar(rings=1, n=6, middle=False))[0]) == 6


def test_spread_points_fill_every_quarter_alike() -> None:
    points, _ = plan_points(TOP, Spread(n=64, margin=5.0))
    assert np.abs(points[:, 0]).max() <= 35.0
    assert np.abs(points[:, 1]).max() <= 25.0
    assert [
        np.sum((points[:, 0] * sx > 0) & (points[:, 1] * sy > 0)) for sx in (1, -1) for sy in (1, -1)
    ] == [16] * 4
    # van der Corput of 0, 1, 2, 3: 0, 1/2, 1/4, 3/4, moved by half a cell of 1/4
    four, _ = plan_points(TOP, Spread(n=4))
    np.testing.assert_allclose(four[:, 1], 60.0 * (np.array([0, 0.5, 0.25, 0.75]) + 0.125 - 0.5))


def test_even_points_of_a_line_have_the_normal_of_its_surface() -> None:
    points, normals = plan_points(EDGE, Even(n=3, margin=5.0))
    np.testing.assert_allclose(points, [[5, 0, 0], [25, 0, 0], [45, 0, 0]])
    np.testing.assert_allclose(normals, np.tile([0.0, 1.0, 0.0], (3, 1)))  # u of a line along x


def test_a_full_circle_is_not_closed_but_an_arc_has_both_ends() -> None:
    points, normals = plan_points(RING, Around(4))
    np.testing.assert_allclose(points, [[10, 0, 0], [0, 10, 0], [-10, 0, 0], [0, -10, 0]], atol=1e-14)
    np.testing.assert_allclose(normals, -points / 10.0, atol=1e-15)  # a bore: towards the axis
    arc, _ = plan_points(RING, Around(3, start=math.pi / 2, sweep=math.pi / 2))
    np.testing.assert_allclose(arc[[0, 2]], [[0, 10, 0], [-10, 0, 0]], atol=1e-14)


def test_levels_of_the_contract_example() -> None:
    points, normals = plan_points(BORE, Levels(at=(5.0, 15.0), n=8))
    assert points.shape == (16, 3)
    np.testing.assert_allclose(points[0], [15, 0, 5])
    np.testing.assert_allclose(points[8], [15, 0, 15])
    np.testing.assert_allclose(normals[8], [-1, 0, 0], atol=1e-15)
    staggered, _ = plan_points(BORE, Levels(at=(5.0, 15.0), n=8, stagger=True))
    turn = math.atan2(staggered[8, 1], staggered[8, 0])  # half of 45 deg
    assert turn == pytest.approx(math.radians(22.5))


def test_levels_of_a_cone_widen() -> None:
    points, normals = plan_points(CONE, Levels(at=(0.0, 4.0), n=4))
    assert points[4] == pytest.approx([9.0, 0.0, 4.0])  # 5 + 4 tan 45
    assert normals[4] == pytest.approx([math.sqrt(0.5), 0.0, -math.sqrt(0.5)])


def test_helix_and_birdcage() -> None:
    points, _ = plan_points(BORE, Helix(n=9, turns=2.0, margin=2.0))
    np.testing.assert_allclose(points[:, 2], np.linspace(2.0, 18.0, 9))
    np.testing.assert_allclose(points[1], [0, 15, 4], atol=1e-13)  # 2 turns in 8 steps: 90 deg each
    cage, _ = plan_points(BORE, Birdcage(levels=2, n=8, lines=4, per_line=5, margin=1.0))
    assert cage.shape == (36, 3)
    np.testing.assert_allclose(
        cage[16:21], np.stack([[15] * 5, [0] * 5, [1, 5.5, 10, 14.5, 19]], axis=1), atol=1e-14
    )


def test_the_25_points_of_iso_10360_5() -> None:
    points, normals = plan_points(BALL, Iso10360())
    arm = (points - BALL.point) / 10.0
    np.testing.assert_allclose(normals, arm, atol=1e-15)
    from_pole = np.degrees(np.arccos(np.clip(arm[:, 2], -1.0, 1.0)))
    np.testing.assert_allclose(from_pole, [0] + [22.5] * 4 + [45] * 8 + [67.5] * 4 + [90] * 8, atol=1e-6)
    first = np.degrees(np.arctan2(arm[[1, 5, 13, 17], 1], arm[[1, 5, 13, 17], 0]))
    np.testing.assert_allclose(first, [0.0, 22.5, 45.0, 67.5], atol=1e-9)
    sideways, _ = plan_points(BALL, Iso10360(pole=(0.0, -1.0, 0.0)))
    np.testing.assert_allclose(sideways[0], [1, 2 - 10, 3], atol=1e-14)


def test_latitudes_and_spiral_of_a_ball() -> None:
    points, _ = plan_points(BALL, Latitudes(at=(0.0, math.pi / 6), n=4))
    np.testing.assert_allclose(points[:, 2] - 3.0, [0] * 4 + [5] * 4, atol=1e-14)
    spiral, _ = plan_points(BALL, Spiral(50))
    height = spiral[:, 2] - 3.0  # equal areas are equal heights: steps of 10/50
    np.testing.assert_allclose(height, 10.0 - 0.2 * (np.arange(50) + 0.5), atol=1e-13)


def test_grid_of_a_torus() -> None:
    points, normals = plan_points(TORUS, Ring(n=(4, 2), tube_sweep=math.pi / 2))
    np.testing.assert_allclose(points[:2], [[24, 0, 0], [20, 0, 4]], atol=1e-14)
    np.testing.assert_allclose(normals[:2], [[1, 0, 0], [0, 0, 1]], atol=1e-15)


PATTERNS = [
    (TOP, Spread(7)), (BORE, Helix(9, 2.0)), (CONE, Birdcage(2, 5, 3, 4)), (BALL, Spiral(9)), (TORUS, Ring((5, 5))),
]  # fmt: skip


@pytest.mark.parametrize(("feature", "pattern"), PATTERNS)
def test_every_point_lies_on_the_surface_with_its_normal(feature: Feature, pattern: Any) -> None:
    points, normals = plan_points(feature, pattern)
    assert np.abs(signed_distance(feature, points)).max() < 1e-13
    np.testing.assert_array_equal(normals, normal(feature, points))


def test_choose_by_name() -> None:
    assert choose("plane", "grid") is Grid
    assert choose("torus", "grid") is Ring
    with pytest.raises(UsageError, match=r'Did you mean "helix"\? Allowed: levels, helix, birdcage'):
        choose("cylinder", "helixx")
    with pytest.raises(UsageError, match="name a file of its points"):
        choose("mesh", "grid")


@pytest.mark.parametrize(
    ("feature", "pattern", "words"),
    [
        (BORE, Grid((3, 3)), "Grid does not suit a cylinder; use Levels"),
        (TOP, Grid((2, 1)), "at least 3 points, got 2"),
        (BORE, Levels((5.0,), 4), "at least 5 points, got 4"),
        (TORUS, Ring((2, 3)), "at least 7 points, got 6"),
        (TOP, Grid((3, 3), margin=30.0), "leaves nothing of 60 mm"),
        (TOP, Grid((3, 3), margin=-1.0), "margin"),
        (BORE, Levels((5.0, 25.0), 4), "between 0 and its length 20 mm"),
        (BALL, Latitudes((2.0,), 4), "90 deg"),
        (BALL, Spiral(9, reach=4.0), "reach"),
        (TOP, Grid((3, 0)), "1 or more"),
        (EDGE, Even(n=2.5), "without a fraction"),  # type: ignore[arg-type]
    ],
)
def test_patterns_that_cannot_be(feature: Feature, pattern: Any, words: str) -> None:
    with pytest.raises(UsageError, match=words):
        plan_points(feature, pattern)
