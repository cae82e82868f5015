"""Histograms: areas, intervals, labels."""

from __future__ import annotations

import numpy as np
import pytest

from tests.report.drawn import NAN, rects, the_svg, value
from vcmm import report
from vcmm.core.errors import DataError


def test_histogram_areas_are_proportional_to_counts() -> None:
    # densities 2/1, 6/2, 4/1 = 2, 3, 4
    svg = the_svg(report.histogram([0, 1, 3, 4], [2, 6, 4], x_label="x", title="t"))
    areas = [value(r, "width") * value(r, "height") for r in rects(svg, "accent")]
    assert np.array(areas) / areas[0] == pytest.approx([1, 3, 2], rel=1e-3)


def test_histogram_interval_cuts_bars() -> None:
    # one bar from 0 to 4, interval 1 to 3: half of the area is inside
    svg = the_svg(report.histogram([0, 4], [8], interval=(1, 3), x_label="x", title="t"))
    inside = sum(value(r, "width") for r in rects(svg, "accent"))
    outside = sum(value(r, "width") for r in rects(svg, "accent-soft"))
    assert inside == pytest.approx(outside, abs=0.05)


def test_histogram_labels_do_not_touch() -> None:
    marks = [("nominal value", 1.0), ("mean value", 1.01)]
    svg = the_svg(report.histogram([0, 2], [1], marks=marks, x_label="x", title="t"))
    heights = {t.text: value(t, "y") for t in svg.iter("text")}
    assert abs(heights["nominal value"] - heights["mean value"]) >= 14


@pytest.mark.parametrize(
    ("edges", "counts"), [([0, 1], [1, 2]), ([1, 0], [1]), ([0, 1], [NAN]), ([0, 1], [-1])]
)
def test_histogram_refuses(edges: list[float], counts: list[float]) -> None:
    with pytest.raises(DataError):
        report.histogram(edges, counts, x_label="x", title="t")


def test_the_name_of_the_interval_stands_over_its_middle() -> None:
    drawn = the_svg(report.histogram([0, 4], [8], interval=(1, 3), x_label="x", title="t"))
    inside = [r for r in rects(drawn, "accent") if value(r, "width") > 0]
    low = min(value(r, "x") for r in inside)
    high = max(value(r, "x") + value(r, "width") for r in inside)
    (name,) = [t for t in drawn.iter("text") if t.text == "coverage interval"]
    assert value(name, "x") == pytest.approx((low + high) / 2, abs=0.1)
