"""Turning: numbers by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.shop.cutting.envelope import surface_left
from vcmm.shop.cutting.sweeps import join
from vcmm.shop.cutting.tools import insert
from vcmm.shop.cutting.turning import arc_sweep, meridian, straight, tip_of_centre

NOSE = (insert(0.8),)


def test_cylinder_and_taper_by_hand() -> None:
    """Along radius 20.01 the shaft is 10 um too thick. On a 45 deg taper programmed without nose compensation the nose
    leaves r (sqrt 2 - 1) = 0.33137 mm along the normal for the reference point at radius x: r (1 - cos 45) / ... by geometry:
    the nose centre is r outward (radially) of the line, the distance of the line from it along the normal r cos 45, so
    material ends r - r cos 45 = 0.23431 mm deeper than the line: s = -0.23431.
    """
    turned = straight([[20.01, 5.0]], [[20.01, -30.0]], NOSE)
    p, n = meridian(np.array([[12.0, 16.0, -10.0]]), np.array([[0.6, 0.8, 0.0]]))
    assert p[0] == pytest.approx([20.0, 0.0, -10.0])
    assert surface_left(p, n, turned).s[0] == pytest.approx(0.01, abs=1e-13)
    taper = straight([[10.0, 0.0]], [[30.0, -20.0]], NOSE)
    c = math.sqrt(0.5)
    p, n = meridian(np.array([[20.0, 0.0, -10.0]]), np.array([[c, 0.0, c]]))
    assert surface_left(p, n, taper).s[0] == pytest.approx(-(0.8 - 0.8 * c), abs=1e-12)


def test_feed_marks_by_hand() -> None:
    """f 0.2 mm per turn, r 0.8: between two passes 0.8 - sqrt(0.64 - 0.01) = 6.2745 um, f^2 / 8 r = 6.25 um."""
    marks = join(straight([[25.0, z]], [[20.0, z]], NOSE) for z in np.arange(-2.0, 0.01, 0.2))
    p, n = meridian(np.array([[0.0, 20.0, -0.9], [0.0, 20.0, -1.0]]), np.tile([0.0, 1.0, 0.0], (2, 1)))
    left = surface_left(p, n, marks)
    assert left.s == pytest.approx([0.8 - math.sqrt(0.63), 0.0], abs=1e-12)


def test_sphere_by_an_arc_by_hand() -> None:
    """Nose centre on a quarter circle of R + r = 15.8 about the origin: a sphere of R 15, everywhere exact."""
    centre = tip_of_centre(np.array([[0.0, 0.0, 0.0]]), 0.8)[:, [0, 2]]
    quarter = arc_sweep([[-0.8, 15.8]], [[15.0, 0.0]], centre, np.array([np.pi / 2]), NOSE)
    a = np.linspace(0.05, 1.5, 20)
    n = np.stack([np.sin(a), np.zeros(20), np.cos(a)], axis=1)
    assert np.abs(surface_left(15.0 * n, n, quarter).s).max() < 1e-12


def test_only_surfaces_of_revolution() -> None:
    with pytest.raises(UsageError, match="around the axis"):
        meridian(np.array([[10.0, 0.0, 0.0]]), np.array([[0.0, 1.0, 0.0]]))
