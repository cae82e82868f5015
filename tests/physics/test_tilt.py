"""Tilts and offsets in two directions are the sum of their two numbers."""

from __future__ import annotations

import numpy as np
import pytest

from tests.physics.ask import ask
from vcmm.core.errors import UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.physics.catalogue.tilt import AxisLean, CentreLineOffset, CentreLineTilt
from vcmm.physics.structure.squareness import RotaryLocation, Squareness

RUN = Run(
    {a: np.array([v]) for a, v in (("X", 50.0), ("Y", 200.0), ("Z", -100.0), ("C", 0.0))},
    np.array([[0, 0, -80.0]]),
)


def tip(*effects) -> np.ndarray:
    axes = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZC"}
    return Machine("m", "cmm", parse_structure("w b X Y Z C t"), axes, effects).tip_error(RUN)[0]


def test_a_leaning_column_by_hand():
    # A0Z = 4 urad: -4e-6 x (-100 mm) = +0.4 um in Y; B0Z = 2 urad: 2e-6 x (-100 mm) = -0.2 um in X
    assert tip(AxisLean("Z", np.array([4e-6, 2e-6]))) == pytest.approx([-0.2e-3, 0.4e-3, 0.0], abs=1e-15)
    assert ask(AxisLean("Z"), "elements") == ("A0Z", "B0Z")
    both = tip(Squareness("A0Z", 4e-6), Squareness("B0Z", 2e-6))
    assert tip(AxisLean("Z", np.array([4e-6, 2e-6]))) == pytest.approx(both, abs=1e-18)


def test_a_centre_line_by_hand():
    # 80 mm below the centre: A0C = 10 urad moves +0.8 um in Y, B0C = -5 urad -80 x (-5e-6) = +0.4 um in X
    assert tip(CentreLineTilt("C", np.array([1e-5, -5e-6]))) == pytest.approx(
        [0.4e-3, 0.8e-3, 0.0], abs=1e-15
    )
    assert tip(CentreLineOffset("C", np.array([5e-3, -3e-3]))) == pytest.approx([5e-3, -3e-3, 0.0], abs=1e-15)
    each = tip(RotaryLocation("A0C", tilt=1e-5), RotaryLocation("B0C", tilt=-5e-6))
    assert tip(CentreLineTilt("C", np.array([1e-5, -5e-6]))) == pytest.approx(each, abs=1e-18)
    assert ask(CentreLineTilt("A4"), "elements") == ("B0A4", "C0A4")
    assert ask(CentreLineOffset("A4"), "elements") == ("Y0A4", "Z0A4")


def test_what_they_refuse():
    with pytest.raises(UsageError, match="only Z has two"):
        AxisLean("Y")
    with pytest.raises(UsageError, match="no rotary axis"):
        CentreLineTilt("X")
    with pytest.raises(UsageError, match="one each for X0C and Y0C"):
        CentreLineOffset("C", np.ones(3))
