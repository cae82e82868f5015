"""The tree over the trees of an index: it leaves out only what no ray meets, so answers are the same to the last bit."""

from __future__ import annotations

import math
from dataclasses import fields, replace

import numpy as np
import pytest

from vcmm.shop.cutting import _group_kernels as kernels
from vcmm.shop.cutting.dexels import carve
from vcmm.shop.cutting.envelope import surface_left
from vcmm.shop.cutting.index import Index, build, tree_of_groups
from vcmm.shop.cutting.sweeps import Sweep, join, lines
from vcmm.shop.cutting.tools import ball, bull, drill, flat

TOOLS = (ball(3.0), flat(4.0, length=30.0), bull(5.0, 1.0), drill(2.0))
LOW, HIGH = np.array([-25.0, -25.0, -5.0]), np.array([25.0, 25.0, 12.0])


def turning(seed: int, blocks: int = 40, pieces: int = 12) -> Sweep:
    """Passes over a block whose tool axis never stands still, and a few moves of one direction among them."""
    rng = np.random.default_rng(seed)
    parts = []
    for _ in range(blocks):
        ends = rng.uniform([-25, -25, -2], [25, 25, 15], (2, 3))
        way = ends[0] + np.linspace(0, 1, pieces + 1)[:, None] * (ends[1] - ends[0])
        lean = rng.normal(0, 0.5, (2, 3)) + [0, 0, 1]
        axis = lean[0] + np.linspace(0, 1, pieces)[:, None] * (lean[1] - lean[0])
        axis /= np.linalg.norm(axis, axis=1, keepdims=True)
        parts.append(lines(way[:-1], way[1:], TOOLS, int(rng.integers(4)), axis))
    upright = rng.uniform([-25, -25, 0], [25, 25, 9], (2, 9, 3))
    return join([*parts, lines(upright[0], upright[1], TOOLS, 0)])


def without_tree(index: Index) -> Index:
    """The same index, of which every ray looks into every tree, as the search did before."""
    tree = index.tree.copy()
    tree[:, 10] = 0.0
    tree[:, 3] = np.where(tree[:, 8] >= 0, 1e9, 0.0)
    return replace(index, tree=tree)


@pytest.mark.parametrize("seed", range(3))
def test_contacts_are_the_same_to_the_bit(seed: int) -> None:
    index = build(turning(seed))
    assert len(index.roots) == 481
    rng = np.random.default_rng([seed, 1])
    points = rng.uniform(LOW, HIGH, (300, 3))
    normals = rng.normal(size=(300, 3)) + [0, 0, 0.5]
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    one, all_ = (
        surface_left(points, normals, i, depth=1.0, candidates=8) for i in (index, without_tree(index))
    )
    assert 30 < np.isfinite(one.s).sum() < 300
    for field in fields(one):
        if field.name != "tests":
            np.testing.assert_array_equal(getattr(one, field.name), getattr(all_, field.name), field.name)
    assert one.tests.sum() < 0.5 * all_.tests.sum()


def test_what_is_left_of_a_block_is_the_same_to_the_bit() -> None:
    index = build(turning(7))
    one, all_ = (carve(LOW, HIGH, 1.5, i) for i in (index, without_tree(index)))
    assert 0.2 < one.volume() / np.prod(HIGH - LOW) < 0.95
    for axis in range(3):
        np.testing.assert_array_equal(one.ends[axis], all_.ends[axis])


def met(
    tree: np.ndarray, leaves: np.ndarray, p: list[float], n: list[float], low: float, high: float
) -> list[int]:
    out = np.zeros(len(leaves), np.int64)
    many = kernels.groups_met(tree, leaves, np.array(p), np.array(n), low, high, np.zeros(64, np.int64), out)
    return sorted(out[:many].tolist())


def test_two_tools_by_pencil() -> None:
    """R 2. One stands upright with its tip in the origin; the other lies along X, its tip in (10, 0, 0).

    A ray along Y at (20, -5 .. 5, 1) passes 1 mm over the axis of the second, inside; the first is 18 mm away. At z 2.1 it passes both. A ray
    at (0, 0, -1), straight down from the tip, is below the first and behind the second, 10 mm before its tip.
    """
    lying = np.array([[0, 1, 0], [0, 0, 1], [1, 0, 0]], float)  # rows: the axes of the group, the tool's last
    frames = np.stack([np.eye(3), lying])
    at = np.array([[0, 0, 0], [0, 0, 10.0]])  # the second tip seen from its group
    tree, leaves = tree_of_groups(
        frames, np.hstack([at, at]), np.array([2.0, 2.0]), np.zeros(2, bool), np.array([0, 1])
    )
    assert tree[1, :3] == pytest.approx([5, 0, 0])  # of both: in the middle, 5 mm to either tip
    assert tree[1, 3] == pytest.approx(5.0)
    assert tree[1, 4:7] == pytest.approx([math.sqrt(0.5), 0, math.sqrt(0.5)])
    assert tree[1, 7] == pytest.approx(2 * math.sin(math.pi / 8))  # 45 deg to either
    assert met(tree, leaves, [20, 0, 1], [0, 1, 0], -5, 5) == [1]
    assert met(tree, leaves, [20, 0, 2.1], [0, 1, 0], -5, 5) == []
    assert met(tree, leaves, [0, 0, 30], [1, 0, 0], -9, 9) == [0]
    assert met(tree, leaves, [0, 0, -1], [0, 0, -1], 0, 5) == []


def test_no_group_more_than_there_are() -> None:
    tree, leaves = tree_of_groups(
        np.tile(np.eye(3), (5, 1, 1)), np.zeros((5, 6)), np.ones(5), np.zeros(5, bool), np.arange(5)[::-1]
    )
    assert len(leaves) == 8
    assert met(tree, leaves, [0, 0, 1], [0, 0, 1], -1, 1) == [0, 1, 2, 3, 4]


def test_a_ball_by_pencil() -> None:
    """R 5, tip in the origin, upright: its middle at Z 5. A ray along Y at (4, 0, 1) passes sqrt(4^2 + 4^2) = 5.66 mm from the middle, so beside
    the ball though within the cylinder about its axis; at Z 3 it passes sqrt(16 + 4) = 4.47 mm from it. At (4, 0, 50) it cuts the shank."""
    tree, leaves = tree_of_groups(
        np.eye(3)[None], np.zeros((1, 6)), np.array([5.0]), np.ones(1, bool), np.array([0])
    )
    assert tree[1, :3] == pytest.approx([0, 0, 5])
    assert met(tree, leaves, [4, 0, 1], [0, 1, 0], -9, 9) == []
    assert met(tree, leaves, [4, 0, 3], [0, 1, 0], -9, 9) == [0]
    assert met(tree, leaves, [4, 0, 50], [0, 1, 0], -9, 9) == [0]
    assert met(tree, leaves, [4, 0, 1], [0, 0, 1], 0, 9) == [0]  # upwards it enters the ball at Z 2
    assert met(tree, leaves, [4, 0, 1], [0, 0, 1], 0, 0.5) == []
