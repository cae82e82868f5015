"""Fitted elements in the drawing frame: signs, centres, ends."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import BORE, LEFT, RIGHT
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.pose import Pose
from vcmm.part.fit import FittedElement
from vcmm.part.gps.elements import anchor, axis_ends, from_axis, nominal_element, place

FEATURES = {f.name: f for f in (BORE, LEFT, RIGHT)}


def fitted(kind: str, point, axis, sizes=()) -> FittedElement:
    return FittedElement(
        kind,
        np.array(point, float),
        np.array(axis, float),
        np.array(sizes, float),
        np.zeros(1),
        np.zeros((1, 3)),
    )


def test_a_direction_is_turned_to_the_drawing():
    e = place("bore", FEATURES, {"bore": fitted("cylinder", (1, 2, 3), (0, 0, -1), (15,))}, None)
    assert e.axis.tolist() == [0.0, 0.0, 1.0]
    moved = place(
        "bore",
        FEATURES,
        {"bore": fitted("cylinder", (1, 2, 3), (0, 0, 1), (15,))},
        Pose(np.eye(3), np.ones(3)),
    )
    assert moved.point.tolist() == [2.0, 3.0, 4.0]


def test_what_cannot_be_placed():
    with pytest.raises(UsageError, match='Unknown feature "bor"'):
        place("bor", FEATURES, {}, None)
    with pytest.raises(UsageError, match="not measured"):
        place("bore", FEATURES, {}, None)
    with pytest.raises(ModelLimit, match=r"90\.0 deg off the drawing"):
        place("bore", FEATURES, {"bore": fitted("cylinder", (0, 0, 0), (1, 0, 0), (15,))}, None)


def test_centres_by_hand():
    # the bore is 20 long from z = 0: its middle is at z = 10, on an axis through (1, 2)
    e = place("bore", FEATURES, {"bore": fitted("cylinder", (1, 2, -40), (0, 0, 1), (15,))}, None)
    assert anchor(e) == pytest.approx([1.0, 2.0, 10.0])
    # a plane 0.3 too far left: the foot of the nominal centre
    e = place("left", FEATURES, {"left": fitted("plane", (-50.3, 7, 9), (-1, 0, 0))}, None)
    assert anchor(e) == pytest.approx([-50.3, 0.0, 10.0])


def test_ends_of_a_tilted_axis():
    # x grows by 3 per 4 of z: at z = 0 and 20 it passes 0 and 15; measured from the point at z = 4
    e = place(
        "bore", FEATURES, {"bore": fitted("cylinder", (0, 0, 0), np.array([0.06, 0, 0.998]), (15,))}, None
    )
    assert axis_ends(e)[1] == pytest.approx([20 * 0.06 / 0.998, 0.0, 20.0])
    assert from_axis(np.array([[3.0, 4.0, 5.0]]), nominal_element(BORE)) == pytest.approx([5.0])
