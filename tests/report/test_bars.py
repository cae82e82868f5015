"""Bars: lengths and shares."""

from __future__ import annotations

import math

import pytest

from tests.report.drawn import NAN, rects, the_svg, value
from vcmm import report
from vcmm.core.errors import UsageError
from vcmm.report.bars import percent, shares


def test_bar_lengths_are_proportional() -> None:
    svg = the_svg(report.bars([("a", 4.0), ("b", 1.0), ("c", -2.0)], unit="µm", title="t"))
    (a, b), (c,) = rects(svg, "accent"), rects(svg, "c2")
    assert value(a, "width") / value(b, "width") == pytest.approx(4, rel=2e-3)
    assert value(c, "width") / value(b, "width") == pytest.approx(2, rel=2e-3)
    zero = value(a, "x")
    assert value(c, "x") + value(c, "width") == pytest.approx(zero, abs=0.02)  # grows to the left


def test_shares() -> None:
    assert shares([3.0, 4.0]) == pytest.approx([0.36, 0.64])  # 9/25, 16/25
    assert shares([3.0, 4.0], total=10.0) == pytest.approx([0.09, 0.16])  # 9/100, 16/100
    assert shares([3.0, -1.0], share="linear") == pytest.approx([0.75, 0.25])
    assert math.isnan(shares([0.0])[0])
    assert [percent(p) for p in (0.377, 0.004, 0.0, NAN)] == ["38 %", "<1 %", "0 %", "–"]
    with pytest.raises(UsageError, match="Unknown share"):
        shares([1.0], share="cubic")  # type: ignore[arg-type]


def test_stacked_parts_fill_the_width() -> None:
    svg = the_svg(report.stacked([("a", 3.0), ("b", 4.0)], title="t", width=500))
    parts = [r for r in svg.iter("rect") if r.get("height") == "24"]
    # shares 0.36 and 0.64 of 500 px, less 1 px of gap
    assert [value(r, "width") for r in parts] == pytest.approx([179, 319])
