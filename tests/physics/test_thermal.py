"""Thermal drift: sign, lag against the analytic response to a step and a ramp."""

from __future__ import annotations

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.run import Run, Series
from vcmm.physics.structure.thermal import ThermalDrift, ThermalDriftTwoLags


def _run(time: np.ndarray, log: Series | None = None, columns: dict | None = None) -> Run:
    n = len(time)
    return Run(
        {a: np.zeros(n) for a in "XYZ"}, np.zeros((n, 3)), {"time_s": time, **(columns or {})}, {},
        {"air": log} if log else {},
    )  # fmt: skip


def test_without_lag_it_follows_the_column():
    # 0.4 um/K x (21.5 - 20) = 0.6 um in +Z
    run = _run(np.zeros(1), columns={"temp_air_C": np.array([21.5])})
    error = machine(ThermalDrift("z", "air", 0.4e-3)).tip_error(run)
    assert error[0] == pytest.approx([0.0, 0.0, 0.6e-3], abs=1e-15)


def test_without_lag_a_log_is_read_at_the_time_of_the_row():
    # half way between 20 and 22 degC: 0.4 um/K x 1 K
    run = _run(np.array([50.0]), Series(np.array([0.0, 100.0]), np.array([20.0, 22.0])))
    assert ThermalDrift("x", "air", 0.4e-3).error_motion(run)[0, 0] == pytest.approx(0.4e-3, abs=1e-15)


def test_step_response():
    # 1 K at t = 0, entered as two entries at the same time: k (1 - exp(-t / tau))
    log = Series(np.array([-10.0, 0.0, 0.0, 5000.0]), np.array([20.0, 20.0, 21.0, 21.0]))
    time = np.array([-5.0, 0.0, 30.0, 300.0, 900.0, 4000.0])
    drift = ThermalDrift("z", "air", 0.4e-3, 300.0).error_motion(_run(time, log))[:, 2]
    assert drift == pytest.approx(0.4e-3 * np.where(time > 0, 1 - np.exp(-time / 300.0), 0.0), abs=1e-15)
    # by hand: after one time constant 1 - 1/e = 0.632121 of 0.4 um
    assert drift[3] == pytest.approx(0.252848e-3, abs=1e-9)


def test_ramp_response_does_not_depend_on_where_the_log_has_entries():
    # 1 K per 1000 s from t = 0: s (t - tau (1 - exp(-t / tau))); by hand at t = tau = 300: 0.3 - 0.3 x 0.632121 = 0.110364 K
    time = np.array([0.0, 77.0, 300.0, 640.0, 1000.0])
    expected = 1e-3 * (time - 300.0 * (1 - np.exp(-time / 300.0)))
    for nodes in ([0.0, 1000.0], [0.0, 13.0, 500.0, 501.0, 1000.0], list(np.linspace(0, 1000, 101))):
        log = Series(np.array(nodes), 20.0 + 1e-3 * np.array(nodes))
        drift = ThermalDrift("y", "air", 1.0, 300.0).error_motion(_run(time, log))[:, 1]
        assert drift == pytest.approx(expected, abs=1e-12)
    assert expected[2] == pytest.approx(0.110364, abs=1e-6)


def test_a_sharp_step_costs_no_accuracy():
    # the same step entered as a ramp of 1 ns
    log = Series(np.array([0.0, 1e-9, 2000.0]), np.array([20.0, 21.0, 21.0]))
    drift = ThermalDrift("z", "air", 1.0, 300.0).error_motion(_run(np.array([600.0]), log))[0, 2]
    assert drift == pytest.approx(1 - np.exp(-2.0), abs=1e-11)


def test_the_log_must_reach_the_rows():
    log = Series(np.array([0.0, 60.0]), np.array([20.0, 21.0]))
    effect = ThermalDrift("z", "air", 0.4e-3, 300.0)
    assert effect.error_motion(_run(np.array([100.0]), log)).shape == (1, 6)  # within one interval: held
    with pytest.raises(ModelLimit, match=r"row 2 is at 130 s, but the log of temp_air_C ends at 60 s"):
        effect.error_motion(_run(np.array([10.0, 130.0]), log))


def test_a_lag_needs_a_log():
    run = _run(np.zeros(2), columns={"temp_air_C": np.array([21.5, 21.7])})
    with pytest.raises(ModelLimit, match="a lag of 300 s needs a log of temp_air_C"):
        ThermalDrift("z", "air", 0.4e-3, 300.0).error_motion(run)


def test_words_are_checked():
    with pytest.raises(UsageError, match='must be "x", "y" or "z"'):
        ThermalDrift("Z", "air")
    with pytest.raises(UsageError, match="is negative"):
        ThermalDrift("z", "air", 1.0, -1.0)


def test_two_lags_are_two_drifts():
    # step of 1 K at t = 0, seen at 300 s: 0.4 x 0.632121 + 1.0 x (1 - exp(-300 / 3600)) = 0.252848 + 0.079956 um
    log = Series(np.array([-10.0, 0.0, 0.0, 9000.0]), np.array([20.0, 20.0, 21.0, 21.0]))
    run = _run(np.array([300.0]), log=log)
    both = ThermalDriftTwoLags("z", "air", 0.4e-3, 1e-3, 300.0, 3600.0).error_motion(run)
    assert both[0, 2] == pytest.approx(0.332804e-3, abs=1e-9)
    single = [
        ThermalDrift("z", "air", k, tau).error_motion(run) for k, tau in ((0.4e-3, 300.0), (1e-3, 3600.0))
    ]
    assert both == pytest.approx(single[0] + single[1], abs=1e-18)
    assert ThermalDriftTwoLags.diagnosis.family == "thermal_drift"
