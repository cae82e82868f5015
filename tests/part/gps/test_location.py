"""Position, coaxiality, symmetry by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import BORE, LEFT, RIGHT
from vcmm.core.errors import UsageError
from vcmm.part.gps.elements import nominal_element
from vcmm.part.gps.location import coaxiality, corners, position, symmetry
from vcmm.part.part import Characteristic, Feature, ends

POSITION = Characteristic("p", "position", of=("bore",), zone=0.1)
COAX = Characteristic("c", "coaxiality", of=("shaft",), datums=("bore",), zone=0.1)
SYMMETRY = Characteristic("s", "symmetry", of=("bore",), datums=("left", "right"), zone=0.1)
SHAFT = Feature(
    "shaft", "cylinder", np.array([0.0, 0, 50]), np.array([0.0, 0, 1]), np.array([8.0]), extent=(30.0,)
)


def at(feature: Feature, point):
    return replace(nominal_element(feature), point=np.array(point, dtype=float))


def test_position_is_twice_the_way_of_the_worse_end():
    # 3 and 4 um off: the zone has a diameter of 10 um
    assert position(POSITION, at(BORE, (3e-3, 4e-3, 10))) == pytest.approx(10e-3)
    tilted = replace(at(BORE, (0, 0, 0)), axis=np.array([1e-4, 0.0, 1.0]))
    assert position(POSITION, tilted) == pytest.approx(2 * 20 * 1e-4)  # the far end, 20 mm away
    assert position(POSITION, at(LEFT, (-50.002, 0, 10))) == pytest.approx(4e-3)


def test_coaxiality_about_the_datum_axis():
    assert coaxiality(COAX, at(SHAFT, (5e-3, 0, 65)), nominal_element(BORE)) == pytest.approx(10e-3)
    with pytest.raises(UsageError, match="gives no datum axis"):
        coaxiality(COAX, nominal_element(BORE), nominal_element(LEFT))
    off = replace(SHAFT, point=np.array([1.0, 0, 50]))
    with pytest.raises(UsageError, match="1 mm off coaxiality"):
        coaxiality(COAX, nominal_element(off), nominal_element(BORE))


def test_symmetry_about_the_middle_of_two_planes():
    # faces at -50 and 50.006: the middle stands 3 um right; a bore 5 um right of nominal is 2 um off: 4 um
    datums = [nominal_element(LEFT), at(RIGHT, (50.006, 0, 10))]
    assert symmetry(SYMMETRY, [at(BORE, (5e-3, 0, 10))], datums) == pytest.approx(4e-3)
    with pytest.raises(UsageError, match="takes planes as datums"):
        symmetry(SYMMETRY, [nominal_element(BORE)], [nominal_element(BORE), nominal_element(LEFT)])


def test_corners_of_a_plane_that_moved():
    out = corners(at(LEFT, (-50.1, 0, 10)))
    assert out[:, 0] == pytest.approx([-50.1] * 4)
    assert sorted(np.ptp(out, axis=0).tolist()) == pytest.approx([0.0, 20.0, 40.0])


TOP = Feature("top", "plane", np.zeros(3), np.array([0.0, 0, 1]), np.zeros(0), extent=(40.0, 40.0))
SIDE = Feature("side", "plane", np.zeros(3), np.array([-1.0, 0, 0]), np.zeros(0), extent=(40.0, 40.0))


def test_a_zone_moves_where_no_datum_holds_it():
    """Off by (6.445, 4.0) um: 2 hypot = 15.17 um in the frame; top and side leave y free, and 2 x 6.445 = 12.89 um are left."""
    off = at(BORE, (6.445e-3, 4.0e-3, 10))
    assert position(POSITION, off) == pytest.approx(2e-3 * np.hypot(6.445, 4.0))
    assert position(POSITION, off, [TOP, SIDE]) == pytest.approx(12.89e-3, rel=1e-6)
    assert position(POSITION, off, [TOP]) == pytest.approx(0.0, abs=1e-9)


def test_the_zone_is_the_smallest():
    """Ends off by (3, 0) and (0, 4) um, free in y by t: 9 + t^2 = (4 - t)^2 at t = 0.875, so 2 x 3.125 um; least
    squares (t = 2) leave 7.21.
    """
    (first, last), middle = ends(BORE), BORE.point
    a, b = first + [3e-3, 0, 0], last + [0, 4e-3, 0]
    axis = (b - a) / (b - a)[2]
    leaning = replace(at(BORE, a + axis * (middle - a)[2]), axis=axis / np.linalg.norm(axis))
    assert position(POSITION, leaning, [TOP, SIDE]) == pytest.approx(6.25e-3, rel=1e-3)
