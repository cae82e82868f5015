"""Orientation: widths of zones by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import BORE, LEFT, RIGHT
from vcmm.core.errors import UsageError
from vcmm.part.gps.elements import nominal_element
from vcmm.part.gps.orientation import nominal_angle, orientation
from vcmm.part.part import Characteristic, Feature

PARALLEL = Characteristic("p", "parallelism", of=("left",), datums=("right",), zone=0.1)
SQUARE = Characteristic("q", "perpendicularity", of=("bore",), datums=("top",), zone=0.1)
TOP = Feature("top", "plane", np.zeros(3), np.array([0.0, 0, 1]), np.zeros(0), extent=(40.0, 20.0))


def test_an_axis_square_to_a_plane():
    # 0.3 and 0.4 mrad over 20 mm: 0.5 mrad x 20 mm = 10 um
    axis = np.array([0.3e-3, 0.4e-3, 1.0])
    bore = replace(nominal_element(BORE), axis=axis / np.linalg.norm(axis))
    assert orientation(SQUARE, bore, nominal_element(TOP)) == pytest.approx(10e-3, rel=1e-6)


def test_a_plane_parallel_to_a_plane():
    # 1 mrad about the edge: one of the sides (40 and 20 mm) rises by 40 or 20 um
    left = replace(nominal_element(LEFT), axis=np.array([-np.cos(1e-3), np.sin(1e-3), 0.0]))
    width = float(orientation(PARALLEL, left, nominal_element(RIGHT)))
    assert min(abs(width - 40e-3), abs(width - 20e-3)) < 1e-7


def test_the_drawing_says_the_angle():
    assert nominal_angle(PARALLEL, LEFT, RIGHT) == (0.0, -1.0)
    slanted = replace(TOP, axis=np.array([0.0, 0.5, np.sqrt(0.75)]))
    angled = Characteristic("a", "angularity", of=("top",), datums=("bore",), zone=0.1)
    assert nominal_angle(angled, slanted, BORE)[0] == pytest.approx(np.pi / 6)
    with pytest.raises(UsageError, match="90 deg off perpendicularity"):
        nominal_angle(replace(SQUARE, of=("left",)), LEFT, RIGHT)
    # the normal leans by 30 deg from the axis of the bore: 30 deg off square to it, 60 deg off parallel to its side
    with pytest.raises(UsageError, match=r"30 deg off perpendicularity"):
        nominal_angle(SQUARE, slanted, BORE)
    with pytest.raises(UsageError, match=r"60 deg off parallelism"):
        nominal_angle(replace(PARALLEL, of=("top",)), slanted, BORE)


def test_what_has_no_direction():
    ball = Feature("ball", "sphere", np.zeros(3), np.zeros(3), np.array([5.0]))
    with pytest.raises(UsageError, match="not for a sphere"):
        orientation(SQUARE, nominal_element(ball), nominal_element(TOP))
    with pytest.raises(UsageError, match="gives no datum direction"):
        orientation(SQUARE, nominal_element(BORE), nominal_element(ball))
