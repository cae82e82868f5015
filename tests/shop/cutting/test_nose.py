"""The nose circle of an insert: swept circles against the kernels of ball mills, arcs as chords, a ray and a circle by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.shop.cutting.envelope import UNCUT, surface_left
from vcmm.shop.cutting.nose import Capsules, _near, capsules, entry, removed_by
from vcmm.shop.cutting.sweeps import join
from vcmm.shop.cutting.tools import insert
from vcmm.shop.cutting.turning import arc_sweep, straight, tip_of_centre

NOSE = (insert(0.8),)


def test_swept_noses_agree_with_the_kernels_of_ball_mills():
    """In the plane a nose circle is a ball; cylinder and taper meet its lower half only, where shank and flank do not matter."""
    path = join(
        [
            straight([[20, 5.0]], [[20, -30.0]], NOSE),
            straight([[20, -30.0]], [[30, -40.0]], NOSE),
            straight([[30, -40.0]], [[40, -40.0]], NOSE),
        ]
    )
    z, c = np.linspace(-29, 0, 37), math.sqrt(0.5)
    x = np.linspace(21, 29, 37)
    points = np.concatenate([np.stack([20 + 0 * z, 0 * z, z], 1), np.stack([x, 0 * x, -30 - (x - 20)], 1)])
    normals = np.repeat([[1.0, 0, 0], [c, 0, c]], 37, axis=0)
    mine = removed_by(points, normals, capsules(path), 0.5, 2.0, 0.1, 3)
    theirs = surface_left(points, normals, path, candidates=3)
    assert np.abs(mine.s - theirs.s).max() < 1e-12
    assert (mine.row[:, 0] == theirs.row[:, 0]).all()
    assert np.abs(mine.t[:, 0] - theirs.t[:, 0]).max() < 1e-12


def test_arcs_are_found_to_their_chord_and_nothing_cut_is_uncut():
    centre = tip_of_centre(np.array([[0.0, 0.0, 0.0]]), 0.8)[:, [0, 2]]
    quarter = arc_sweep([[-0.8, 15.8]], [[15.0, 0.0]], centre, np.array([np.pi / 2]), NOSE)
    a = np.linspace(0.05, 1.5, 20)
    n = np.stack([np.sin(a), np.zeros(20), np.cos(a)], axis=1)
    found = removed_by(15.0 * n, n, capsules(quarter, 1e-5), 0.5, 2.0, 0.1, 2)
    assert np.abs(found.s).max() < 2e-5
    assert found.t[:, 0] == pytest.approx(a / (np.pi / 2), abs=2e-3)
    below = removed_by(10.0 * n, n, capsules(quarter), 0.5, 2.0, 0.1, 2)
    assert (below.status == UNCUT).all()


def test_a_ray_and_a_circle_by_hand():
    # from 3 above the centre downwards in x, circle of radius 1, 0.6 beside: x = 0.8 below -> s = -3 + ... n = +x: -b - 0.8
    s = entry(np.array([[-3.0, 0.6], [-3.0, 1.1]]), np.array([[1.0, 0.0], [1.0, 0.0]]), np.array([1.0, 1.0]))
    assert s[0] == pytest.approx(2.2)  # enters where x = -0.8
    assert np.isinf(s[1])


def test_what_lies_beside_the_points_is_kept_within_the_reach_on_either_side():
    # noses of 0.5 mm at radius 20; points from z = 0 to 1; reach 2: -2 to 3 for the material, so -2.5 to 3.5 for the centres
    z = np.array([-2.6, -2.4, 0.5, 3.4, 3.6])
    at, m = np.stack([np.full(5, 20.0), z], axis=1), np.arange(5)
    path = Capsules(at, at, np.full(5, 0.5), m, np.zeros(5), np.ones(5))
    points = np.array([[20.0, 0.0, 0.0], [20.0, 0.0, 1.0]])
    assert _near(path, points, 2.0).row.tolist() == [1, 2, 3]
    assert _near(path, points + [0, 0, 90.0], 2.0).row.tolist() == [0]  # one at least
