"""Histograms: areas, intervals, marks."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.show.charts import ChartSheet, distribution

NAN = np.nan


def areas(patch):
    values, edges, _ = patch.get_data()
    return (values * np.diff(edges)).tolist()


def test_areas_are_proportional_to_counts():
    (bars,) = distribution([0, 1, 3, 4], [2, 6, 4], ax=ChartSheet()).patches
    assert areas(bars) == pytest.approx([2 / 12, 6 / 12, 4 / 12])


def test_the_dark_area_is_the_coverage_probability():
    # bars of 2, 4 and 2 counts; from 0.5 to 2.25: half of the first, all of the second, a quarter of the third
    everything, inside, shaded = distribution(
        [0, 1, 2, 3], [2, 4, 2], interval=(0.5, 2.25), ax=ChartSheet()
    ).patches
    assert sum(areas(everything)) == pytest.approx(1.0)
    assert areas(inside) == pytest.approx([1 / 8, 4 / 8, 0.5 / 8])
    assert (shaded.get_x(), shaded.get_width()) == pytest.approx((0.5, 1.75))


def test_limits_and_marks_are_lines_where_they_exist():
    ax = distribution([0, 2], [1], limits=(-np.inf, 4.0), marks={"y": 1.0, "none": NAN}, ax=ChartSheet())
    assert [line.get_xdata()[0] for line in ax.get_lines()] == [4.0, 1.0]
    assert [t.get_text() for t in ax.get_legend().get_texts()] == ["upper limit", "y"]


@pytest.mark.parametrize(
    ("edges", "counts"), [([0, 1], [1, 2]), ([1, 0], [1]), ([0, 1], [NAN]), ([0, 1], [-1])]
)
def test_no_histogram_is_refused(edges, counts):
    with pytest.raises(DataError):
        distribution(edges, counts, ax=ChartSheet())
