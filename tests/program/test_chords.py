"""Arcs as chords."""

from __future__ import annotations

import math

import pytest

from vcmm.program.chords import SAG, chords


def test_chords_keep_to_the_circle_and_rise_evenly():
    """A quarter of radius 100 that rises 10 mm: steps of 2 acos(1 - 1e-5) = 8.94 mrad, so 176 chords of pi / 2."""
    points = chords((100.0, 0.0, 0.0), (0.0, 100.0, 10.0), (0.0, 0.0, 0.0), (False, 1), "XY")
    assert len(points) == math.ceil(math.pi / 2 / (2 * math.acos(1 - SAG / 100))) == 176
    assert all(math.hypot(p[0], p[1]) == pytest.approx(100) for p in points)
    assert points[87][2] == pytest.approx(5.0)
    assert points[-1] == (0.0, 100.0, 10.0)
