"""Polar interpolation as motions of X and C, against points of the path by hand."""

from __future__ import annotations

import math

import numpy as np
import pytest

from vcmm.core.errors import ModelLimit
from vcmm.program.moves import Move, Source
from vcmm.shop.motion.polar import CHORD, polar_samples

CENTRE = np.zeros(3)


def side(start, end, **more):
    c = tuple((0.0, 0.0, math.atan2(p[1], p[0])) for p in (start, end))
    return Move(
        "line", Source(4, 1, 2), (*start, 0.0), (*end, 0.0), *c, over_face=True, is_tip_led=True, **more
    )


def between(x, c):
    """Points of the face (k, 2) under the tip halfway between two places of X and C."""
    r, a = 0.5 * (x[1:] + x[:-1]), 0.5 * (c[1:] + c[:-1])
    return np.column_stack([r * np.cos(a), r * np.sin(a)])


def test_a_side_of_a_square():
    """From (20, -20) to (20, 20): X from 28.28 over 20 to 28.28 mm, C from -45 to 45 deg, and no place off the side by more than CHORD."""
    m = side((20.0, -20.0), (20.0, 20.0))
    at, tip, angle = polar_samples(m, CENTRE, np.array([math.sqrt(800.0), 0.0, 0.0]), -math.pi / 4)
    assert tip[[0, -1], 0] == pytest.approx([math.sqrt(800.0)] * 2)
    assert tip[:, 0].min() == pytest.approx(20.0, abs=1e-4)
    assert (angle[0], angle[-1]) == pytest.approx((-math.pi / 4, math.pi / 4))
    assert np.abs(between(tip[:, 0], angle)[:, 0] - 20.0).max() < 1.3 * CHORD
    assert at[:, 0] == pytest.approx(20.0)
    assert (tip[:, 1] == 0.0).all()


def test_a_circle_about_the_axis_turns_c_alone():
    """A full circle of 10 mm radius: one piece would do, C goes on by a whole turn from where it stands."""
    arc = side((10.0, 0.0), (10.0, 0.0), centre=(0.0, 0.0, 0.0), clockwise=False)._replace(kind="arc")
    _, tip, angle = polar_samples(arc, CENTRE, np.array([10.0, 0.0, 0.0]), 0.0)
    assert tip[:, 0] == pytest.approx(10.0)
    assert angle[-1] == pytest.approx(2.0 * math.pi)


def test_c_counts_from_where_polar_interpolation_began():
    """Begun at C 90 deg the X of the face lies there; the tool comes from C 90 and goes on to 135."""
    m = side((20.0, 0.0), (20.0, 20.0))._replace(
        rotary_start=(0, 0, math.pi / 2), rotary_end=(0, 0, 0.75 * math.pi)
    )
    _, _, angle = polar_samples(m, CENTRE, np.array([20.0, 0.0, 0.0]), math.pi / 2)
    assert angle[-1] == pytest.approx(0.75 * math.pi)


def test_a_way_through_the_axis_is_refused():
    with pytest.raises(ModelLimit, match="line 4: polar interpolation leads the tool through the axis of C"):
        polar_samples(side((20.0, 0.0), (-20.0, 0.0)), CENTRE, np.array([20.0, 0.0, 0.0]), 0.0)


def test_a_radial_way_is_one_piece_from_its_start_to_its_end():
    """From (10, 0) to (20, 0): X from 10 to 20 mm, C stays at 0."""
    at, tip, angle = polar_samples(side((10.0, 0.0), (20.0, 0.0)), CENTRE, np.array([10.0, 0.0, 0.0]), 0.0)
    assert at.tolist() == [[10.0, 0.0, 0.0], [20.0, 0.0, 0.0]]
    assert tip[:, 0].tolist() == [10.0, 20.0]
    assert angle.tolist() == [0.0, 0.0]
