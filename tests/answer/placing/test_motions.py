"""Motions of a feature and what they do to the characteristics, by hand for a bore and two faces."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import BORE, DIAMETER, LEFT, LENGTH, RIGHT
from vcmm.answer.placing.motions import motions_of, outputs
from vcmm.part.part import Characteristic, Feature, frame

TOP = Feature("top", "plane", np.array([0, 0, 20.0]), np.array([0, 0, 1.0]), np.zeros(0), extent=(80.0, 80.0))


def test_rows_of_a_bore_by_hand():
    """At the rim (15, 0, 20) the normal is -x and the arm from the centre (0, 0, 10) is (15, 0, 10)."""
    u, v, _ = frame(BORE)
    found = motions_of(BORE).rows(np.array([[15.0, 0.0, 20.0]]), np.array([[-1.0, 0.0, 0.0]]))[0]
    # a turn about e moves the point by e x arm: along -x that is -(e_y 10 - e_z 0)
    wanted = [-u[0], -v[0], -10.0 * u[1], -10.0 * v[1], -1.0]  # a larger bore recedes from the axis
    assert found == pytest.approx(wanted, abs=1e-9)


def test_the_element_moves_about_its_centre():
    """A turn of 1 mrad about u: the foot of the bore, 10 mm below the centre, moves by 10 um, the axis by 1e-3."""
    u, _, w = frame(BORE)
    moved = motions_of(BORE).move(np.array([[0.0, 0.0, 1e-3, 0.0, 0.02]]))
    assert moved.point[0] == pytest.approx(np.cross(1e-3 * u, -10.0 * w), abs=1e-12)
    assert moved.axis[0] == pytest.approx((w + np.cross(1e-3 * u, w)) / np.sqrt(1 + 1e-6), abs=1e-12)
    assert moved.sizes[0, 0] == pytest.approx(15.02)


def test_a_turn_counts_at_the_rim():
    # the diameter of 30 mm is the largest size: 15 mm
    assert motions_of(BORE).scale().tolist() == [1.0, 1.0, 15.0, 15.0, 1.0]
    cone = Feature("c", "cone", np.zeros(3), np.array([0, 0, 1.0]), np.array([5.0, 0.2]), extent=(40.0,))
    assert motions_of(cone).scale().tolist() == [1.0, 1.0, 1.0, 20.0, 20.0, 20.0]


def test_outputs_by_hand():
    features = {f.name: f for f in (BORE, LEFT, RIGHT, TOP)}
    moving = {n: motions_of(f) for n, f in features.items()}
    square = Characteristic("square", "perpendicularity", of=("bore",), datums=("top",), zone=0.01)
    found = outputs((DIAMETER, LENGTH, square), features, moving, None)
    wanted = np.zeros((1, 14))
    wanted[0, 4] = 2.0  # the radius counts twice
    assert found["diameter"] == pytest.approx(wanted, abs=1e-6)
    wanted[:] = 0.0
    wanted[0, [5, 8]] = 1.0  # each face moved outwards along its own normal
    assert found["length"][:, [5, 8]] == pytest.approx(wanted[:, [5, 8]], abs=1e-6)
    # a bore of 20 mm that leans by t lies within a cylinder of 20 t; leaning with the face is no error
    theta = np.zeros(14)
    theta[2] = 1e-3
    assert np.linalg.norm(found["square"] @ theta) == pytest.approx(0.02, rel=1e-4)
    lean = np.zeros(14)
    for k, feature in ((2, BORE), (12, TOP)):
        lean[k : k + 2] = frame(feature)[:2] @ np.array([1e-3, 0.0, 0.0])
    assert np.linalg.norm(found["square"] @ lean) == pytest.approx(0.0, abs=1e-6)
