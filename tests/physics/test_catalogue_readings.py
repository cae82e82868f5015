"""Readings, indicated - true: tip form, clamping, cosine error, air, dead path."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.effect import required
from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.physics.catalogue.clamping import Clamping
from vcmm.physics.catalogue.laser import K_H, K_P, K_T, AirIndex, CosineError, DeadPath
from vcmm.physics.structure.tip_form import TipForm, harmonics


def _touch(normal, **columns: float) -> Run:
    named = dict(zip(("nx", "ny", "nz"), normal)) | columns
    return Run(
        {a: np.zeros(1) for a in "XYZ"}, np.zeros((1, 3)), {k: np.array([v]) for k, v in named.items()}
    )


def _laser(x: float, **columns: float) -> Run:
    position = {"X": np.array([x]), "Y": np.zeros(1), "Z": np.zeros(1)}
    named = {"nx": 1.0, "ny": 0.0, "nz": 0.0} | columns
    return Run(position, np.zeros((1, 3)), {k: np.array([v]) for k, v in named.items()})


@pytest.mark.parametrize(
    ("term", "normal", "value"),
    [
        (2, (0.0, 0.0, 1.0), 2.236068),  # sqrt(5) (3 - 1) / 2
        (2, (1.0, 0.0, 0.0), -1.118034),  # sqrt(5) (0 - 1) / 2
        (4, (1.0, 0.0, 0.0), 1.936492),  # cos(2 phi): sqrt(5 x 2 / 24) x 3
        (4, (0.0, 1.0, 0.0), -1.936492),
        (0, (0.6, 0.8, 0.0), 1.859032),  # sin(2 phi) = 2 x 0.6 x 0.8 = 0.96, times 1.936492
        (3, (0.6, 0.0, 0.8), 1.859032),  # cos(phi): sqrt(5 x 2 / 6) x 3 x 0.6 x 0.8
        (1, (0.0, 0.6, 0.8), 1.859032),  # sin(phi)
    ],
)
def test_tip_form_by_hand(term: int, normal, value: float):
    # 1 um of one harmonic of degree 2; a high ball indicates too much, along n
    c = np.zeros(5)
    c[term] = 1e-3
    reading = machine(TipForm("", c)).indication_error(_touch(normal))[0]
    assert reading == pytest.approx(value * 1e-3 * np.array(normal), abs=1e-9)


def test_tip_form_harmonics_are_orthogonal_and_know_no_radius_or_offset():
    # Gauss points in the height times equal steps in azimuth integrate products up to degree 8 exactly
    height, weight = np.polynomial.legendre.leggauss(6)
    azimuth = np.arange(12) * np.pi / 6
    z, phi = (g.ravel() for g in np.meshgrid(height, azimuth, indexing="ij"))
    n = np.stack([np.sqrt(1 - z**2) * np.cos(phi), np.sqrt(1 - z**2) * np.sin(phi), z], axis=1)
    share = np.repeat(weight, 12) / 24
    terms = np.concatenate([np.ones((len(n), 1)), np.sqrt(3) * n, harmonics(n, 4)], axis=1)
    assert terms.T @ (share[:, None] * terms) == pytest.approx(np.eye(25), abs=1e-12)
    assert TipForm("", np.full(12, 1e-3)).rms == pytest.approx(np.sqrt(12) * 1e-3)


def test_tip_form_belongs_to_its_stylus():
    run = Run({}, np.zeros((2, 3)), {c: np.full(2, 0.57735027) for c in ("nx", "ny", "nz")},
              {"stylus": np.array(["down", "side"])})  # fmt: skip
    reading = TipForm("down", np.full(5, 1e-3)).error_motion(run)
    assert np.abs(reading[0]).max() > 1e-4
    assert np.all(reading[1] == 0.0)


def test_clamping_by_hand():
    # p = (50, -100, .) mm over 100 mm: s = 0.5, t = -1: P2(s) = -0.125, s t = -0.5, P2(t) = 1:
    # 1 x (-0.125) + 2 x (-0.5) + 3 x 1 = 1.875 um in z
    run = _touch((0, 0, 1), part_x_mm=50.0, part_y_mm=-100.0, part_z_mm=7.0)
    bent = Clamping("z", np.array([1e-3, 2e-3, 3e-3]))
    assert machine(bent).indication_error(run)[0] == pytest.approx([0, 0, 1.875e-3], abs=1e-15)
    # third order in y over (z, x) = (0.07, 0.5): P2(s) t = (3 x 0.0049 - 1) / 2 x 0.5 = -0.246325
    third = Clamping("y", np.array([0, 0, 0, 0, 1e-3, 0, 0]))
    assert third.error_motion(run)[0, 1] == pytest.approx(-0.246325e-3, abs=1e-15)
    # rms over the square: sqrt(1/5 + 4/9 + 9/5) = 1.563472 um
    assert bent.rms == pytest.approx(1.563472e-3, abs=1e-9)


def test_cosine_error():
    # 1/2 x (1 mrad)^2 x 1000 mm = +0.5 um; a quarter of it for half the angle
    reading = machine(CosineError(1e-3)).indication_error(_laser(1000.0))
    assert reading[0] == pytest.approx([0.5e-3, 0, 0], abs=1e-15)
    assert CosineError(1e-3, 0.25).error_motion(machine().prepare(_laser(1000.0))) == pytest.approx(
        CosineError(0.5e-3).error_motion(machine().prepare(_laser(1000.0)))
    )


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


def _edlen(t: float, p: float, f: float) -> float:
    """Birch & Downs (1993/94): air at t degC, p Pa, f Pa of water vapour, 633 nm."""
    s2 = (1 / 0.6329908) ** 2
    standard = (8342.54 + 2406147 / (130 - s2) + 15998 / (38.9 - s2)) * 1e-8
    dry = p * standard / 96095.43 * (1 + 1e-8 * (0.601 - 0.00972 * t) * p) / (1 + 0.0036610 * t)
    return dry - f * (3.7345 - 0.0401 * s2) * 1e-10


def test_the_three_coefficients_are_those_of_the_edlen_equation():
    # at 20 degC, 101325 Pa, 50 % (saturation 2339 Pa): per K, per hPa, per %; the contract rounds the last to 0.01 ppm
    at = (20.0, 101325.0, 1169.0)
    per_k = _edlen(20.5, *at[1:]) - _edlen(19.5, *at[1:])
    per_hpa = _edlen(20.0, 101375.0, 1169.0) - _edlen(20.0, 101275.0, 1169.0)
    per_pct = _edlen(20.0, 101325.0, 1169.0 + 23.39) - _edlen(*at)
    assert pytest.approx(per_k, rel=0.01) == K_T
    assert pytest.approx(per_hpa, rel=0.01) == K_P
    assert pytest.approx(per_pct, rel=0.2) == K_H


def test_sizes_are_checked():
    with pytest.raises(UsageError, match="give 5, 12 or 21"):
        TipForm("", np.zeros(6))
    with pytest.raises(UsageError, match="give 3 or 7 coefficients"):
        Clamping("z", np.zeros(4))
    with pytest.raises(UsageError, match='must be "x", "y" or "z"'):
        Clamping("Z")
