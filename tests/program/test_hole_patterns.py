"""Holes on a circle, on a line and in rows to and fro, by hand."""

from __future__ import annotations

import math

import pytest

from vcmm.program.hole_patterns import hole_circle, hole_grid, hole_line


def test_a_circle_and_a_line():
    # 30 deg on a radius of 10 about (1, 2): 1 + 8.660254, 2 + 5; 5 mm along 90 deg from (1, 2): (1, 7)
    assert hole_circle((1.0, 2.0), 10.0, [math.radians(30)])[0] == pytest.approx((9.660254, 7.0))
    assert hole_line((1.0, 2.0), math.radians(90), [5.0])[0] == pytest.approx((1.0, 7.0))


def test_rows_go_to_and_fro_and_are_turned_about_their_begin():
    assert hole_grid((0.0, 0.0), 0.0, (2, 2), (10.0, 5.0)) == [(0, 0), (10, 0), (10, 5), (0, 5)]
    # a quarter turn takes (10, 5) to (-5, 10); rows along the second axis go up first
    turned = hole_grid((1.0, 1.0), math.pi / 2.0, (2, 2), (10.0, 5.0), along=False)
    assert turned == [pytest.approx(p) for p in ((1, 1), (-4, 1), (-4, 11), (1, 11))]
