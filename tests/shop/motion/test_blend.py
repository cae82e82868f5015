"""Rounded corners: where they begin and how far they leave the path."""

from __future__ import annotations

import math
from itertools import pairwise

import numpy as np
import pytest

from tests.programs import AT, corner, line, mill
from vcmm.program.moves import Move
from vcmm.shop.motion.blend import deviations, reach_of_blends
from vcmm.shop.motion.curves import curves_of
from vcmm.shop.motion.timing import Timing, plan_motion


def test_corner_is_left_38_um_early_for_10_um():
    """0.010 x 16 / (3 sqrt 2) = 0.037712 mm, and the middle of the rounding lies 10 um from the corner."""
    curves = curves_of(corner(0.010))
    first, second = np.array([0]), np.array([1])
    reach = reach_of_blends(curves, first, second, np.array([0.010]))
    assert reach == pytest.approx(0.0377124, abs=1e-7)
    assert deviations(curves, first, second, reach, reach) == pytest.approx(0.010, rel=1e-6)


def test_a_tangent_arc_is_run_through_within_the_tolerance():
    arc = Move("arc", AT, (50, 0, 0), (75, 25, 0), centre=(50, 25, 0), clockwise=False, feed=3000.0)
    timing = plan_motion([line((0, 0, 0), (50, 0, 0), 3000.0), arc], mill())
    assert len(timing.first) == 1
    assert timing.joints.reach[0] > 0.5  # deviations of a tangent joint grow with d^2 only: it is long
    assert worst_from_contour(timing, [(0, 50)], [((50, 25), 25)]) < 0.010


def worst_from_contour(timing: Timing, lines, arcs) -> float:
    """Distance in XY of 4000 points of the motion from a contour of lines along X at y = 0 and circles."""
    points = timing.state(np.linspace(0, timing.seconds, 4000)).position[:, :2]
    distance = [np.hypot(points[:, 0] - np.clip(points[:, 0], a, b), points[:, 1]) for a, b in lines]
    distance += [np.abs(np.hypot(*(points - centre).T) - radius) for centre, radius in arcs]
    return float(np.min(distance, axis=0).max())


def test_chords_of_a_circle_run_as_a_circle():
    """Chords of 0.5 mm on R 25 with 10 um: one curve through their ends, at the feed of 50 mm/s, 2500 / 25 = 100 mm/s^2.

    Block by block it would rise to 1.5 times that and fall to 0 in every chord.
    """
    angle = np.linspace(0, 2 * math.pi, 315)
    points = 25 * np.stack([np.cos(angle), np.sin(angle), 0 * angle], axis=1)
    timing = plan_motion([line(a, b, 3000.0) for a, b in pairwise(points)], mill())
    amid = timing.state(np.linspace(0.4, 0.6, 2000) * timing.seconds)
    assert np.linalg.norm(amid.speed[:, :2], axis=1) == pytest.approx(50.0, rel=1e-3)
    assert np.linalg.norm(amid.acceleration[:, :2], axis=1) == pytest.approx(100.0, rel=0.02)
    radius = np.hypot(*amid.position[:, :2].T)
    # spreading each turn of 20 mrad over h = 0.5 mm would take 0.02 x 0.5 / 6 = 1.67 um; moved outwards first, 1 nm is left
    assert radius == pytest.approx(25.0, abs=1e-6)
