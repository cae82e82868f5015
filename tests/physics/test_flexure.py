"""vcmm/physics/catalogue/flexure.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.physics.catalogue.flexure import CrossAxisFlexure, GradientBending, PartLoad


def _run(offset=(0.0, 0.0, 0.0), **columns: float) -> Run:
    position = {"X": np.array([500.0]), "Y": np.array([100.0]), "Z": np.array([-400.0])}
    return Run(position, np.array([offset]), {k: np.array([v]) for k, v in columns.items()})


def test_cross_axis_flexure():
    # c = 20 um/m^2 = 2e-8 per mm: 2e-8 x 500 x (-400) = -4 um in z
    error = machine(CrossAxisFlexure("X", "Z", "z", 2e-8)).tip_error(_run())
    assert error[0] == pytest.approx([0.0, 0.0, -4e-3], abs=1e-15)
    # ram droop: square 2e-8 x 160000 = 3.2 um; cube, per m: 3.2 um x (-0.4) = -1.28 um
    for power, expected in ((2, 3.2e-3), (3, -1.28e-3)):
        error = machine(CrossAxisFlexure("X", "Z", "y", 2e-8, power)).tip_error(_run())
        assert error[0] == pytest.approx([0.0, expected, 0.0], abs=1e-15)


def test_part_load():
    # 0.05 um/(m kg) = 5e-8: 5e-8 x 80 kg x 500 mm = 2 um in x
    error = machine(PartLoad("X", "x", 5e-8)).tip_error(_run(load_kg=80.0))
    assert error[0] == pytest.approx([2e-3, 0.0, 0.0], abs=1e-15)


def test_gradient_bending_shifts_and_pitches():
    # k = 10 um/(m^2 K) = 1e-8, 0.2 K: shift 2e-9 x 500^2 = 0.5 um in +z; climbing along +X the carriage noses up:
    # turn about -Y by 2 x 2e-9 x 500 = 2 urad. Tip 100 mm below and 400 mm down with Z, so 500 mm below:
    # (-2e-6 about Y) x (0, 0, -500) = +1 um in X
    effect = GradientBending("X", "z", 1e-8)
    run = _run((0.0, 0.0, -100.0), temp_gradient_C=0.2)
    six = effect.error_motion(run)[0]
    assert six == pytest.approx([0, 0, 0.5e-3, 0, -2e-6, 0], abs=1e-15)
    from vcmm.core.kinematics import Axis, parse_structure
    from vcmm.core.machine import Machine

    axes = {a: Axis(a, (-1000.0, 1000.0)) for a in "XYZ"}
    bent = Machine("m", "cmm", parse_structure("w b Y X Z t"), axes, (effect,))
    assert bent.tip_error(run)[0] == pytest.approx([1e-3, 0.0, 0.5e-3], abs=1e-15)


@pytest.mark.parametrize("carries", ["tool", "workpiece"])
def test_the_pitch_is_the_slope_of_the_guide(carries: str):
    # own place on the guide s = q, or -q under a table; own shift w(s); own turn = axis x direction times dw/ds
    side = 1.0 if carries == "tool" else -1.0
    q = np.array([300.0, 300.001])
    run = Run({"X": q}, np.zeros((2, 3)), {"temp_gradient_C": np.ones(2)})
    six = side * GradientBending("X", "y", 1e-8, carries).error_motion(run)  # own motion from tip sense
    slope = np.diff(six[:, 1])[0] / np.diff(side * q)[0]
    assert six[0, 5] == pytest.approx(slope, rel=1e-5)  # x cross y = +z


def test_words_are_checked():
    with pytest.raises(UsageError, match='must be "x", "y" or "z"'):
        PartLoad("X", "Z")
    with pytest.raises(UsageError, match="bends across its axis"):
        GradientBending("X", "x")
    with pytest.raises(UsageError, match='"tool" or "workpiece"'):
        GradientBending("X", "z", 0.0, "part")
