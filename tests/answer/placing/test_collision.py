"""Distances of tools to solids: numbers by hand, and dense sampling that shares no code with the branch and bound."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.answer.placing.collision import Bodies, _half_diagonal, missing_clearance, rods, slack
from vcmm.answer.placing.material import analytic_solid
from vcmm.answer.placing.solid import Cuboid
from vcmm.core.pose import Pose
from vcmm.part.part import Feature, Part

Z = np.array([0.0, 0.0, 1.0])


CUBE = Cuboid(Pose.identity(), np.array([10.0, 10.0, 10.0]))


def block() -> Part:
    """80 x 80 x 20 mm with a through bore of 30 mm, its top at z = 20."""
    top = Feature("top", "plane", np.array([0, 0, 20.0]), Z, np.zeros(0), extent=(80.0, 80.0))
    bottom = Feature("bottom", "plane", np.zeros(3), -Z, np.zeros(0), extent=(80.0, 80.0))
    bore = Feature("bore", "cylinder", np.zeros(3), Z, np.array([15.0]), inside=True, extent=(20.0,))
    return Part({f.name: f for f in (top, bottom, bore)})


def in_block(p):
    """The same material, written down independently."""
    inside = (np.abs(p[..., 0]) <= 40) & (np.abs(p[..., 1]) <= 40) & (p[..., 2] >= 0) & (p[..., 2] <= 20)
    return inside & (np.hypot(p[..., 0], p[..., 1]) >= 15)


def test_capsule_beside_a_cube_by_hand():
    # a shaft of radius 1 along z at x = 14 is 14 - 10 - 1 = 3 mm away; it needs 2: 1 mm is left
    shaft = rods(np.array([[14.0, 0.0, -5.0]]), np.array([[14.0, 0.0, 80.0]]), np.array([1.0]))
    assert 0.0 < slack(CUBE, shaft, np.array([2.0]))[0] <= 1.0
    # with 4 mm due it lacks 1 mm
    assert slack(CUBE, shaft, np.array([4.0]))[0] == pytest.approx(-1.0, abs=0.11)
    # swept by 3 mm towards the cube it touches: what it lacks of 0.5 mm is 0.5
    swept = shaft.swept_volume(np.zeros((1, 3)), np.array([[-3.0, 0.0, 0.0]]))
    assert slack(CUBE, swept, np.array([0.5]))[0] == pytest.approx(-0.5, abs=0.06)


def test_the_corners_of_a_round_head_do_not_count():
    # a head of radius 30 whose axis passes the edge of the cube at a diagonal distance of 31 mm is clear; a square is not
    middle = 10.0 + 31.0 / np.sqrt(2.0)
    edges = np.zeros((1, 4, 3))
    edges[0, 0, 0], edges[0, 1, 1], edges[0, 2, 2] = 30.0, 30.0, 50.0
    centre = np.array([[middle, middle, 0.0]])
    square = Bodies(centre, edges, np.zeros(1), np.zeros(1))
    round_ = Bodies(centre, edges, np.zeros(1), np.array([30.0]))
    assert slack(CUBE, square, np.zeros(1))[0] < -5.0
    assert slack(CUBE, round_, np.zeros(1))[0] > 0.0


def test_swept_tools_against_dense_sampling():
    """1000 random shafts, moving or not: none that is called clear touches the block or comes nearer than it must."""
    clear, near, wrong = random_checks(1000, seed=7)
    assert wrong == 0
    assert clear > 200  # the check can fail: enough of both kinds
    assert near > 200


def random_checks(n: int, seed: int) -> tuple[int, int, int]:
    """(called clear, not clear, called clear although a sampled point of the tool is in the material or too near)."""
    rng = np.random.default_rng(seed)
    start = rng.uniform([-60, -60, -10], [60, 60, 60], (n, 3))
    end = start + rng.normal(size=(n, 3)) * 25.0
    move = rng.normal(size=(n, 3)) * 8.0 * rng.integers(0, 2, (n, 1))
    radius, need = rng.uniform(0.3, 3.0, n), rng.uniform(0.0, 3.0, n)
    bodies = rods(start, end, radius).swept_volume(np.zeros((n, 3)), move)
    room = slack(analytic_solid(block(), 5.0), bodies, need)
    a, b = rng.uniform(0, 1, (2, n, 400, 1))
    ball = rng.normal(size=(n, 400, 3))
    ball /= np.linalg.norm(ball, axis=2, keepdims=True)
    skin = start[:, None] + a * (end - start)[:, None] + b * move[:, None]
    hit = in_block(skin + ball * (radius + need)[:, None, None]).any(axis=1) | in_block(skin).any(axis=1)
    clear = room > 0
    return int(clear.sum()), int((~clear).sum()), int((clear & hit).sum())


def test_a_gap_that_cannot_be_told_is_none():
    """A number that is not one never counts as free."""
    cube, start = Cuboid(Pose.identity(), np.full(3, 10.0)), np.array([[np.nan, 0.0, 0.0], [50.0, 0.0, 0.0]])
    found = missing_clearance(cube, [(rods(start, start + 1.0, np.ones(2)), np.zeros(2), np.full(2, 0.02))])
    assert found.tolist() == [[np.inf, 0.0]]


def test_half_diagonal_by_hand():
    """Half-edges of 1, 2 and 2 mm at right angles: sqrt(1 + 4 + 4) = 3; a fourth along the first makes it sqrt(9 + 4 + 4)."""
    edges = np.zeros((2, 4, 3))
    edges[:, 0, 0], edges[:, 1, 1], edges[:, 2, 2] = 1.0, 2.0, 2.0
    edges[1, 3, 0] = 2.0
    assert _half_diagonal(edges) == pytest.approx([3.0, np.sqrt(17.0)])
    edges[1, 3, 0] = -2.0
    assert _half_diagonal(edges)[1] == pytest.approx(np.sqrt(17.0))


def test_a_swept_body_by_hand():
    rod = rods(np.zeros((1, 3)), np.array([[0.0, 0.0, 10.0]]), np.array([1.0]))
    swept = rod.swept_volume(np.array([[1.0, 0, 0]]), np.array([[5.0, 0, 0]]))
    assert swept.centre[0].tolist() == [3.0, 0.0, 5.0]
    assert swept.edges[0, 3].tolist() == [2.0, 0.0, 0.0]
    turned = rod.to_frame(np.array([[0.0, 0, 1], [0, 1, 0], [-1, 0, 0]]), np.array([0.0, 0.0, 7.0]))
    assert turned.centre[0].tolist() == [5.0, 0.0, 7.0]
    assert turned.edges[0, 0].tolist() == [5.0, 0.0, 0.0]
