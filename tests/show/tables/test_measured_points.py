"""A virtual measurement as table, document and file."""

from __future__ import annotations

import csv
import io
from types import SimpleNamespace

import numpy as np

from vcmm.show.tables.measured_points import measure_json, points_csv, values
from vcmm.show.tables.table import in_terminal

VALUE = SimpleNamespace(name="bore", type="size", unit="mm", nominal=30.0, value=30.00012)
ONE = SimpleNamespace(
    values=(VALUE,), points=np.array([[1.0, 2.0, 3.0005]]), normals=np.array([[0.0, 0.0, 1.0]]),
    nominal_points=np.array([[1.0, 2.0, 3.0]]), errors=np.array([5e-4]), features=("top",),
)  # fmt: skip


def test_one_measurement():
    assert in_terminal(values(ONE)).rows == [["bore", "size", "30.00000 mm", "30.00012 mm", "+0.12 µm"]]
    assert measure_json(ONE) == {
        "characteristics": [{"name": "bore", "type": "size", "nominal_mm": 30.0, "value_mm": 30.00012}],
        "points": [
            {
                "feature": "top",
                "nominal_mm": [1.0, 2.0, 3.0],
                "measured_mm": [1.0, 2.0, 3.0005],
                "error_mm": 5e-4,
            }
        ],
    }
    (row,) = csv.DictReader(io.StringIO(points_csv(ONE)))
    assert (row["feature"], row["measured_z_mm"], row["nz"], row["error_um"]) == (
        "top",
        "3.000500000",
        "1.000000000",
        "0.500000",
    )
