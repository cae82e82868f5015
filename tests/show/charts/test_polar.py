"""Polar plots."""

from __future__ import annotations

import math

import pytest

from vcmm.core.errors import DataError
from vcmm.show.charts import ChartSheet, polar


def test_deviations_stand_on_their_reference_circle():
    ax = polar([0.0, math.pi / 2, math.pi], [2.0, -1.0, 0.0], title="t", ax=ChartSheet())
    reference, lowest, highest, profile = ax.get_lines()
    assert [set(line.get_ydata()) for line in (reference, lowest, highest)] == [{0.0}, {-1.0}, {2.0}]
    assert profile.get_ydata().tolist() == [2.0, -1.0, 0.0, 2.0]  # closed
    # the lowest, 1 below zero of a span of 3, stands at 0.34 of the radius of the highest
    assert (-1.0 - ax.get_rorigin()) / (2.0 - ax.get_rorigin()) == pytest.approx(0.34)
    assert ax.get_title(loc="left").endswith("about this reference: 3.00 µm.")
    with pytest.raises(DataError, match="polar"):
        polar([0.0], [math.nan], title="t", ax=ChartSheet())


def test_what_is_not_finite_interrupts_the_line():
    ax = polar([0.0, 1.0, 2.0], [1.0, math.inf, -1.0], title="t", ax=ChartSheet())
    assert ax.get_title(loc="left").endswith("about this reference: 2.00 µm.")
    assert ax.get_ylim()[0] == -1.0
