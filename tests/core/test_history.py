"""History of the axes on small paths by hand: sense, distance since reversal, speed, play."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import UsageError
from vcmm.core.history import (
    path_history,
    play,
    row_history,
    sense_and_since,
    speed_and_acceleration,
    time_since_acceleration,
    travel,
    turning_repeats,
)
from vcmm.core.run import Run

ZIGZAG = np.array([0.0, 1.0, 3.0, 3.0, 2.0, 0.5, 0.5, 4.0])


def test_zigzag_by_hand():
    """Forward to 3, a rest, back to 0.5, a rest, forward to 4: turned at 3 and at 0.5."""
    sense, since = sense_and_since(ZIGZAG)
    assert sense.tolist() == [0, 1, 1, 1, -1, -1, -1, 1]
    assert since.tolist() == [0.0, 1.0, 3.0, 3.0, 1.0, 2.5, 2.5, 3.5]


def test_rounding_is_no_reversal():
    q = np.array([0.0, 1.0, 1.0 - 1e-9, 1.0, 2.0])
    sense, since = sense_and_since(q)
    assert sense.tolist() == [0, 1, 1, 1, 1]
    assert since == pytest.approx([0.0, 1.0, 1.0, 1.0, 2.0])


def test_a_slow_way_back_is_noticed_once_it_is_long_enough():
    """Steps of 0.4 with still = 1: the third step back is 1.2 behind the furthest point, from which the way counts."""
    q = np.array([0.0, 10.0, 9.6, 9.2, 8.8])
    sense, since = sense_and_since(q, still=1.0)
    assert sense.tolist() == [0, 1, 1, 1, -1]
    assert since == pytest.approx([0.0, 10.0, 10.0, 10.0, 1.2])


def test_travel_counts_to_and_fro():
    """1 + 2 + 0 + 1 + 1.5 + 0 + 3.5 = 9."""
    assert travel(ZIGZAG).tolist() == [0.0, 1.0, 3.0, 3.0, 4.0, 5.5, 5.5, 9.0]
    assert travel(np.zeros(0)).shape == (0,)


def test_play_by_hand():
    """Radius 1: the follower stays at 0 until the axis is 1 ahead, at 2 it follows to 1; back from 2 it rests at 1
    until the axis is below 0, at -0.5 it is at 0.5.
    """
    q = np.array([0.0, 0.5, 2.0, 1.5, 0.2, -0.5])
    assert play(q, 1.0) == pytest.approx([0.0, 0.5, 1.0, 0.5, -0.8, -1.0])
    with pytest.raises(UsageError, match="must be positive"):
        play(q, 0.0)


def test_speed_and_acceleration_of_a_parabola_are_exact():
    """q = 3 t^2: central differences give v = 6 t inside and a = 6 everywhere."""
    t = np.arange(6.0)
    speed, acceleration = speed_and_acceleration(3 * t**2, t)
    assert speed[1:-1] == pytest.approx(6 * t[1:-1])
    assert acceleration == pytest.approx(6.0)


def test_time_must_increase():
    with pytest.raises(UsageError, match="time_s is 1 in row 3, after 1"):
        speed_and_acceleration(np.zeros(3), np.array([0.0, 1.0, 1.0]))


def test_time_since_the_last_acceleration():
    acceleration = np.array([0.0, 5.0, 0.0, 0.0, -5.0, 0.1, 0.0])
    assert time_since_acceleration(acceleration, np.arange(7.0)).tolist() == [0, 0, 1, 2, 0, 1, 2]


def test_columns_of_a_path_and_of_its_touches():
    """Approach, touch and retract of two touches, at rows 2 and 5."""
    x = np.array([0.0, 8.0, 10.0, 8.0, 12.0, 15.0, 12.0])
    t = np.array([0.0, 1.0, 2.0, 3.0, 4.0, 5.0, 6.0])
    path = path_history({"X": x, "C": np.zeros(7)}, t, radii=(0.005,))
    found = {name: values[[2, 5]] for name, values in path.items()}
    assert found["sense_X"].tolist() == [1.0, 1.0]
    assert found["since_reversal_X_mm"].tolist() == [10.0, 7.0]  # turned at 8 before the second touch
    assert found["speed_X_mm_s"].tolist() == [0.0, 0.0]  # (8 - 8) / 2 and (12 - 12) / 2: it turns back there
    assert found["travel_X_mm"].tolist() == [10.0, 19.0]  # 10 + 2 + 4 + 3
    assert found["play_X_5um_mm"] == pytest.approx([0.005, 0.005])
    assert found["sense_C"].tolist() == [0.0, 0.0]
    assert {"since_reversal_C_rad", "speed_C_rad_s", "accel_C_rad_s2", "time_since_accel_s"} <= set(found)


def _run(q: np.ndarray, **columns) -> Run:
    return Run({"X": q}, np.zeros((len(q), 3)), {k: np.array(v, dtype=float) for k, v in columns.items()})


def test_rows_of_a_path():
    found = row_history(_run(ZIGZAG), ["X"])
    assert found["sense_X"].tolist() == [0, 1, 1, 1, -1, -1, -1, 1]
    assert found["since_reversal_X_mm"].tolist() == [0.0, 1.0, 3.0, 3.0, 1.0, 2.5, 2.5, 3.5]


def test_a_new_stretch_begins_unknown():
    """Three rows forward, then another set-up at 5: what the axis did between is not known."""
    starts = np.array([True, False, False, True, False])
    found = row_history(_run(np.array([0.0, 1.0, 2.0, 5.0, 4.0])), ["X"], starts)
    assert found["sense_X"].tolist() == [0, 1, 1, 0, -1]
    assert found["since_reversal_X_mm"].tolist() == [0, 1, 2, 0, 1]


def test_targets_approached_from_both_sides():
    """ISO 230-2 cycle 0 100 200 | 200 100 0 | 0 ...: the repeated target was overrun and approached from beyond."""
    q = np.array([0.0, 100.0, 200.0, 200.0, 100.0, 0.0, 0.0, 100.0])
    found = row_history(_run(q), ["X"], positioned=True)
    assert found["sense_X"].tolist() == [1, 1, 1, -1, -1, -1, 1, 1]
    assert found["since_reversal_X_mm"].tolist() == [0, 100, 200, 0, 100, 200, 0, 100]
    as_path = row_history(_run(q), ["X"])
    assert as_path["sense_X"].tolist() == [0, 1, 1, 1, -1, -1, -1, 1]


def test_of_many_repeats_those_in_between_stay_unknown():
    q = np.array([0.0, 1.0, 1.0, 1.0, 1.0, 0.0])
    assert turning_repeats(q).tolist() == [False, False, True, True, True, False]
    assert row_history(_run(q), ["X"], positioned=True)["sense_X"].tolist() == [1, 1, 0, 0, -1, -1]
    still = np.array([0.0, 1.0, 1.0, 2.0])  # a repeat on the way is no turning point
    assert not turning_repeats(still).any()


def test_a_known_sense_is_kept_and_tells_where_the_axis_turned():
    """Unidirectional: every target from below. After the way back from 2 to 0 the axis turned beyond the target."""
    run = _run(np.array([0.0, 1.0, 2.0, 0.0, 1.0]), sense_X=[1, 1, 1, 1, 1])
    found = row_history(run, ["X"])
    assert "sense_X" not in found
    assert found["since_reversal_X_mm"].tolist() == [0.0, 1.0, 2.0, 0.0, 1.0]
    two_way = _run(np.array([0.0, 2.0, 1.0, 0.0]), sense_X=[1, 1, -1, -1])
    assert row_history(two_way, ["X"])["since_reversal_X_mm"].tolist() == [0.0, 2.0, 1.0, 2.0]
