"""vcmm/physics/catalogue/laser.py: values by hand."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.effect import parameter, required, typical
from vcmm.core.run import Run
from vcmm.physics.catalogue.laser import K_H, K_P, K_T, AirIndex, CosineError, DeadPath


def _laser(x: float, **columns: float) -> Run:
    position = {"X": np.array([x]), "Y": np.zeros(1), "Z": np.zeros(1)}
    named = {"nx": 1.0, "ny": 0.0, "nz": 0.0} | columns
    return Run(position, np.zeros((1, 3)), {k: np.array([v]) for k, v in named.items()})


def _touch(normal, **columns: float) -> Run:
    named = dict(zip(("nx", "ny", "nz"), normal)) | columns
    return Run(
        {a: np.zeros(1) for a in "XYZ"}, np.zeros((1, 3)), {k: np.array([v]) for k, v in named.items()}
    )


def _edlen(t: float, p: float, f: float) -> float:
    """Birch & Downs (1993/94): air at t degC, p Pa, f Pa of water vapour, 633 nm."""
    s2 = (1 / 0.6329908) ** 2
    standard = (8342.54 + 2406147 / (130 - s2) + 15998 / (38.9 - s2)) * 1e-8
    dry = p * standard / 96095.43 * (1 + 1e-8 * (0.601 - 0.00972 * t) * p) / (1 + 0.0036610 * t)
    return dry - f * (3.7345 - 0.0401 * s2) * 1e-10


def test_cosine_error():
    # 1/2 x (1 mrad)^2 x 1000 mm = +0.5 um; a quarter of it for half the angle
    reading = machine(CosineError(1e-3)).indication_error(_laser(1000.0))
    assert reading[0] == pytest.approx([0.5e-3, 0, 0], abs=1e-15)
    assert CosineError(1e-3, 0.25).error_motion(machine().prepare(_laser(1000.0))) == pytest.approx(
        CosineError(0.5e-3).error_motion(machine().prepare(_laser(1000.0)))
    )


def test_a_typical_beam_is_a_thousandth_off():
    # the angle that is tried, 1 mrad, at the typical share: 1/2 x (1 mrad)^2 = 0.5 um/m, 0.2 um on 400 mm
    (theta,) = parameter(CosineError(0.0), "theta").metadata["scan"]
    usual = CosineError(theta, typical(CosineError(0.0), "share"))
    assert usual.error_motion(machine().prepare(_laser(400.0)))[0, 0] == pytest.approx(0.2e-3, abs=1e-15)


def test_air_index():
    # +2 K, -10 hPa, +10 %: -1.86 - 2.7 - 0.1 = -4.66 ppm of 500 mm = -2.33 um
    air = {"temp_air_C": 22.0, "pressure_hPa": 1003.25, "humidity_pct": 60.0}
    reading = machine(AirIndex(1.0)).indication_error(_laser(500.0, **air))
    assert reading[0] == pytest.approx([-2.33e-3, 0, 0], abs=1e-15)
    dry = machine(AirIndex(1.0)).indication_error(_laser(500.0, temp_air_C=22.0, pressure_hPa=1003.25))
    assert dry[0, 0] == pytest.approx(-2.28e-3, abs=1e-15)  # -4.56 ppm: humidity taken as 50 %


def test_air_index_counts_from_the_zero_of_the_counter():
    # zeroed at X = 100: -4.66 ppm x 400 mm = -1.864 um
    air = {"temp_air_C": 22.0, "pressure_hPa": 1003.25, "humidity_pct": 60.0}
    run = _laser(500.0, **air, counted_x_mm=400.0, counted_y_mm=0.0, counted_z_mm=0.0)
    assert AirIndex(1.0, zero=1).error_motion(run)[0, 0] == pytest.approx(-1.864e-3, abs=1e-15)
    assert "counted_x_mm" in required(AirIndex(1.0, zero=1))


def test_the_beam_of_a_tracer_begins_at_its_station():
    # from (1000, -2000, 0) to (1000, 500, 0): 2500 mm, seen along Y; -4.66 ppm of it = -11.65 um
    air = {"temp_air_C": 22.0, "pressure_hPa": 1003.25, "humidity_pct": 60.0}
    station = {"from_x_mm": 1000.0, "from_y_mm": -2000.0, "from_z_mm": 0.0}
    run = _touch((1000.0, 500.0, 0.0), **air, **station, tip_x_mm=1000.0, tip_y_mm=500.0, tip_z_mm=0.0)
    assert AirIndex(1.0).error_motion(run)[0, :3] == pytest.approx([0.0, -11.65e-3, 0.0], abs=1e-12)
    assert DeadPath(200.0).error_motion(run)[0, :3] == pytest.approx([0.0, -0.932e-3, 0.0], abs=1e-12)
    # 1/2 x (1 mrad)^2 x 2500 mm = 1.25 um
    assert CosineError(1e-3).error_motion(run)[0, :3] == pytest.approx([0.0, 1.25e-3, 0.0], abs=1e-12)


def test_an_instrument_of_its_own_reads_wrong_alone():
    # 1 mrad over 1 m: 0.5e-6 x 1000 mm = 0.5 um, only in the row of that instrument
    two = Run(
        {a: np.zeros(2) for a in "XYZ"},
        np.tile([1000.0, 0.0, 0.0], (2, 1)),
        {},
        {"instrument": np.array(["a", "b"])},
    )
    seen = CosineError(1e-3, 1.0, "b").error_motion(machine().prepare(two))[:, 0]
    assert seen == pytest.approx([0.0, 0.5e-3], abs=1e-15)


def test_dead_path_is_a_constant_length():
    # -4.66 ppm x 200 mm = -0.932 um, wherever the axis stands
    air = {"temp_air_C": 22.0, "pressure_hPa": 1003.25, "humidity_pct": 60.0}
    for x in (0.0, 500.0):
        reading = machine(DeadPath(200.0)).indication_error(_laser(x, **air))
        assert reading[0] == pytest.approx([-0.932e-3, 0, 0], abs=1e-15)


def test_the_three_coefficients_are_those_of_the_edlen_equation():
    # at 20 degC, 101325 Pa, 50 % (saturation 2339 Pa): per K, per hPa, per %; the contract rounds the last to 0.01 ppm
    at = (20.0, 101325.0, 1169.0)
    per_k = _edlen(20.5, *at[1:]) - _edlen(19.5, *at[1:])
    per_hpa = _edlen(20.0, 101375.0, 1169.0) - _edlen(20.0, 101275.0, 1169.0)
    per_pct = _edlen(20.0, 101325.0, 1169.0 + 23.39) - _edlen(*at)
    assert pytest.approx(per_k, rel=0.01) == K_T
    assert pytest.approx(per_hpa, rel=0.01) == K_P
    assert pytest.approx(per_pct, rel=0.2) == K_H
