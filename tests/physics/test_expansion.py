"""Thermal expansion of scales and part, and what compensation leaves of its uncertainty."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.core.run import Run
from vcmm.physics.structure.expansion import PartExpansion, ScaleExpansion
from vcmm.task.response.influence import influences, products


def _run(temperature: float, reading: float | None = None, x: float = 300.0) -> Run:
    columns = {"temp_scale_x_C": np.array([temperature]), "temp_part_C": np.array([temperature])}
    if reading is not None:
        columns |= {"reading_scale_x_C": np.array([reading]), "reading_part_C": np.array([reading])}
    columns |= {"part_x_mm": np.array([100.0]), "part_y_mm": np.zeros(1), "part_z_mm": np.array([-40.0])}
    return Run({"X": np.array([x]), "Y": np.zeros(1), "Z": np.zeros(1)}, np.zeros((1, 3)), columns)


def test_a_warm_scale_is_long_and_the_machine_travels_too_far():
    # 8e-6 x 2 K x 300 mm = 4.8 um too far; the indication is 4.8 um too small
    warm = machine(ScaleExpansion("X", 8e-6))
    assert warm.tip_error(_run(22.0))[0] == pytest.approx([4.8e-3, 0.0, 0.0], abs=1e-15)
    assert warm.indication_error(_run(22.0))[0, 0] == pytest.approx(-4.8e-3, abs=1e-15)


def test_compensation_leaves_the_wrong_coefficient_and_the_wrong_sensor():
    # right coefficient, right sensor: nothing; coefficient 7e-6 used for 8e-6: 1e-6 x 2 x 300 = 0.6 um left;
    # sensor reads 21.9 for 22.0: 8e-6 x 0.1 x 300 = 0.24 um left
    assert machine(ScaleExpansion("X", 8e-6, 8e-6)).tip_error(_run(22.0))[0, 0] == pytest.approx(
        0.0, abs=1e-15
    )
    assert machine(ScaleExpansion("X", 8e-6, 7e-6)).tip_error(_run(22.0))[0, 0] == pytest.approx(
        0.6e-3, abs=1e-15
    )
    compensated = machine(ScaleExpansion("X", 8e-6, 8e-6))
    assert compensated.tip_error(_run(22.0, 21.9))[0, 0] == pytest.approx(0.24e-3, abs=1e-14)


def test_what_compensation_leaves_of_the_uncertainty():
    # indicated - true = -(alpha (T - 20) - 8e-6 (T_read - 20)) L with alpha = 8e-6, T = T_read = 22, L = 300 mm:
    #   d/d alpha = -2 x 300 = -600 mm K        u(alpha) = 0.5e-6 /K  ->  u(alpha) dT L = 0.3 um
    #   d/d T     = -8e-6 x 300 = -2.4e-3 mm/K  u(T) = 0.05 K         ->  alpha u(dT) L = 0.12 um
    #   d2/d alpha d T = -300 mm                u(alpha) u(T) L = 0.0075 um
    compensated = machine(ScaleExpansion("X", 8e-6, 8e-6))
    alpha = Input("scale_expansion", "*", "alpha", Normal(0.5e-6))
    sensor = Input("channel", "", "temp_scale_x_C", Normal(0.05))
    run = compensated.prepare(_run(22.0, 22.0))
    found = influences(compensated, run, [alpha, sensor])
    assert found[0].response[0, :, 0] == pytest.approx([-600.0, 0.0, 0.0], rel=1e-12)
    assert found[1].response[0, :, 0] == pytest.approx([-2.4e-3, 0.0, 0.0], rel=1e-9)
    assert abs(found[0].response[0, 0, 0]) * alpha.law.u == pytest.approx(0.3e-3)
    assert abs(found[1].response[0, 0, 0]) * sensor.law.u == pytest.approx(0.12e-3)
    mixed = products(compensated, run, found)
    assert len(mixed) == 1
    assert mixed[0].response[0] == pytest.approx([-300.0, 0.0, 0.0], rel=1e-6)


def test_at_20_degrees_only_the_sensor_counts():
    # dT = 0: u(alpha) dT L = 0, alpha u(dT) L stays, GUM H.1.4
    compensated = machine(ScaleExpansion("X", 8e-6, 8e-6))
    inputs = [
        Input("scale_expansion", "*", "alpha", Normal(0.5e-6)),
        Input("channel", "", "temp_scale_x_C", Normal(0.05)),
    ]
    found = influences(compensated, compensated.prepare(_run(20.0, 20.0)), inputs)
    assert found[0].response[0, 0, 0] == pytest.approx(0.0, abs=1e-12)
    assert found[1].response[0, 0, 0] == pytest.approx(-2.4e-3, rel=1e-9)


def test_a_warm_part_is_indicated_larger():
    # reading +11.5e-6 x 2 K x p with p = (100, 0, -40) mm: (2.3, 0, -0.92) um
    warm = machine(PartExpansion(11.5e-6))
    expected = np.array([2.3e-3, 0.0, -0.92e-3])
    assert warm.reading(_run(22.0))[0] == pytest.approx(expected, abs=1e-15)
    assert warm.indication_error(_run(22.0))[0] == pytest.approx(expected, abs=1e-15)
    # compensated with 10e-6: 1.5e-6 x 2 K x 100 mm = 0.3 um left
    left = machine(PartExpansion(11.5e-6, 10e-6)).reading(_run(22.0))[0]
    assert left[0] == pytest.approx(0.3e-3, abs=1e-15)


def test_part_point_is_the_tip_where_no_part_is_known():
    # 11.5e-6 x 2 K x 300 mm = 6.9 um
    run = _run(22.0)
    bare = Run(run.position, run.offset, {"temp_part_C": run.columns["temp_part_C"]})
    assert machine(PartExpansion(11.5e-6)).reading(bare)[0, 0] == pytest.approx(6.9e-3, abs=1e-15)
