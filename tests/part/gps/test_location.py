"""Position, coaxiality, symmetry by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import BORE, LEFT, RIGHT
from vcmm.core.errors import UsageError
from vcmm.part.gps.elements import nominal_element
from vcmm.part.gps.location import coaxiality, corners, position, symmetry
from vcmm.part.part import Characteristic, Feature

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
