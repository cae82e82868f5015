"""One instance of every effect with all parameters set, and a run on which all of them can be asked."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

import vcmm.physics
from vcmm.core.effect import Effect, parameter_fields, typical, with_parameter
from vcmm.core.run import Run, Series

CUBE = np.array([[x, y, z] for x in (0.0, 400.0) for y in (0.0, 300.0) for z in (-200.0, 0.0)])
PROCESS = {
    "margins": "t", "dof": 13, "length_scales_mm": [300.0, 250.0, 150.0], "amplitude_um": [1.0, 0.8, 0.5],
    "correlation": [[1.0, 0.6, 0.0], [0.6, 1.0, 0.1], [0.0, 0.1, 1.0]],
}  # fmt: skip
GRID_X, GRID_Z = np.array([0.0, 150.0, 400.0]), np.array([-200.0, 0.0])


def _numbers(*shape: int) -> np.ndarray:
    """Fixed numbers without pattern, of the size of micrometres in mm."""
    n = int(np.prod(shape))
    return (1e-3 * np.sin(1.7 * np.arange(1, n + 1))).reshape(shape)


def _made(kind: str, *values: object, **more: object) -> tuple[Effect, ...]:
    """One instance of a class; none where its file was taken out of vcmm/physics/."""
    known = getattr(vcmm.physics, kind, None)
    return () if known is None else (known(*values, **more),)


def _usual(kind: type[Effect]) -> Effect:
    """An effect that nobody has stated numbers for, at its typical size."""
    effect = kind()
    for f in parameter_fields(effect):
        if not f.metadata["scan"]:
            size = typical(effect, f.name) * np.ones_like(np.asarray(getattr(effect, f.name), dtype=float))
            effect = with_parameter(effect, f.name, float(size) if size.ndim == 0 else size)
    return effect


STATED: tuple[Effect, ...] = (
    *_made("ComponentTable", "EYX", ("X",), (np.array([0.0, 150.0, 400.0]),), _numbers(3)),
    *_made(
        "ComponentTable",
        "EBX",
        ("Z", "X"),
        (np.array([-200.0, 0.0]), np.array([0.0, 150.0, 400.0])),
        _numbers(2, 3),
    ),
    *_made("ComponentSpline", "EZY", np.array([0.0, 100.0, 200.0, 300.0]), _numbers(4)),
    *_made("ComponentPolynomial", "EAZ", _numbers(3)),
    *_made(
        "CalibrationModes",
        "EBX",
        np.array([0.0, 150.0, 400.0]),
        1e-2 * _numbers(3, 2),
        "cubic",
        np.array([1.5, -0.5]),
    ),
    *_made("CalibrationModes", "A0Z", np.zeros(0), 1e-2 * _numbers(1, 2), modes=np.array([0.5, 2.0])),
    *_made("Squareness", "B0Z", 2e-6),
    *_made("RotaryLocation", "X0C", offset=1.5e-3),
    *_made("RotaryLocation", "A0C", tilt=3e-6),
    *_made("AxisLean", "Z", np.array([3e-6, -2e-6])),
    *_made("CentreLineTilt", "C", np.array([3e-6, -2e-6])),
    *_made("CentreLineOffset", "C", np.array([3e-3, -2e-3])),
    *_made("ScaleFactor", "Y", 4e-6),
    *_made("Backlash", "X", 1.2e-3),
    *_made("ScaleExpansion", "Y", 8e-6, 7e-6),
    *_made("PartExpansion", 11.5e-6, 10e-6),
    *_made("ThermalDrift", "z", "air", 0.4e-3, 300.0),
    *_made("ComponentWarming", "EAZ", "air", 1e-2 * _numbers(2), 300.0),
    *_made("ScrewPitch", "X", 0.5e-3, -0.2e-3, 10.0),
    *_made("ProbeLobing", "", 0.4e-3, 0.1e-3),
    *_made("TipRadius", "", 0.3e-3),
    *_made("TipOffset", "", _numbers(3)),
    *_made("StylusQualification", "", _numbers(4)),
    *_made("StylusBending", "", 0.6e-3),
    *_made("TriggerDelay", "", 2e-3),
    *_made("ResidualField", CUBE, "trilinear", _numbers(8, 3)),
    *_made("ResidualField", CUBE, "columns-linear", _numbers(8, 3)),
    *_made("ResidualField", CUBE, "columns-nearest", _numbers(8, 3)),
    *_made(
        "ResidualField",
        CUBE,
        systematic=_numbers(8, 3),
        random=np.array([1.0, -2.0, 0.5]),
        process=PROCESS,
        scatter=np.abs(_numbers(8, 3)),
        reading_u=np.full((8, 3), 2e-4),
    ),
    *_made("CorrelatedField", CUBE, np.full((8, 3), 1e-3), 150.0, _numbers(8, 3)),
    *_made("Scatter", 0.7e-3),
    *_made("Reindexing", _numbers(3)),
    # the catalogue of contract section 6, beyond the above
    *_made("GeometricChange", "EBX", GRID_X, _numbers(4)),
    *_made("AbbeCountedTwice", "X", ("X",), (GRID_X,), _numbers(3, 3), 1.0),
    *_made("AbbeOffset", "X", ("Z", "X"), (GRID_Z, GRID_X), _numbers(6, 3), np.array([10.0, -20.0, 60.0])),
    *_made("MapInterpolation", "EXX", GRID_X, "smooth", _numbers(3)),
    *_made("LearnedResidual", "EYX", nodes=GRID_X, values=_numbers(len(GRID_X))),
    *_made("CrossAxisFlexure", "Y", "Z", "x", 2e-8),
    *_made("ThermalDriftTwoLags", "y", "air", 0.4e-3, 0.7e-3, 100.0, 2000.0),
    *_made("SettlingDrift", "x", 2e-3 / 3600, 500.0),
    *_made("PartLoad", "X", "z", 5e-8),
    *_made("GradientBending", "Y", "z", 1e-8),
    *_made("DynamicPitch", "X", 5e-9, 2e-9),
    *_made("LinearDrift", "x", 5e-7),
    *_made(
        "StepChange", "y", 1.5e-3, float(np.linspace(0.0, 600.0, 12)[5])
    ),  # at a row, where its slope can be seen
    *_made("StepVector", "xyz", np.array([1e-3, -2e-3, 1.5e-3]), float(np.linspace(0.0, 600.0, 12)[5])),
    *_made("DriftVector", "xz", np.array([5e-7, -2e-7])),
    *_made("ThermalVector", "xyz", "air", np.array([1e-3, -2e-3, 1.5e-3]), 300.0),
    *_made("SpindleGrowth", "Z", 20e-3, 900.0),
    *_made("ScrewHeating", "X", 50e-6, 3e-3, 2e4),
    *_made("LostMotion", "Y", 1e-3, 4e-6),
    *_made("LostMotionTable", "X", np.array([0.0, 150.0, 400.0]), _numbers(3)),
    *_made("Hysteresis", "X", 0.8e-3, 0.7),
    *_made("BacklashRamp", "X", 2e-3, 1e-3, 2.0),
    *_made("PlayOperator", "X", 2e-3, 2.0),
    *_made("ReversalSpike", "Z", 3e-3, 0.7),
    *_made("EncoderInterpolation", "X", 0.1e-3, 0.05e-3, 0.02),
    *_made("ServoLag", "Y", 1e-4),
    *_made("ReadoutDelay", 1e-4),
    *_made("RotaryReadoutDelay", "C", 1e-4),
    *_made("StructuralVibration", "X", 0.5e-3, 0.2e-3, 18.0, 0.04),
    *_made("TipForm", "", _numbers(21)),
    *_made("Clamping", "z", _numbers(7), 150.0),
    *_made("CosineError", 1.5e-3, 0.8),
    *_made("AirIndex", 0.9),
    *_made("DeadPath", 150.0),
    *_made("ToolDeflection", 1e-4),
    *_made("ToolWear", 2e-7),
    *_made("ToolRunout", 4e-3, 1e-3),
    *_made("WorkOffset", "y", 3e-3),
    *_made("ToolLength", "", 2e-3),
    *_made("ToolRadius", "", -1.5e-3),
    *_made("ToolOffset", "", "x", 2e-3),
    *_made("WorkpieceHeating", 5e-9, 900.0),
    *_made("RotaryCyclic", "ECC", _numbers(4)),
    *_made("RotaryCyclic", "EXC", _numbers(2)),
    *_made("GravityFlexure", 2e-5),
    *_made("LostMotionCurve", "Y", np.array([0.0, 300.0]), 1e-3, 4e-6, _numbers(2)),
)
INSTANCES = (*STATED, *(_usual(k) for k in vcmm.physics.ALL if not any(type(e) is k for e in STATED)))


def some_run(n: int = 12) -> Run:
    """n rows inside CUBE with every column that an effect of today needs."""
    rng = np.random.default_rng(5)
    tip = rng.uniform([0.0, 0.0, -200.0], [400.0, 300.0, 0.0], (n, 3))
    normal = rng.standard_normal((n, 3))
    normal /= np.linalg.norm(normal, axis=1)[:, None]
    columns = {f"tip_{c}_mm": tip[:, i] for i, c in enumerate("xyz")}
    columns |= {f"part_{c}_mm": tip[:, i] - 100.0 for i, c in enumerate("xyz")}
    columns |= {f"n{c}": normal[:, i] for i, c in enumerate("xyz")}
    columns |= {f"speed_{a}_mm_s": rng.uniform(-5.0, 5.0, n) for a in "XYZ"}
    columns["speed_C_rad_s"] = 0.01 * columns["speed_X_mm_s"]
    columns |= {f"sense_{a}": rng.choice([-1.0, 1.0], n) for a in "XYZABC"}
    columns |= {
        f"temp_{s}_C": rng.uniform(19.0, 22.0, n) for s in ("part", "air", "scale_x", "scale_y", "scale_z")
    }
    columns |= {
        "time_s": np.linspace(0.0, 600.0, n),
        "probe_angle_rad": rng.uniform(-np.pi, np.pi, n),
        "probe_lateral": rng.uniform(0.0, 1.0, n),
        "stylus_length_mm": rng.uniform(20.0, 80.0, n),
    }
    more = np.random.default_rng(6)
    columns |= {f"since_reversal_{a}_mm": more.uniform(0.0, 3.0, n) for a in "XYZ"}
    columns |= {f"travel_{a}_mm": more.uniform(0.0, 4e4, n) for a in "XYZ"}
    columns |= {f"accel_{a}_mm_s2": more.uniform(-2e3, 2e3, n) for a in "XYZ"}
    columns |= {f"force_{c}_N": more.uniform(-300.0, 300.0, n) for c in "xyz"}
    columns |= {
        "time_since_accel_s": more.uniform(0.0, 0.2, n),
        "temp_gradient_C": more.uniform(-0.5, 0.5, n),
        "load_kg": more.uniform(0.0, 100.0, n),
        "pressure_hPa": more.uniform(980.0, 1030.0, n),
        "humidity_pct": more.uniform(30.0, 60.0, n),
        "cut_length_mm": more.uniform(0.0, 1e5, n),
        "spindle_angle_rad": more.uniform(-np.pi, np.pi, n),
    }
    down = np.random.default_rng(7).standard_normal((n, 3))
    down /= np.linalg.norm(down, axis=1)[:, None]
    columns |= {f"down_{c}": down[:, i] for i, c in enumerate("xyz")}
    position = {"X": tip[:, 0], "Y": tip[:, 1], "Z": tip[:, 2], "C": rng.uniform(-1.0, 1.0, n)}
    labels = {"stylus": np.array(["down"] * n), "event": np.array(["A"] * n), "probed": np.array(["1"] * n)}
    log = Series(np.array([0.0, 200.0, 600.0]), np.array([20.0, 21.0, 20.5]))
    load = Series(log.time, np.array([300.0, 900.0, 100.0]))
    series = {"air": log, "spindle_load_W": load}
    return Run(position, np.tile([0.0, 0.0, -120.0], (n, 1)), columns, labels, series)


def scaled(effect: Effect, factor: float) -> Effect:
    """All parameters in which the effect is linear times a factor."""
    linear = [f.name for f in parameter_fields(effect) if not f.metadata["scan"]]
    return replace(effect, **{name: factor * getattr(effect, name) for name in linear})
