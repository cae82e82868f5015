"""Curves: gaps, bands, limits."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.show.charts import Band, ChartSheet, PlotSeries, curve


def test_a_curve_is_interrupted_where_a_value_is_missing():
    made = [PlotSeries(range(3), [0.0, np.inf, 2.0], "s"), PlotSeries([0, 2], [1, 1], "_t", line=False)]
    ax = curve(made, x_label="X / mm", y_label="µm", title="t", ax=ChartSheet())
    line, dots, _ = ax.get_lines()  # and the line of zero
    assert np.isnan(line.get_ydata()).tolist() == [False, True, False]
    assert (line.get_linestyle(), dots.get_linestyle(), dots.get_marker()) == ("-", "None", "o")
    assert [t.get_text().strip() for t in ax.get_legend().get_texts()] == ["s", "_t"]


def test_bands_stand_where_they_are_given():
    one = PlotSeries([0, 1], [0, 0], "s", low=[-1, -2], high=[1, 2])
    ax = curve([one], x_label="x", y_label="y", title="t", bands=[Band(-4.0, 4.0, "MPE")], ax=ChartSheet())
    own, limit = (c.get_paths()[0].vertices for c in ax.collections)
    assert (own[:, 1].min(), own[:, 1].max()) == (-2.0, 2.0)
    assert (limit[:, 1].min(), limit[:, 1].max()) == (-4.0, 4.0)


def test_other_lengths_are_refused():
    with pytest.raises(DataError, match='Curve "s"'):
        curve([PlotSeries([0, 1], [0], "s")], x_label="", y_label="", title="t", ax=ChartSheet())
