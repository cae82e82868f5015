"""The time law: seven phases by hand, limits that are never exceeded, paths within their tolerance."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from tests.programs import AT, circle, line, mill, random_moves
from vcmm.core.errors import UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.program.moves import Move, Program
from vcmm.shop.motion.curves import curves_of
from vcmm.shop.motion.timing import plan_motion


def test_one_line_with_seven_phases_by_hand():
    """100 mm, 100 mm/s, 1000 mm/s^2, 10000 mm/s^3: a/j = 0.1 s = v/a, so speeding up takes 0.1 + 0.1 s over
    100/2 x 0.2 = 10 mm; 80 mm at 100 mm/s last 0.8 s; together 0.2 + 0.8 + 0.2 = 1.2 s. Naive: 1.0 s."""
    timing = plan_motion([line((0, 0, 0), (100, 0, 0))], mill())
    assert timing.seconds == pytest.approx(1.2, abs=1e-12)
    state = timing.state(np.array([0.1, 0.2, 0.6, 1.1, 1.2, 5.0]))
    # after 0.1 s of jerk: v = 10000 x 0.01 / 2 = 50 mm/s, x = 10000 x 0.001 / 6 = 1.667 mm
    assert state.speed[:, 0] == pytest.approx([50.0, 100.0, 100.0, 50.0, 0.0, 0.0], abs=1e-9)
    assert state.position[:, 0] == pytest.approx([10 / 6, 10.0, 50.0, 100 - 10 / 6, 100.0, 100.0], abs=1e-9)


def test_a_short_line_never_reaches_its_feed():
    """2 mm: half of it, 1 mm, is sped up in t with v = j t^2 (jerk up t, down t): 1 = v/2 x 2t = j t^3,
    t = (1/10000)^(1/3) = 46.4 ms, so 4 t = 185.7 ms and the peak is 21.5 mm/s."""
    timing = plan_motion([line((0, 0, 0), (2, 0, 0))], mill())
    t = (1 / 10_000) ** (1 / 3)
    assert timing.seconds == pytest.approx(4 * t, rel=1e-9)
    assert timing.state(np.array([2 * t])).speed[0, 0] == pytest.approx(10_000 * t * t, rel=1e-9)


def test_an_oblique_line_may_use_both_axes():
    """At 45 deg the path may have sqrt 2 of what one axis has: 141.4 mm take as long as 100 mm of X at the feed."""
    timing = plan_motion([line((0, 0, 0), (100, 100, 0), 6000.0 * math.sqrt(2))], mill())
    assert timing.seconds == pytest.approx(1.2, abs=1e-12)


def test_a_rapid_runs_at_the_speed_of_its_slowest_axis():
    """100 and 50 mm at 100 mm/s each: X is the longest, as the line above 1.2 s; Y at half speed."""
    timing = plan_motion([Move("rapid", AT, (0, 0, 0), (100, 50, 0))], mill(speed=100.0))
    assert timing.seconds == pytest.approx(1.2, abs=1e-12)
    assert timing.state(np.array([0.6])).speed[0, :2] == pytest.approx([100.0, 50.0])


def test_a_full_circle_runs_at_its_feed():
    """R 25, F 3000 = 50 mm/s: 3 turns; between two times one period 2 pi 25 / 50 = 3.1416 s apart the place is the
    same."""
    timing = plan_motion([circle(25.0, 3000.0, turns=3)], mill())
    period = 2 * math.pi * 25 / 50
    times = 2.0 + np.arange(3) * 0.3
    here, later = timing.state(times), timing.state(times + period)
    assert later.position == pytest.approx(here.position, abs=1e-9)
    assert np.hypot(*here.position[:, :2].T) == pytest.approx(25.0)
    assert np.linalg.norm(here.speed, axis=1) == pytest.approx(50.0)
    # and speeding up to 50 mm/s costs v/a + a/j = 0.05 + 0.1 at most; without it 3 periods
    assert 3 * period < timing.seconds < 3 * period + 0.3


def test_a_small_circle_is_slowed_by_its_bend():
    """R 1 mm at F 6000 would need v^2/R = 10000 mm/s^2; 0.8 of 1000 allows sqrt 800 = 28.28 mm/s, and half of the
    jerk, j R^2 / 2 = v^3, (5000)^(1/3) = 17.1 mm/s, is less."""
    timing = plan_motion([circle(1.0, 6000.0, turns=9)], mill())
    assert timing.elements.speed[0] == pytest.approx(5000 ** (1 / 3))
    assert plan_motion([circle(1.0, 6000.0)], mill(jerk=1e6)).elements.speed[0] == pytest.approx(
        math.sqrt(800)
    )


def test_rotary_alone_is_fed_in_degrees():
    """90 deg at F 900 (deg/min = 15 deg/s): 6 s, and a little for speeding up."""
    move = line((0, 0, 0), (0, 0, 0), 900.0, rotary_end=(0, 0, math.pi / 2))
    timing = plan_motion([move], mill())
    assert 6.0 < timing.seconds < 6.2
    assert timing.state(np.array([3.0])).speed[0, 5] == pytest.approx(math.radians(15))


@pytest.mark.parametrize("seed", range(12))
def test_limits_are_never_exceeded(seed):
    """Speed, acceleration and jerk of every axis, from the chain rule and from differences of dense samples."""
    timing = plan_motion(random_moves(np.random.default_rng(seed), 60), mill())
    times = np.linspace(0, timing.seconds, 100_000)
    state, limits, dt = timing.state(times), timing.limits, times[1]
    assert (np.diff(state.s) >= 0).all()
    for found, limit in (
        (state.speed, limits.speed),
        (state.acceleration, limits.acceleration),
        (state.jerk, limits.jerk),
        (np.diff(state.position, axis=0) / dt, limits.speed),
        (np.diff(state.speed, axis=0) / dt, limits.acceleration),
        (np.diff(state.acceleration, axis=0) / dt, limits.jerk),
    ):
        assert (np.abs(found) / limit).max() <= 1 + 1e-6
    assert (np.abs(state.acceleration) / limits.acceleration).max() > 0.95  # the limits are used


@pytest.mark.parametrize("seed", range(6))
def test_the_path_stays_within_its_tolerance(seed):
    """At the same programmed distance the motion is no further from the program than the tolerance of the joint."""
    moves = random_moves(np.random.default_rng(seed), 60)
    timing = plan_motion(moves, mill())
    own = curves_of([moves[i] for i in timing.moving])
    state = timing.state(np.linspace(0, timing.seconds, 50_000))
    move = np.clip(np.searchsorted(timing.ends, state.s), 0, own.n - 1)
    along = np.clip(state.s - (timing.ends - own.length)[move], 0, own.length[move])
    gap = np.linalg.norm((state.position - own.at(move, along))[:, :3], axis=1)
    tolerance = np.array([0.010 if (t := moves[i].tolerance) is None else t for i in timing.moving])
    both = np.maximum(tolerance, np.concatenate([[0.0], tolerance[:-1]]))
    assert (gap <= both[move] * (1 + 1e-3) + 1e-9).all()
    # 0.57 to 1.0 of it is used: not where to stop is faster (test_overlap holds a corner to its whole tolerance)
    assert (gap / np.maximum(both[move], 1e-9))[both[move] > 0].max() > 0.5


def test_look_ahead_brakes_over_many_short_moves():
    """100 moves of 0.1 mm in line, then a stop: as fast as one move of 10 mm, to the last digit."""
    x = np.linspace(0, 10, 101)
    short = [line((a, 0, 0), (b, 0, 0)) for a, b in pairwise(x)]
    assert plan_motion(short, mill()).seconds == pytest.approx(
        plan_motion([line((0, 0, 0), (10, 0, 0))], mill()).seconds, rel=1e-9
    )


def test_a_gently_bent_polygon_speeds_up_across_its_joints():
    """A polygon on R 100 from rest: 20 mm/s are reached within the distance of one S-curve, not joint by joint."""
    angle = np.linspace(0, 0.5, 101)
    points = 100 * np.stack([np.sin(angle), 1 - np.cos(angle), 0 * angle], axis=1)
    moves = [line(a, b, 1200.0) for a, b in pairwise(points)]
    timing = plan_motion(moves, mill())
    one = plan_motion([line((0, 0, 0), (50, 0, 0), 1200.0)], mill())
    assert timing.seconds < 1.02 * one.seconds


def test_empty_and_motionless_programs():
    assert plan_motion(Program("fanuc", ()), mill()).seconds == 0.0
    dwell = Move("dwell", AT, (0, 0, 0), (0, 0, 0), seconds=3.0)
    assert plan_motion([dwell], mill()).seconds == 3.0


def test_what_cannot_be_moved_is_refused_with_its_line():
    lathe = Machine(
        "lathe", "lathe", parse_structure("w b Z X t"), {a: Axis(a, (-500.0, 500.0)) for a in "XZ"}
    )
    with pytest.raises(UsageError, match="line 7 moves axis Y, which the machine lacks; it has X, Z"):
        plan_motion([line((0, 0, 0), (0, 1, 0))], lathe)
    with pytest.raises(UsageError, match="line 7: the move has no feed"):
        plan_motion([line((0, 0, 0), (1, 0, 0), None)], mill())
