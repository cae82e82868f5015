"""Rows of short lines: one turn by pencil, noise of rounded numbers, the tolerance, the limits of the axes."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tests.programs import line, mill
from vcmm.program.limits import Control, axis_limits
from vcmm.shop.motion.curves import curves_of
from vcmm.shop.motion.smoothing import PathWishes, smooth_pieces
from vcmm.shop.motion.timing import plan_motion

FAST = {"acceleration": 3000.0, "jerk": 50_000.0}


def test_one_turn_by_pencil():
    """Lines of 1 and 9 mm with a turn of u = (0, 0.01) at s = 1, asked for at 100 mm/s with 3 m/s^2 and 50 m/s^3.

    Jerk: h = sqrt(u v^3 / 0.5 j) = sqrt(1e4 / 2.5e4) = 0.632 mm, acceleration u v^2 / 0.6 a = 0.056 mm; not less than the shorter
    line, and the row begins 1 mm before: h = 1. The corner is left by
    u h / 6 = 1.667 um, curvature u / h = 0.01 / mm in the middle, third derivative u / h^2 = 0.01 / mm^2, exact ends.
    """
    curves = curves_of([line((0, 0, 0), (1, 0, 0)), line((1, 0, 0), (10, 0.09, 0))])
    limits = axis_limits(mill(**FAST))
    asked = PathWishes(
        np.full(2, 100.0), np.full(2, 0.010), np.full(2, 5e4), np.array([0.0, curves.length.sum()]), limits
    )
    pieces = smooth_pieces(curves, np.array([True]), np.zeros(1), asked)
    assert pieces.begin == pytest.approx([0.0, 1.0, 2.0])
    y = pieces.coefficients[:, :, 1]
    turn = 0.09 / np.hypot(9, 0.09)  # 0.0099995: 9 mm are measured along X
    assert y[0, :4] == pytest.approx([0, 0, 0, turn / 6], abs=1e-12)  # u s^3 / 6 h^2: 1.667 um at the corner
    assert y[1, 0] == pytest.approx(turn / 6, abs=1e-12)
    assert 2 * y[1, 2] == pytest.approx(turn, abs=1e-12)
    assert y[2, :2] == pytest.approx([turn * 1.0, turn * pieces.length[2]], abs=1e-12)


def smooth_line(decimals: int) -> list:
    x = np.arange(501) * 0.2
    points = np.stack([x, 5 * np.sin(2 * np.pi * x / 60), 0.5 * np.sin(2 * np.pi * x / 37)], axis=1)
    return [line(a, b) for a, b in pairwise(np.round(points, decimals))]


def circle(decimals: int) -> list:
    angle = np.linspace(0, 2 * np.pi, 1001)
    points = 50 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    return [line(a, b) for a, b in pairwise(np.round(points, decimals))]


@pytest.mark.parametrize(("moves", "before"), [(smooth_line(3), 3.70), (circle(3), 6.80), (circle(5), 3.36)])
def test_rounded_numbers_cost_little_of_the_feed(moves, before):
    """Length over feed at F6000, and 0.18 s for starting and stopping (2 x 89.4 ms at half the speed on average: 0.09 s); bar: 1.3 of it."""
    length = sum(np.linalg.norm(np.subtract(m.end, m.start)) for m in moves)
    seconds = plan_motion(moves, mill(**FAST), Control(tolerance=0.010)).seconds
    assert seconds <= 1.3 * length / 100.0
    assert seconds < before + 0.03


def test_the_smoothed_circle_is_the_circle():
    """3 decimals: +-0.5 um on the points of R 50; smoothed within 10 um the motion is nearer to the circle than that, not h^2 / 12 R inside.

    The mean of radius over the way amid: chords alone would lie 2/3 of the sagitta 0.314^2 / 400 = 0.25 um inside.
    """
    timing = plan_motion(circle(3), mill(**FAST), Control(tolerance=0.010))
    state = timing.state(np.linspace(0.2, 0.8, 20_000) * timing.seconds)
    radius = np.hypot(*state.position[:, :2].T)
    assert abs(radius.mean() - 50.0) < 5e-5
    assert np.abs(radius - 50.0).max() < 0.71e-3  # half a digit in X and in Y


@pytest.mark.parametrize("tolerance", [0.001, 0.003, 0.010])
@pytest.mark.parametrize("noise", [0.0005, 0.01])
def test_the_path_keeps_its_tolerance_and_the_axes_their_limits(tolerance, noise):
    rng = np.random.default_rng(5)
    x = np.cumsum(rng.uniform(0.02, 0.6, 200))
    points = np.stack([x, np.sin(x) + noise * rng.normal(size=200), noise * rng.normal(size=200)], axis=1)
    moves = [line(a, b) for a, b in pairwise(points)]
    timing = plan_motion(moves, mill(**FAST), Control(tolerance=tolerance))
    times = np.linspace(0, timing.seconds, 40_000)
    state, own = timing.state(times), curves_of(moves)
    move = np.clip(np.searchsorted(timing.ends, state.s), 0, own.n - 1)
    along = np.clip(state.s - (timing.ends - own.length)[move], 0, own.length[move])
    gap = np.linalg.norm((state.position - own.at(move, along))[:, :3], axis=1)
    assert gap.max() <= tolerance * (1 + 1e-9)
    for found, limit in (
        (np.diff(state.speed, axis=0) / times[1], 3000.0),
        (np.diff(state.acceleration, axis=0) / times[1], 50_000.0),
    ):
        assert np.abs(found[:, :3]).max() <= limit * (1 + 1e-6)
