"""What passes of the nose leave: feed marks, phase, profiles; closed forms and kernels of other tools. Numbers by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.machining import lathe
from vcmm.cutting.envelope import UNCUT, surface_left
from vcmm.cutting.nose import capsules, entry, removed_by
from vcmm.cutting.sweeps import join
from vcmm.cutting.tools import insert
from vcmm.cutting.turning import curved, straight, tip_of_centre
from vcmm.machining.spindle import Spindle

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
    quarter = curved([[-0.8, 15.8]], [[15.0, 0.0]], centre, np.array([np.pi / 2]), NOSE)
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


def test_passes_of_a_spindle_by_hand():
    """60 turns per minute, M3: the tool runs round the part by -1 turn/s. It passes 90 deg 0.75 s after the start, then each s."""
    time = np.linspace(0.0, 10.0, 11)
    spindle = Spindle(time, -2 * np.pi * time, 2 * np.pi * time)
    found = spindle.passes(np.array([3.0]), np.array([np.pi / 2]), 2)
    assert found[0] == pytest.approx([1.75, 2.75, 3.75, 4.75], abs=1e-12)
    late = spindle.passes(np.array([9.9]), np.array([np.pi / 2]), 1)
    assert late[0, 0] == pytest.approx(9.75)
    assert np.isnan(late[0, 1])  # the program ends before


def test_feed_marks_on_a_journal(tmp_path):
    """f = 0.05, r = 0.8: crests r - sqrt(r^2 - f^2/4) = 0.39072 um (f^2 / 8 r = 0.39063), mean f^2 / 24 r = 0.1302 um."""
    found, points = lathe.nominal(lathe.shop(lathe.write(tmp_path)), "journal")
    assert found.min() >= -1e-12
    assert found.max() == pytest.approx(0.39072e-3, rel=0.02)
    assert found.max() <= 0.39073e-3
    assert found.mean() == pytest.approx(0.1302e-3, rel=0.1)
    # the groove winds: on one generator 0.05 mm further along means the same height, and so does a turn
    assert len(np.unique(points[:, 2].round(9))) > 5


def test_the_phase_of_the_marks_is_that_of_the_spindle(tmp_path):
    """At any point the height is that of the nearest pass: u = distance from it along z, s = r - sqrt(r^2 - u^2)."""
    ready = lathe.shop(lathe.write(tmp_path))
    found, points = lathe.nominal(ready, "journal")
    # a turn of M3 takes the tool by -1 turn about the part: passes of the angle phi lie at z0 + f phi / 2 pi (mod f), for z falls
    # by f while the angle falls by 2 pi
    height = np.sqrt(np.maximum(0.8**2 - (0.8 - found) ** 2, 0.0))  # u of every point
    phi = np.arctan2(points[:, 1], points[:, 0])
    start = (points[:, 2] - 0.05 * phi / (2 * np.pi))[:, None] + np.stack([height, -height], axis=1)
    circular = np.exp(2j * np.pi * start / 0.05)
    off = [np.abs(np.angle(circular / one)).min(axis=1).max() for one in circular[height.argmin()]]
    assert min(off) < 1e-4


def test_every_feature_of_the_contour_lies_on_the_drawing(tmp_path):
    """With G42 the nose touches ball, journal, step, taper and seat: nothing but feed marks is left."""
    ready = lathe.shop(lathe.write(tmp_path))
    for name in ("ball", "journal", "step", "taper", "seat"):
        found, _ = lathe.nominal(ready, name)
        assert found.min() > -1e-6, name
        assert found.max() < 0.45e-3, name
