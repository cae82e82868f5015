"""The material that features imply, against inequalities written down apart."""

from __future__ import annotations

import numpy as np

from vcmm.answer.placing.material import analytic_solid
from vcmm.part.part import Feature, Part

Z = np.array([0.0, 0.0, 1.0])


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


def test_material_of_a_block_with_a_bore():
    p = np.random.default_rng(1).uniform([-50, -50, -10], [50, 50, 30], (20000, 3))
    solid = analytic_solid(block(), 5.0)
    assert np.array_equal(solid.distance(p) <= 0, in_block(p))


def test_the_distance_is_never_larger_than_the_way_to_the_material():
    """Independent: from each point in every direction the first material must not lie nearer than claimed."""
    rng = np.random.default_rng(2)
    p = rng.uniform([-50, -50, -10], [50, 50, 40], (3000, 3))
    claimed = analytic_solid(block(), 5.0).distance(p)
    outside = claimed > 0
    way = rng.normal(size=(3000, 200, 3))
    way /= np.linalg.norm(way, axis=2, keepdims=True)
    reach = p[:, None] + way * claimed[:, None, None] * rng.uniform(0, 1, (3000, 200, 1))
    assert outside.sum() > 1000
    assert not in_block(reach[outside]).any()
