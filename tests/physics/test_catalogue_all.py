"""The catalogue as a whole: names and units of the contract, further shapes, typical amplitudes."""

from __future__ import annotations

import numpy as np
import pytest

from tests.physics.factory import GRID_X, _numbers, scaled, some_run
from vcmm.core.effect import Effect, basis, parameter, parameter_fields, typical, with_parameter
from vcmm.core.errors import UsageError
from vcmm.files.own.effects import build_effect
from vcmm.physics import ALL, BY_NAME
from vcmm.physics.catalogue.cutting import ToolRunout
from vcmm.physics.catalogue.dynamics import DynamicPitch
from vcmm.physics.catalogue.encoder import EncoderInterpolation
from vcmm.physics.catalogue.flexure import CrossAxisFlexure, GradientBending, PartLoad
from vcmm.physics.catalogue.map_interpolation import MapInterpolation
from vcmm.physics.catalogue.reversal import ReversalSpike
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.physics.structure.expansion import PartExpansion
from vcmm.physics.structure.geometric_change import GeometricChange
from vcmm.physics.structure.rotary import RotaryCyclic

RUN = some_run()
SHAPES: tuple[Effect, ...] = (
    ReversalSpike("X", 3e-3, 0.7, "exponential"),
    MapInterpolation("EXX", GRID_X, "ripple", _numbers(2)),
    MapInterpolation("EBX", GRID_X, "cells", _numbers(2)),
    CrossAxisFlexure("Y", "Z", "x", 2e-8, 3),
    EncoderInterpolation("X", 0.1e-3, 0.05e-3, 0.02, 2),
    ToolRunout(4e-3, 1e-3, 1),
    PartLoad("X", "z", 5e-8),
    GradientBending("Y", "z", 1e-8),
    GradientBending("X", "y", 1e-8, "workpiece"),
    DynamicPitch("Z", 5e-9, 2e-9),
)


@pytest.mark.parametrize("effect", SHAPES, ids=lambda e: f"{e.id}-{getattr(e, 'shape', '')}")
def test_further_shapes_keep_the_rules(effect: Effect):
    whole = effect.error_motion(RUN)
    assert whole.shape == (RUN.n, 6)
    assert np.abs(whole).max() > 1e-8
    assert np.all(scaled(effect, 0.0).error_motion(RUN) == 0.0)
    assert scaled(effect, 3.0).error_motion(RUN) == pytest.approx(3 * whole, rel=1e-12, abs=1e-18)
    order = np.array([7, 3, 11, 0, 5, 2, 9, 1, 10, 4, 8, 6])
    assert effect.error_motion(RUN.take(order)) == pytest.approx(whole[order], rel=1e-12, abs=1e-18)
    for f in parameter_fields(effect):
        if not f.metadata["scan"]:
            value = np.asarray(getattr(effect, f.name), dtype=float)
            rest = with_parameter(effect, f.name, 0.0 if value.ndim == 0 else np.zeros_like(value))
            part = basis(effect, f.name, RUN) @ value.reshape(-1)
            assert rest.error_motion(RUN) + part == pytest.approx(whole, rel=1e-12, abs=1e-15)


# contract, section 6: name, place keys, parameter with its unit, canonical value
CATALOGUE = {
    "cross_axis_flexure": ({"axis": "X", "other": "Z", "direction": "z"}, "c", "20 um/m^2", 2e-8),
    "part_load": ({"axis": "X", "direction": "z"}, "c", "0.05 um/(m kg)", 5e-8),
    "linear_drift": ({"direction": "z"}, "c", "3.6 um/h", 1e-6),
    "step_change": ({"direction": "z"}, "a", "2 um", 2e-3),
    "gradient_bending": ({"axis": "X", "direction": "z"}, "k", "10 um/(m^2 K)", 1e-8),
    "spindle_growth": ({"axis": "Z"}, "A", "20 um", 20e-3),
    "screw_heating": ({"axis": "X"}, "k", "50 um/m", 50e-6),
    "lost_motion": ({"axis": "X"}, "g1", "4 um/m", 4e-6),
    "hysteresis": ({"axis": "X"}, "amplitude", "0.8 um", 0.8e-3),
    "reversal_spike": ({"axis": "X"}, "height", "3 um", 3e-3),
    "encoder_interpolation": ({"axis": "X"}, "amplitude", "100 nm", 1e-4),
    "servo_lag": ({"axis": "X"}, "1/Kv", "0.1 ms", 1e-4),
    "readout_delay": ({}, "delay", "0.1 ms", 1e-4),
    "dynamic_pitch": ({"axis": "X"}, "k", "5 urad/(m/s^2)", 5e-9),
    "structural_vibration": ({"axis": "X"}, "amplitude", "0.5 um", 0.5e-3),
    "abbe_offset": ({"axis": "X"}, "arm", "10 0 -50 mm", (10.0, 0.0, -50.0)),
    "cosine_error": ({}, "theta", "1 mrad", 1e-3),
    "air_index": ({}, "scale", "1", 1.0),
    "dead_path": ({}, "length", "100 mm", 100.0),
    "tool_deflection": ({}, "compliance", "0.1 um/N", 1e-4),
    "tool_wear": ({}, "rate", "0.2 um/m", 2e-7),
    "tool_runout": ({}, "amplitude", "5 um", 5e-3),
    "workpiece_heating": ({}, "k", "36 um/(m h)", 1e-8),
    "rotary_cyclic": ({"component": "EXC"}, "amplitude", "2 um", (2e-3,)),
}


@pytest.mark.parametrize("name", [n for n in CATALOGUE if n in BY_NAME])
def test_file_takes_the_contract_name_and_unit(name: str):
    place, key, text, expected = CATALOGUE[name]
    built = build_effect({"effect": name, key: text, **place})
    inside = parameter(built, key).name
    assert np.ravel(getattr(built, inside)) == pytest.approx(np.ravel(expected), rel=1e-12)


def test_file_takes_the_scanned_parameters():
    for name, place, key, text, expected in (
        ("step_change", {"direction": "x"}, "t1", "10 min", 600.0),
        ("spindle_growth", {"axis": "Z"}, "tau", "30 min", 1800.0),
        ("structural_vibration", {"axis": "X"}, "frequency", "25 Hz", 25.0),
        ("structural_vibration", {"axis": "X"}, "damping", "3 %", 0.03),
        ("encoder_interpolation", {"axis": "X"}, "period", "20 um", 0.02),
        ("screw_heating", {"axis": "X"}, "distance", "100 m", 1e5),
    ):
        assert getattr(build_effect({"effect": name, key: text, **place}), key) == pytest.approx(expected)


@pytest.mark.parametrize("kind", ALL, ids=lambda k: k.name)
def test_every_linear_parameter_says_how_large_it_is(kind: type[Effect]):
    """But for the control's own correction, which is no error and has no prior."""
    for f in parameter_fields(kind):
        size = f.metadata["typical"]
        assert (size is None) == (bool(f.metadata["scan"]) or f.name == "corrected"), f.name
        assert size is None or (size.amount > 0 and size.why)


@pytest.mark.parametrize("kind", ALL, ids=lambda k: k.name)
def test_typical_amplitudes_are_micrometres(kind: type[Effect]):
    """At its typical amplitude an effect moves something by 10 nm to 0.2 mm, on the run of the contract tests."""
    from tests.physics.factory import INSTANCES

    for effect in (e for e in INSTANCES if type(e) is kind):
        for f in parameter_fields(effect):
            if f.metadata["scan"] or f.name == "corrected":
                continue
            columns = basis(effect, f.name, RUN) * typical(effect, f.name)
            shift, turn = np.abs(columns[:, :3]).max(initial=0.0), np.abs(columns[:, 3:]).max(initial=0.0)
            largest = max(shift, 400.0 * turn)
            if largest:  # some instances do not use every parameter: a shift has no tilt
                assert 1e-5 < largest < 0.2, f"{effect.id}.{f.name}"


def test_typical_by_hand():
    assert typical(GeometricChange("EXX"), "coefficients") == 1e-3  # 1 um
    assert typical(GeometricChange("EBX"), "coefficients") == 3e-6  # 3 urad
    assert typical(RotaryCyclic("ECC"), "amplitude") == pytest.approx(10e-6)  # by the name files use
    assert typical(DynamicPitch("X"), "k") == pytest.approx(5e-9)  # 5 urad/(m/s^2)
    assert typical(ScaleFactor("X"), "k") == pytest.approx(5e-6)  # 5 ppm
    assert typical(PartExpansion(), "corrected") == pytest.approx(1e-6)  # none declared: 1 um/(m K)
    with pytest.raises(UsageError, match="has no parameter kk"):
        typical(ScaleFactor("X"), "kk")
