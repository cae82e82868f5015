"""Squareness of linear axes, location of rotary axes: the signs of the contract, section 1."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.physics.structure.squareness import RotaryLocation, Squareness

AXES = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}
PLACE = {"X": 50.0, "Y": 200.0, "Z": -100.0}


def _tip(structure: str, effect, **more: float) -> np.ndarray:
    letters = [word[0] for word in structure.split() if word[0] in "XYZABC"]
    axes = {a: AXES.get(a, Axis(a, (-4.0, 4.0))) for a in letters}
    position = {a: np.array([more.get(a, PLACE.get(a, 0.0))]) for a in letters}
    run = Run(position, np.array([[0.0, 0.0, -80.0]]))
    return Machine("m", "cmm", parse_structure(structure), axes, (effect,)).tip_error(run)[0]


@pytest.mark.parametrize("structure", ["w b Y X Z t", "w b X Y Z t", "w Y' b X Z t", "w X' Y' b Z t"])
@pytest.mark.parametrize(
    ("pair", "angle", "expected_um"),
    [
        ("C0Y", 3e-6, (-0.6, 0.0, 0.0)),  # -c y = -3e-6 x 200 mm
        ("B0Z", 2e-6, (-0.2, 0.0, 0.0)),  # +b z = 2e-6 x (-100 mm)
        ("A0Z", 4e-6, (0.0, 0.4, 0.0)),  # -a z = -4e-6 x (-100 mm)
    ],
)
def test_only_the_direction_of_travel_turns(structure, pair, angle, expected_um):
    # the stylus of 80 mm does not turn, and a table axis gives the same numbers
    assert _tip(structure, Squareness(pair, angle)) * 1e3 == pytest.approx(expected_um, abs=1e-12)


def test_centre_line_of_a_head_and_of_a_table():
    # head: the tip goes with the centre line, +5 um; table: the workpiece goes with it, so the tip seen from it -5 um
    assert _tip("w b X Y Z B t", RotaryLocation("X0B", offset=5e-3)) == pytest.approx([5e-3, 0, 0], abs=1e-15)
    assert _tip("w C' b X Y Z t", RotaryLocation("X0C", offset=5e-3)) == pytest.approx(
        [-5e-3, 0, 0], abs=1e-15
    )


def test_tilt_turns_what_the_axis_carries_about_its_centre():
    # A0C = 10 urad about X at the centre (0 0 0) of a C on the tool side: the tip is 80 mm below it,
    # a x r = (0, -a z, a y) = (0, -10e-6 x (-80), 0) = +0.8 um in Y
    assert _tip("w b X Y Z C t", RotaryLocation("A0C", tilt=1e-5)) == pytest.approx([0, 0.8e-3, 0], abs=1e-15)


@pytest.mark.parametrize("pair", ["A0X", "X0Y", "C0C", "COY", ""])
def test_pairs_are_checked(pair):
    with pytest.raises(UsageError, match="allowed are C0Y, B0Z, A0Z"):
        Squareness(pair)


def test_locations_are_checked():
    with pytest.raises(UsageError, match="is not a location error"):
        RotaryLocation("X0Y")
