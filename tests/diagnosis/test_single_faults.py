"""Faults that single real recordings showed, each made again with a known truth."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.diagnosis import generator as make
from vcmm.core.laws import Normal
from vcmm.core.run import Run
from vcmm.diagnosis.engine import diagnose_recording
from vcmm.diagnosis.plain_words import plain_words
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
    found = diagnose_recording(made, make.machine(), 1, 100)
    assert names(found) == ["air_index"]
    scale = found.answer[0].parameters["scale"]
    assert abs(scale.value - 1.0) < 3 * scale.u < 0.3


def moved(shift, noise_seed: int = 3) -> Recording:
    """A good recording of touches in which the tip has moved by shift(time) (n, 3) mm."""
    good = make.make((), 0.0, noise_seed, replace(make.RICH, n=150, poses=2)).recording
    way = shift(good.run.columns["time_s"])[good.row]
    return replace(good, value=good.value - (way * good.direction).sum(axis=1))


def test_a_step_in_three_directions_is_one_name_with_one_moment():
    step = np.array([6.0, -4.0, 5.0]) * UM
    found = diagnose_recording(
        moved(lambda t: (t > np.quantile(t, 0.3))[:, None] * step), make.machine(), 1, 200
    )
    assert names(found) == ["step_change"]
    numbers = found.answer[0].parameters
    assert set(numbers) == {"a", "a_x", "a_y", "a_z", "t1"}
    said = plain_words(found.answer[0].effect, found.answer[0].where, numbers)
    assert "in several directions at once" in said
    for element, size in zip(("a_x", "a_y", "a_z"), (6.0, -4.0, 5.0)):
        assert abs(numbers[element].value - size) < 4 * numbers[element].u < 6.0


def test_a_step_in_one_direction_stays_one_number():
    step = np.array([0.0, 0.0, 5.0]) * UM
    found = diagnose_recording(
        moved(lambda t: (t > np.quantile(t, 0.3))[:, None] * step), make.machine(), 1, 200
    )
    assert [(a.effect, dict(a.where)) for a in found.answer] == [("step_change", {"direction": "z"})]
