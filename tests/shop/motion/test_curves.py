"""Curves of moves: lengths, planes, gaps, bounds of derivatives."""

from __future__ import annotations

import math

import numpy as np
import pytest

from tests.programs import AT, circle, line, mill
from vcmm.program.moves import Move
from vcmm.shop.motion.curves import _six, curves_of, largest_derivatives
from vcmm.shop.motion.timing import plan_motion


def test_helix_length_and_pitch():
    """Two turns of R 10 rising 6 mm: length sqrt((4 pi 10)^2 + 6^2); half-way it has risen 3 mm, at angle 0."""
    timing = plan_motion([circle(10.0, 1200.0, turns=2, clockwise=True, rise=6.0)], mill())
    assert timing.ends[0] == pytest.approx(math.hypot(40 * math.pi, 6))
    middle = timing.state(np.array([timing.seconds / 2])).position[0]
    assert middle[:3] == pytest.approx([10.0, 0.0, 3.0], abs=1e-9)
    quarter = timing.curves.at(np.array([0]), timing.ends[:1] / 8, 0)[0]  # clockwise: from +X to -Y
    assert quarter[:3] == pytest.approx([0.0, -10.0, 0.75], abs=1e-9)


def test_planes_are_right_handed():
    """G18, ZX plane: counter-clockwise goes from +Z to +X."""
    move = Move("arc", AT, (0, 0, 5), (5, 0, 0), plane="ZX", centre=(0, 0, 0), clockwise=False, feed=600.0)
    curves = curves_of([move])
    assert curves.length[0] == pytest.approx(5 * math.pi / 2)
    half = curves.at(np.array([0]), curves.length / 2)[0, :3]
    assert half == pytest.approx([5 / math.sqrt(2), 0, 5 / math.sqrt(2)])


def test_an_arc_that_misses_its_end_closes_the_gap():
    move = Move("arc", AT, (10, 0, 0), (0, 10.002, 0), centre=(0, 0, 0), clockwise=False, feed=600.0)
    curves = curves_of([move])
    ends = curves.at(np.array([0, 0]), np.array([0.0, curves.length[0]]))
    assert ends[:, :3] == pytest.approx(np.array([[10, 0, 0], [0, 10.002, 0]]), abs=1e-12)


def test_bounds_of_the_derivatives_hold():
    rng = np.random.default_rng(3)
    curves = curves_of([line((0, 0, 0), (1, 0, 0))] * 40).with_polynomials(
        rng.normal(size=(40, 6, 6)), np.ones(40)
    )
    bounds, which = largest_derivatives(curves), np.repeat(np.arange(40, 80), 300)
    u = np.tile(np.linspace(0, 1, 300), 40)
    for order, bound in enumerate(bounds, start=1):
        found = np.abs(curves.at(which, u, order)).reshape(40, 300, 6).max(axis=1)
        assert (found <= bound[40:] * (1 + 1e-9)).all()
        if order > 1:
            assert found == pytest.approx(bound[40:], rel=1e-2)  # second and third are exact


def test_axes_stand_at_the_point_plus_the_offset() -> None:
    """1 + 10, 2 - 4, 3 + 60 mm; C stays 0.5 rad."""
    assert _six([(1.0, 2.0, 3.0)], [(0.0, 0.0, 0.5)], [(10.0, -4.0, 60.0)]).tolist() == [
        [11.0, -2.0, 63.0, 0.0, 0.0, 0.5]
    ]
    assert _six([], [], []).shape == (0, 6)
