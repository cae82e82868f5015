"""Maps: cells and holes."""

from __future__ import annotations

import re

import numpy as np
import pytest

from tests.report.drawn import NAN, the_svg
from vcmm import report
from vcmm.core.errors import DataError
from vcmm.report.heatmap import cell_edges


def test_heat_map_cells_and_holes() -> None:
    markup = report.heat_map([[0.0, 0.0, 4.0], [NAN, 4.0, 4.0]], [0, 1, 2], [0, 1], x_label="x", y_label="y", unit="µm", title="t")  # fmt: skip
    svg = the_svg(markup)
    assert cell_edges(np.array([0.0, 1.0, 3.0])).tolist() == [-0.5, 0.5, 2.0, 4.0]
    cells = [p for p in svg.iter("path") if p.get("shape-rendering") == "crispEdges"]
    boxes = [len(re.findall("M", p.get("d") or "")) for p in cells]
    assert boxes == [
        1,
        1,
        2,
    ]  # hole; the two zeros as one box; 4 in the first row, two 4s as one box in the second
    assert (cells[0].get("fill") or "").startswith("url(#hatch-")
    spans = [[float(x) for x in re.findall(r"[MH](\d+\.?\d*)", p.get("d") or "")] for p in cells]
    assert spans[1][1] - spans[1][0] == pytest.approx(2 * (spans[0][1] - spans[0][0]), abs=0.03)
    assert "not evaluated" in markup
    with pytest.raises(DataError, match="ny, nx"):
        report.heat_map(np.zeros((2, 2)), [0, 1, 2], [0, 1], x_label="", y_label="", unit="", title="t")
    with pytest.raises(DataError, match="x positions"):
        report.heat_map(np.zeros((1, 2)), [1, 0], [0], x_label="", y_label="", unit="", title="t")
