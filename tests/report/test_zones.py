"""Zones of a decision."""

from __future__ import annotations

import math
import xml.etree.ElementTree as ET

import pytest

from tests.report.drawn import NAN, rects, the_svg, value
from vcmm import report
from vcmm.core.errors import UsageError
from vcmm.report.zones import zone_list, zone_of


def test_zone_list() -> None:
    zones = zone_list(10.0, 20.0, 1.0)
    assert [(z.low, z.high, z.kind) for z in zones] == [
        (-math.inf, 9.0, "bad"),
        (9.0, 11.0, "warning"),
        (11.0, 19.0, "good"),
        (19.0, 21.0, "warning"),
        (21.0, math.inf, "bad"),
    ]
    assert zone_of(11.0, zones).kind == "good"
    assert zone_of(20.5, zones).kind == "warning"
    assert [z.kind for z in zone_list(None, 5.0, 1.0)] == ["good", "warning", "bad"]
    assert [z.kind for z in zone_list(0.0, 1.0, 0.6)] == ["bad", "warning", "warning", "bad"]


def test_zones_drawn_at_the_right_place() -> None:
    markup = report.zones(10.0, 20.0, 12.5, 1.0, 1.0, unit="mm", title="t", width=500)
    svg = the_svg(markup)

    # the axis holds 9 to 21 and 14 % of 12 on each side: 7.32 to 22.68, 15.36 long
    def place(x: float) -> float:
        return (x - 7.32) / 15.36 * 500

    (good,) = rects(svg, "good-soft")[:1]
    assert value(good, "x") == pytest.approx(place(11.0), abs=0.01)
    assert value(good, "x") + value(good, "width") == pytest.approx(place(19.0), abs=0.02)
    whiskers = [line for line in svg.iter("line") if line.get("stroke-width") == "1.6"]
    assert value(whiskers[0], "x1") == pytest.approx(place(11.5), abs=0.01)
    assert value(whiskers[0], "x2") == pytest.approx(place(13.5), abs=0.01)
    assert "The result lies in the conformance zone." in markup
    assert "12.5 ± 1.0 mm" in markup


def test_zones_without_result_and_bad_limits() -> None:
    assert "The result is not available." in report.zones(None, 1.0, NAN, 0.1, 0.1, unit="mm", title="t")
    for lower, upper, guard in ((None, None, 0.1), (2.0, 1.0, 0.1), (0.0, 1.0, -1.0), (0.0, 1.0, NAN)):
        with pytest.raises(UsageError):
            report.zones(lower, upper, 0.5, 0.1, guard, unit="mm", title="t")


def test_a_thin_line_stands_where_the_guard_band_begins() -> None:
    # limits 10 and 20, guard 1: zones meet at 9, 11, 19 and 21; the limits themselves have their own lines
    drawn = the_svg(report.zones(10.0, 20.0, 12.5, 1.0, 1.0, unit="mm", title="t", width=500))
    dashed = sorted(
        value(line, "x1") for line in drawn.iter("line") if "dash" in ET.tostring(line, "unicode")
    )
    assert dashed == pytest.approx([(x - 7.32) / 15.36 * 500 for x in (9, 11, 19, 21)], abs=0.01)
