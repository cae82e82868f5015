"""Faults that single real recordings showed, each made again with a known truth."""

from __future__ import annotations

import numpy as np

from tests.diagnosis import generator as make
from vcmm.core.laws import Normal
from vcmm.core.run import Run
from vcmm.diagnosis.engine import diagnose_recording
from vcmm.diagnosis.result import Diagnosis
from vcmm.response.recording import Recording

UM = 1e-3


def recording(kind: str, run: Run, value: np.ndarray, direction: np.ndarray, noise: float, **nuisance: str):
    """One observation per row, indicated - true (a path: actual - commanded)."""
    n = len(value)
    rows, none = np.arange(n), np.full(n, -1)
    return Recording(
        "made", kind, run, value, kind != "path", rows, direction, none, None, nuisance, Normal(noise)
    )


def names(found: Diagnosis) -> list[str]:
    return sorted(a.effect for a in found.answer)


def test_air_that_a_tracer_does_not_correct_is_no_dead_path():
    # lengths from three stations 1.5 to 2.3 m away; the wavelength is not corrected at all
    rng, n = np.random.default_rng(3), 90
    tip = rng.uniform(-400, 400, (n, 3))
    setup = np.arange(n) * 3 // n
    station = np.array([[-1500.0, 0, 300], [0, -2335.0, 0], [1800.0, 300, -500]])[setup]
    air, pressure = 20 + 2 * np.sin(np.arange(n) / 15), 1013 + 5 * np.cos(np.arange(n) / 20)
    length = np.linalg.norm(tip - station, axis=1)
    index = -0.93e-6 * (air - 20) + 0.27e-6 * (pressure - 1013.25)
    columns = {"temp_air_C": air, "pressure_hPa": pressure, "time_s": 60.0 * np.arange(n)}
    columns |= {"length_mm": length} | {f"from_{c}_mm": station[:, i] for i, c in enumerate("xyz")}
    run = Run(
        {a: tip[:, i] for i, a in enumerate("XYZ")}, np.zeros((n, 3)), columns, {"setup": setup.astype(str)}
    )
    value = length * index + rng.normal(0, 0.5 * UM, n)
    made = recording(
        "length", run, value, (tip - station) / length[:, None], 0.5 * UM, station="setup", radius="setup"
    )
    found = diagnose_recording(made, make.machine(), 1, 200)
    assert names(found) == ["air_index"]
    scale = found.answer[0].parameters["scale"]
    assert abs(scale.value - 1.0) < 3 * scale.u < 0.3
