"""Contacts: hand-computed projections, and the map against cutting again with the displaced tool."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.shop.cutting.contactmap import Contacts, audit, contact_map
from vcmm.shop.cutting.displacement import Displacement
from vcmm.shop.cutting.envelope import CUT, surface_left, tips
from vcmm.shop.cutting.sweeps import Sweep, join, lines, path
from vcmm.shop.cutting.tools import ball, flat

UP = np.array([[0.0, 0.0, 1.0]])


def raster(z: float = 0.0) -> Sweep:
    """Ball R 5, lines along x every 0.5 mm, cut into moves of 2 mm."""
    x = np.arange(0.0, 30.1, 2.0)
    y = np.arange(0.0, 20.1, 0.5)
    xs = np.concatenate([x if k % 2 == 0 else x[::-1] for k in range(len(y))])
    ys = np.repeat(y, len(x))
    return path(np.stack([xs, ys, np.full(len(xs), z)], axis=1), (ball(5.0),))


def smooth(amplitude: float, seed: int) -> Displacement:
    """Random smooth field of three waves of 40 to 120 mm per component, its largest value over the raster as stated."""
    rng = np.random.default_rng(seed)
    k = rng.normal(size=(3, 3, 3))
    k *= 2 * np.pi / rng.uniform(40.0, 120.0, (3, 3, 1)) / np.linalg.norm(k, axis=2)[..., None]
    phase = rng.uniform(0, 6.28, (3, 3))

    def raw(x: Array) -> Array:
        return np.sin(np.einsum("mj,cwj->mcw", x, k) + phase).sum(axis=2)

    inside = rng.uniform([0, 0, 0], [30, 20, 0], (3000, 3))
    scale = amplitude / np.linalg.norm(raw(inside), axis=1).max()
    return lambda x, row, t: scale * raw(x)


def contact(p: list[float], n: list[float], sweep: Sweep) -> tuple[Contacts, Array, Array]:
    """Contacts of one point; of its lowest the arm from the tip and the normal of the cutter (3,)."""
    surface = surface_left(np.array([p]), np.array([n]), sweep)
    found = contact_map(surface, sweep)
    at = np.array(p) + found.height[0, 0] * np.array(n)
    return found, at - tips(surface, sweep)[0, 0], found.cutter[0, 0]


def one(e: list[float] | Array, p: list[float], n: list[float], sweep: Sweep) -> float:
    """Height of the surface over one point with the tool moved by e at every contact."""
    found = contact(p, n, sweep)[0]
    return float(found.surface(np.tile(np.asarray(e, float), (np.sum(found.row >= 0), 1)))[0])


def test_floor_wall_and_slope_by_hand() -> None:
    """Floor: tool 3 um high leaves 3 um. Wall facing +y: tool 2 um towards the wall (-y) cuts 2 um deep.

    Flank of a ball cut at 60 deg: N = -n there, so e along x of 4 um gives 4 sin 60 = 3.4641 um towards the material.
    """
    f, b = lines([[-9, 0, 0]], [[9, 0, 0]], (flat(5.0),)), lines([[0, -9, 0]], [[0, 9, 0]], (ball(5.0),))
    assert one([0.001, 0.002, 0.003], [0, 0, 0], [0, 0, 1], f) == pytest.approx(0.003, abs=1e-15)
    assert one([0.001, -0.002, 0.003], [0, -5, 2], [0, 1, 0], f) == pytest.approx(-0.002, abs=1e-15)
    c, s = math.cos(math.radians(60)), math.sin(math.radians(60))
    p, n = [5 * s, 0, 5 - 5 * c], [-s, 0, c]
    assert one([0.004, 0, 0], p, n, b) == pytest.approx(-0.004 * s, abs=1e-14)


def test_tilt_and_radius_by_hand() -> None:
    """Flat R 5, wall 2 mm above the tip: 50 urad about x moves the edge there by 50e-6 x 2 = 0.1 um along -y.

    theta x r = (5e-5, 0, 0) x (0, -5, 2) = (0, -1e-4, -2.5e-4) mm: towards the wall at y = -5, so s = -0.1 um.
    Runout of 5 um on the wall: -5 um; on the floor: nothing.
    """
    f = lines([[-9, 0, 0]], [[9, 0, 0]], (flat(5.0),))
    _, arm, cutter = contact([0, -5, 2], [0, 1, 0], f)
    tilted = np.cross([5e-5, 0, 0], arm)
    assert one(tilted, [0, -5, 2], [0, 1, 0], f) == pytest.approx(-1e-4, abs=1e-15)
    assert one(0.005 * cutter * [1, 1, 0], [0, -5, 2], [0, 1, 0], f) == pytest.approx(-0.005, abs=1e-15)
    floor = contact([0, 0, 0], [0, 0, 1], f)[2]
    assert one(0.005 * floor * [1, 1, 0], [0, 0, 0], [0, 0, 1], f) == pytest.approx(0.0, abs=1e-15)
    # and the tool grown for good, cut again
    wide = lines([[-9, 0, 0]], [[9, 0, 0]], (flat(5.005),))
    again = surface_left(np.array([[0, -5, 2.0]]), np.array([[0, 1.0, 0]]), wide)
    assert again.s[0] == pytest.approx(-0.005, abs=1e-14)


def test_wear_of_a_ball_by_hand() -> None:
    """Worn by 2 um along its normal, a ball leaves 2 um at the bottom of its groove."""
    b = lines([[0, -9, 0]], [[0, 9, 0]], (ball(5.0),))
    cutter = contact([0, 0, 0], [0, 0, 1], b)[2]
    assert one(-0.002 * cutter, [0, 0, 0], [0, 0, 1], b) == pytest.approx(0.002, abs=1e-15)


@pytest.mark.parametrize("amplitude", [0.0075, 0.02])
def test_the_map_against_cutting_again(amplitude: float) -> None:
    """Scallops of a ball mill under a smooth field: right to the second-order term e^2 / 2R (40 nm at 20 um and R 5).

    One contact alone errs by far more where a cusp moves sideways. The chord of the field is kept to 1 nm.
    """
    sweep = raster()
    rng = np.random.default_rng(8)
    p = np.column_stack([rng.uniform(5, 25, 800), rng.uniform(5, 15, 800), np.zeros(800)])
    surface = surface_left(p, UP.repeat(800, axis=0), sweep)
    for seed in range(3):
        field = smooth(amplitude, seed)
        found = audit(surface, sweep, field, 1e-6)
        assert found.points == 800
        assert 0.7 * amplitude < found.amplitude < 1.01 * amplitude
        assert found.largest < amplitude**2 / 10 + 2e-6
        assert found.single > 10 * found.largest


def test_uncut_points_are_refused_and_left_out() -> None:
    sweep = join([lines([[-9, 0, 0]], [[9, 0, 0]], (flat(5.0),))])
    surface = surface_left(np.array([[0, 50.0, 0], [0, 0, 0]]), UP.repeat(2, axis=0), sweep)
    with pytest.raises(UsageError, match="1 points were not cut"):
        contact_map(surface, sweep)
    found = contact_map(surface.take(surface.status == CUT), sweep)
    assert found.surface(np.array([[0.0, 0.0, 0.001]])) == pytest.approx([0.001], abs=1e-15)
    field = lambda x, row, t: np.tile([0.0, 0.0, 0.001], (len(x), 1))  # noqa: E731
    assert audit(surface, sweep, field).points == 1
