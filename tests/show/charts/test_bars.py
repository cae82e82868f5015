"""Bars: lengths, shares, figures."""

from __future__ import annotations

import math

import pytest

from vcmm.core.errors import UsageError
from vcmm.show.charts import ChartSheet, bars
from vcmm.show.charts.bars import percent, shares

NAN = math.nan


def test_bars_are_as_long_as_their_values_with_figures_and_shares():
    # u = 5: (4 / 5)^2 = 0.64, (3 / 5)^2 = 0.36
    ax = bars([("a", 4.0), ("b", 3.0), ("c", NAN)], unit="µm", title="t", total=5.0, ax=ChartSheet())
    assert [b.get_width() for b in ax.patches] == [4.0, 3.0, 0.0]
    assert [t.get_text() for t in ax.texts] == ["4.00 · 64 %", "3.00 · 36 %", "– · –"]
    assert ax.get_xlim()[0] == 0.0
    assert ax.get_ylim()[0] > ax.get_ylim()[1]  # the first stands on top


def test_negative_bars_go_left_in_another_colour():
    up, down = bars([("a", 1.0), ("b", -2.0)], unit="µm", title="t", share="none", ax=ChartSheet()).patches
    assert (up.get_width(), down.get_width()) == (1.0, -2.0)
    assert up.get_facecolor() != down.get_facecolor()


def test_charts_side_by_side_have_one_scale():
    short, long = (
        bars([("a", v)], unit="µm", title="t", longest=4.0, ax=ChartSheet()).get_xlim() for v in (1.0, 4.0)
    )
    assert short == long


def test_shares():
    assert shares([3.0, 4.0]) == pytest.approx([0.36, 0.64])  # 9/25, 16/25
    assert shares([3.0, 4.0], total=10.0) == pytest.approx([0.09, 0.16])  # 9/100, 16/100
    assert shares([3.0, -1.0], share="linear") == pytest.approx([0.75, 0.25])
    assert math.isnan(shares([0.0])[0])
    assert [percent(p) for p in (0.377, 0.004, 0.0, NAN)] == ["38 %", "<1 %", "0 %", "–"]
    with pytest.raises(UsageError, match="Unknown share"):
        shares([1.0], share="cubic")  # type: ignore[arg-type]
