"""Curves: gaps, bands, thinning."""

from __future__ import annotations

import numpy as np
import pytest

from tests.report.drawn import NAN, coordinates, the_svg
from vcmm import report
from vcmm.core.errors import DataError
from vcmm.report.curve import runs, thin


def test_curve_interrupts_at_nan_and_scales() -> None:
    y = [0.0, 1.0, NAN, 1.0, 0.0]
    svg = the_svg(report.curve([report.PlotSeries(range(5), y, "s")], x_label="x", y_label="y", title="t"))
    lines = [p for p in svg.iter("path") if "s-c1" in (p.get("class") or "") and p.find("title") is not None]
    assert [len(coordinates(p)) for p in lines] == [2, 2]
    (x0, y0), (x1, y1) = coordinates(lines[0])
    (x3, y3), (x4, y4) = coordinates(lines[1])
    assert (y1, y0) == (y3, y4)
    assert y1 < y0  # larger values are higher up
    assert x3 - x1 == pytest.approx(2 * (x1 - x0), abs=0.03)
    assert x4 - x3 == pytest.approx(x1 - x0, abs=0.03)


def test_curve_band_and_limits() -> None:
    series = report.PlotSeries([0, 1], [0, 0], "s", low=[-1, -2], high=[1, 2])
    limit = report.Band(-4.0, 4.0, "MPE")
    svg = the_svg(report.curve([series], x_label="x", y_label="y", title="t", bands=[limit]))
    fills = [p for p in svg.iter("path") if p.get("opacity") and p.get("fill") != "none"]
    heights = [max(y for _, y in coordinates(p)) - min(y for _, y in coordinates(p)) for p in fills]
    assert heights[0] == pytest.approx(2 * heights[1], abs=0.05)  # +-4 against +-2


def test_curve_refuses_other_lengths() -> None:
    with pytest.raises(DataError, match='Curve "s"'):
        report.curve([report.PlotSeries([0, 1], [0], "s")], x_label="", y_label="", title="t")


def test_runs_and_thin() -> None:
    assert runs(np.array([True, True, False, True])) == [slice(0, 2), slice(3, 4)]
    x = np.arange(100_000.0)
    y = np.zeros_like(x)
    y[54_321] = 7.0
    xs, ys = thin(x, y)
    assert xs.size < 3000
    assert ys.max() == 7.0  # a single peak survives
    assert (xs[0], xs[-1]) == (0.0, 99_999.0)
