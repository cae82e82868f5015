"""Corners under a tolerance: two moves that overlap, by pencil; never slower than stopping."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from tests.programs import corner, line, mill
from vcmm.program.limits import Control
from vcmm.shop.motion.timing import plan_motion


def test_a_quarter_turn_within_10_um_saves_32_ms():
    """1 m/s^2, 10 m/s^3, F3000 = 50 mm/s, 50 mm of X, then 50 mm of Y.

    To rest and from rest: the jerk alone reaches 50 mm/s (v j = 5e5 < a^2 = 1e6), S-curve 2 sqrt(v / j) = 141.42 ms over
    25 x 0.14142 = 3.5355 mm; each line 2 x 0.14142 + (50 - 7.0711) / 50 = 1.14142 s, both 2.28284 s.
    Overlap: sqrt 2 j (T / 2)^3 / 6 = 0.010 mm, T = 2 (0.06 / 14142.1)^(1/3) = 32.38 ms; left j T^3 / 6 = 0.0566 mm before the corner
    (8 x 0.010 / sqrt 2) at j T^2 / 2 = 5.24 mm/s.
    """
    timing = plan_motion(corner(0.010), mill())
    overlap = 2 * (0.06 / (10_000 * math.sqrt(2))) ** (1 / 3)
    assert overlap == pytest.approx(0.03238, abs=1e-5)
    assert timing.seconds == pytest.approx(
        2 * (2 * math.sqrt(0.005) * 2 + (50 - 100 * math.sqrt(0.005)) / 50) - overlap
    )
    begin = timing.seconds / 2 - overlap / 2
    at = timing.state(begin + overlap * np.array([1e-9, 0.5, 1 - 1e-9]))
    assert at.position[0, :2] == pytest.approx([50 - 0.08 / math.sqrt(2), 0.0], abs=1e-7)
    assert at.speed[0, :2] == pytest.approx([5.2414, 0.0], abs=1e-3)
    # in the middle j (T / 2)^3 / 6 = 7.07 um short of the corner in X and as far on in Y: 10 um from it
    assert at.position[1, :2] == pytest.approx([50 - 0.0070711, 0.0070711], abs=1e-7)
    assert at.jerk[:, :2] == pytest.approx(np.full((3, 2), 10_000.0), rel=1e-6)
    times = begin + overlap * np.linspace(0, 1, 2001)
    way = timing.state(times).position[:, :2]
    assert np.hypot(way[:, 0] - 50, way[:, 1]).min() == pytest.approx(0.010, rel=1e-5)


def test_the_motion_is_its_own_derivative_across_an_overlap():
    """Speed, acceleration and jerk by the chain rule against differences of the positions, step 1 us x 4."""
    timing = plan_motion(corner(0.010), mill())
    times = timing.seconds / 2 + np.linspace(-0.012, 0.012, 41)
    h = 1e-4
    here = timing.state(times)
    ahead, behind = timing.state(times + h), timing.state(times - h)
    assert (ahead.position - behind.position)[:, :2] / (2 * h) == pytest.approx(
        here.speed[:, :2], abs=2e-5
    )  # j h^2 / 6
    assert (ahead.speed - behind.speed)[:, :2] / (2 * h) == pytest.approx(here.acceleration[:, :2], abs=1e-6)
    assert (ahead.acceleration - behind.acceleration)[:, :2] / (2 * h) == pytest.approx(
        here.jerk[:, :2], rel=1e-6
    )


def test_jerks_that_one_axis_cannot_do_at_once_do_not_overlap():
    """A turn of 90 degrees from (1, 1) to (-1, 1): Y would brake and speed up at once, 2 j: the control stops.

    Each line of 50 sqrt 2 mm at F3000 sqrt 2 has sqrt 2 of what an axis has: 1.14142 s as above.
    """
    feed = 3000.0 * math.sqrt(2)
    moves = [line((0, 0, 0), (50, 50, 0), feed), line((50, 50, 0), (0, 100, 0), feed)]
    timing = plan_motion(moves, mill())
    assert timing.seconds == pytest.approx(2.282843, abs=1e-6)
    assert not timing.joints.is_overlapped.any()


def stairs(n: int, length: float) -> list:
    points = [np.zeros(3)]
    for k in range(n + 1):
        points.append(points[-1] + length * np.eye(3)[k % 2])
    return [line(a, b) for a, b in pairwise(points)]


def zigzag(n: int, degrees: float, length: float) -> list:
    half, points = math.radians(degrees / 2), [np.zeros(3)]
    for k in range(n + 1):
        points.append(points[-1] + length * np.array([math.cos(half), math.sin(half) * (-1) ** k, 0.0]))
    return [line(a, b) for a, b in pairwise(points)]


@pytest.mark.parametrize(
    "moves", [stairs(20, 50.0), stairs(20, 5.0), zigzag(20, 30, 10.0), zigzag(20, 150, 10.0)]
)
def test_a_wider_tolerance_is_never_slower(moves):
    """From a stop at every corner to 0.3 mm, at typical dynamics of 3 m/s^2 and 50 m/s^3."""
    machine = mill(acceleration=3000.0, jerk=50_000.0)
    seconds = [
        plan_motion(moves, machine, Control(tolerance=t)).seconds for t in (0, 0.001, 0.01, 0.03, 0.1, 0.3)
    ]
    assert (np.diff(seconds) <= 1e-9).all()
    assert seconds[-1] < 0.99 * seconds[0]


def test_twenty_corners_with_the_pencil():
    """20 corners of 50 mm at F6000, 3 m/s^2, 50 m/s^3: the jerk alone reaches 100 mm/s (5e6 < 9e6), 2 sqrt(100 / 5e4) = 89.44 ms over
    4.472 mm; a line takes 0.17889 + (50 - 8.944) / 100 = 0.58944 s, 21 lines 12.378 s with stops. 10 um overlap by
    2 (0.06 / 70711)^(1/3) = 18.94 ms at each of 20 corners: 12.000 s."""
    machine = mill(acceleration=3000.0, jerk=50_000.0)
    assert plan_motion(stairs(20, 50.0), machine, Control(tolerance=0.0)).seconds == pytest.approx(
        12.378, abs=1e-3
    )
    assert plan_motion(stairs(20, 50.0), machine, Control(tolerance=0.01)).seconds == pytest.approx(
        12.000, abs=1e-3
    )


@pytest.mark.parametrize("seed", range(6))
def test_no_program_is_slower_than_with_stops(seed):
    """Walks of lines of all lengths and turns at any feed."""
    rng = np.random.default_rng(seed)
    points = np.cumsum(rng.normal(size=(30, 3)) * 10 ** rng.uniform(-1, 1.5), axis=0)
    feed = float(10 ** rng.uniform(2.5, 4))
    for tolerance in (0.002, 0.01, 0.1):
        moves = [line(a, b, feed) for a, b in pairwise(points)]
        stopping = plan_motion(moves, mill(), Control(tolerance=0.0)).seconds
        assert plan_motion(moves, mill(), Control(tolerance=tolerance)).seconds <= stopping * (1 + 1e-9)
