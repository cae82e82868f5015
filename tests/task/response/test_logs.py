"""Logs that the rows hold by themselves: one rule for files and for recordings in memory."""

from __future__ import annotations

import numpy as np

from vcmm.core.run import Run, Series
from vcmm.task.response.logs import row_logs, with_logs


def run_of(**columns: list[float]) -> Run:
    n = len(next(iter(columns.values())))
    return Run(
        {"X": np.zeros(n)}, np.zeros((n, 3)), {k: np.array(v, dtype=float) for k, v in columns.items()}
    )


def test_rows_of_one_time_are_averaged():
    """20 | 20 and 22 -> 21 | 22 and 20 -> 21 | 23."""
    logs = row_logs(run_of(time_s=[0, 10, 10, 20, 20, 30], temp_air_C=[20, 20, 22, 22, 20, 23]))
    assert logs["air"].time.tolist() == [0, 10, 20, 30]
    assert logs["air"].value.tolist() == [20, 21, 21, 23]


def test_a_clock_that_starts_again_tells_no_past():
    assert row_logs(run_of(time_s=[0, 10, 20, 0, 10, 20], temp_air_C=[20, 20, 20, 26, 26, 26])) == {}


def test_a_log_that_is_given_stays():
    given = Series(np.array([0.0, 100.0]), np.array([19.0, 19.5]))
    run = run_of(time_s=[0, 10, 20], temp_air_C=[20, 20, 20], temp_part_C=[21, 21, 22])
    found = with_logs(Run(run.position, run.offset, run.columns, {}, {"air": given})).series
    assert found["air"] is given
    assert found["part"].value.tolist() == [21, 21, 22]


def test_accelerations_are_logs_of_a_trace_only():
    """Rows 1 ms apart follow a structure that rings; rows 10 s apart do not."""
    fast = run_of(time_s=[0, 0.001, 0.002], accel_Y_mm_s2=[0, 400, 0])
    slow = run_of(time_s=[0, 10, 20], accel_Y_mm_s2=[0, 400, 0])
    assert row_logs(fast)["accel_Y_mm_s2"].value.tolist() == [0, 400, 0]
    assert row_logs(slow) == {}
