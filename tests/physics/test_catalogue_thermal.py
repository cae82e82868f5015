"""Drift, steps and heat of the machine's own making."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.errors import UsageError
from vcmm.core.run import Run, Series
from vcmm.physics.catalogue.drift import LinearDrift, SettlingDrift, StepChange
from vcmm.physics.catalogue.drift_vector import DriftVector, StepVector, ThermalVector
from vcmm.physics.catalogue.heating import ScrewHeating
from vcmm.physics.catalogue.workpiece import WorkpieceHeating
from vcmm.physics.structure.spindle_growth import SpindleGrowth
from vcmm.physics.structure.thermal import ThermalDrift, ThermalDriftTwoLags

E1 = 0.632121  # 1 - 1/e


def _run(time: list[float], x: float = 0.0, log: Series | None = None, **columns: float) -> Run:
    n = len(time)
    more = {k: np.full(n, v) for k, v in columns.items()}
    position = {"X": np.full(n, x), "Y": np.zeros(n), "Z": np.zeros(n)}
    return Run(
        position, np.zeros((n, 3)), {"time_s": np.array(time), **more}, {}, {"air": log} if log else {}
    )


def test_linear_drift():
    # 2 um/h = 2e-3 / 3600 mm/s; after 1800 s +1 um in y
    error = machine(LinearDrift("y", 2e-3 / 3600)).tip_error(_run([0.0, 1800.0]))
    assert error == pytest.approx(np.array([[0, 0, 0], [0, 1e-3, 0]]), abs=1e-15)


def test_a_drift_that_settles_begins_like_a_linear_one_and_ends():
    # 36 um/h = 1e-5 mm/s with 600 s: after 600 s 6 um x (1 - 1/e) = 3.792723 um, at last 6 um; at first 1e-5 t
    error = machine(SettlingDrift("y", 1e-5, 600.0)).tip_error(_run([0.0, 0.6, 600.0, 60000.0]))
    assert error[:, 1] == pytest.approx([0.0, 5.997e-6, 3.792723e-3, 6e-3], abs=1e-9)
    assert SettlingDrift.diagnosis.family == "linear_drift"
    with pytest.raises(UsageError, match="must be above zero"):
        SettlingDrift("y", 1e-5, 0.0)


def test_step_change_comes_after_its_time():
    error = machine(StepChange("z", 3e-3, 100.0)).tip_error(_run([99.0, 100.0, 101.0]))
    assert error[:, 2] == pytest.approx([0.0, 0.0, 3e-3], abs=1e-18)


def test_what_moves_several_directions_at_once_is_the_sum_of_its_directions():
    times = [99.0, 100.0, 3600.0]
    step = machine(StepVector("xz", np.array([2e-3, -1e-3]), 100.0)).tip_error(_run(times))
    assert step == pytest.approx(np.array([[0, 0, 0], [0, 0, 0], [2e-3, 0, -1e-3]]), abs=1e-18)
    # 2 um/h = 2e-3 / 3600 mm/s: after an hour 2 um in x, 4 um in y, -6 um in z
    drift = DriftVector("xyz", np.array([1.0, 2.0, -3.0]) * 2e-3 / 3600)
    assert machine(drift).tip_error(_run(times))[2] == pytest.approx([2e-3, 4e-3, -6e-3], abs=1e-15)
    log = Series(np.array([-10.0, 0.0, 0.0, 9000.0]), np.array([20.0, 20.0, 21.0, 21.0]))
    warm = ThermalVector("xy", "air", np.array([1e-3, -2e-3]), 300.0).error_motion(_run([300.0], log=log))
    # 1 K, one time constant: 0.632121 of 1 um and of -2 um
    assert warm[0, :3] == pytest.approx([0.632121e-3, -1.264241e-3, 0.0], abs=1e-9)
    with pytest.raises(UsageError, match="has 3 numbers; 2 are due"):
        StepVector("xy", np.ones(3))
    with pytest.raises(UsageError, match="allowed: xyz, xy, xz, yz"):
        DriftVector("x")


def test_two_lags_are_two_drifts():
    # step of 1 K at t = 0, seen at 300 s: 0.4 x 0.632121 + 1.0 x (1 - exp(-300 / 3600)) = 0.252848 + 0.079956 um
    log = Series(np.array([-10.0, 0.0, 0.0, 9000.0]), np.array([20.0, 20.0, 21.0, 21.0]))
    run = _run([300.0], log=log)
    both = ThermalDriftTwoLags("z", "air", 0.4e-3, 1e-3, 300.0, 3600.0).error_motion(run)
    assert both[0, 2] == pytest.approx(0.332804e-3, abs=1e-9)
    single = [
        ThermalDrift("z", "air", k, tau).error_motion(run) for k, tau in ((0.4e-3, 300.0), (1e-3, 3600.0))
    ]
    assert both == pytest.approx(single[0] + single[1], abs=1e-18)
    assert ThermalDriftTwoLags.diagnosis.family == "thermal_drift"


def test_spindle_growth_pushes_the_tip_away_from_the_spindle():
    # 20 um x (1 - 1/e) after one time constant, to -Z
    error = machine(SpindleGrowth("Z", 20e-3, 900.0)).tip_error(_run([0.0, 900.0]))
    assert error[:, 2] == pytest.approx([0.0, -20e-3 * E1], abs=1e-7)
    assert np.all(error[:, :2] == 0.0)
    # with a spindle that was started later: 0 s on, whatever the clock says
    assert SpindleGrowth("Z", 20e-3).error_motion(_run([900.0], spindle_on_s=0.0))[0, 2] == 0.0


def test_screw_heating_grows_with_travel():
    # 50 um/m x 300 mm = 15 um when warm, less 5 um: 10 um x (1 - 1/e) after 100 m of travel
    effect = ScrewHeating("X", 50e-6, -5e-3, 1e5)
    error = machine(effect).tip_error(_run([0.0], 300.0, travel_X_mm=1e5))
    assert error[0] == pytest.approx([10e-3 * E1, 0, 0], abs=1e-8)
    assert effect.error_motion(_run([0.0], 300.0, travel_X_mm=0.0))[0, 0] == 0.0


def test_workpiece_heating_leaves_the_part_small():
    # 20 um/(m h) x 0.5 h at p = (100, 0, -50) mm: -1 um and +0.5 um; with tau = 1800 s 0.632121 of it
    run = _run([1800.0], part_x_mm=100.0, part_y_mm=0.0, part_z_mm=-50.0)
    k = 20e-6 / 3600
    assert WorkpieceHeating(k).error_motion(run)[0, :3] == pytest.approx([-1e-3, 0, 0.5e-3], abs=1e-15)
    assert WorkpieceHeating(k, 1800.0).error_motion(run)[0, 0] == pytest.approx(-1e-3 * E1, abs=1e-9)
    assert machine(WorkpieceHeating(k)).indication_error(run)[0, 0] == pytest.approx(-1e-3, abs=1e-15)


def test_words_are_checked():
    with pytest.raises(UsageError, match='must be "x", "y" or "z"'):
        LinearDrift("Z")
    with pytest.raises(UsageError, match="tau is negative"):
        ThermalDriftTwoLags("z", "air", tau_slow=-1.0)
    with pytest.raises(UsageError, match="tau positive"):
        SpindleGrowth("Z", tau=0.0)
    with pytest.raises(UsageError, match="distance must be positive"):
        ScrewHeating("X", distance=0.0)
    with pytest.raises(UsageError, match="is negative"):
        WorkpieceHeating(tau=-1.0)
