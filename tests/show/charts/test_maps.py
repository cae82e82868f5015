"""Maps: cells, holes, bands."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.show.charts import ChartSheet, heat_map
from vcmm.show.charts.maps import cell_edges


def test_cells_have_their_band_and_holes_none():
    values = [[0.0, 1.0, -4.0], [np.nan, 4.0, 4.0]]
    marks = [("found", 1.0, 0.0), ("outside", np.nan, 0.0)]
    ax = heat_map(values, [0, 1, 3], [0, 1], x_label="x", y_label="y", unit="µm", title="t", symmetric=True, marks=marks, ax=ChartSheet())  # fmt: skip
    made = ax.collections[0]
    assert np.ma.getmaskarray(made.get_array()).sum() == 1
    assert made.get_clim() == (-4.0, 4.0)
    assert 0.0 in made.norm.boundaries
    assert ax.patch.get_hatch() == "////"
    assert [t.get_text() for t in ax.texts] == ["found"]
    assert ax.figure.axes[1].get_ylabel() == "µm"


def test_borders_lie_half_way_between_centres():
    assert cell_edges(np.array([0.0, 1.0, 3.0])).tolist() == [-0.5, 0.5, 2.0, 4.0]
    assert cell_edges(np.array([7.0])).tolist() == [6.5, 7.5]


@pytest.mark.parametrize(("x", "y", "said"), [([0, 1, 2], [0], "ny, nx"), ([1, 0], [0], "x positions")])
def test_what_is_no_grid_is_refused(x, y, said):
    with pytest.raises(DataError, match=said):
        heat_map(np.zeros((1, 2)), x, y, x_label="", y_label="", unit="", title="t", ax=ChartSheet())
