"""Polar plots."""

from __future__ import annotations

import math

import pytest

from tests.report.drawn import NAN, coordinates, the_svg
from vcmm import report
from vcmm.core.errors import DataError


def test_polar_radii() -> None:
    # deviations -1 and 2 um: rings from -1 to 2 (step 0.5), inner 0.34, outer 1 of 174 px (400 / 2 - 26)
    svg = the_svg(report.polar([0.0, math.pi / 2, math.pi], [2.0, -1.0, 0.0], title="t"))
    profile = next(p for p in svg.iter("path") if p.get("stroke-width") == "1.6")
    (x0, y0), (x1, y1), (x2, _) = coordinates(profile)
    assert (x0 - 250, y0) == pytest.approx((174, 200), abs=0.02)
    assert (x1, 200 - y1) == pytest.approx((250, 0.34 * 174), abs=0.02)
    assert 250 - x2 == pytest.approx(174 * (0.34 + 0.66 / 3), abs=0.02)
    with pytest.raises(DataError, match="polar"):
        report.polar([0.0], [NAN], title="t")


def test_angles_stand_outside_the_circle_without_touching_it() -> None:
    drawn = the_svg(report.polar([0.0, math.pi / 2, math.pi], [2.0, -1.0, 0.0], title="t"))
    at = {
        t.text: (float(t.get("x") or NAN) - 250, 200 - float(t.get("y") or NAN)) for t in drawn.iter("text")
    }
    assert at["90°"] == pytest.approx((0.0, 174 + 13 - 4.3), abs=0.02)  # above, a line of text higher
    assert at["0°"] == pytest.approx((174 + 7, -4.3), abs=0.02)
    assert at["45°"] == pytest.approx((181 / math.sqrt(2), 181 / math.sqrt(2) - 4.3), abs=0.02)
