"""An error map by hand: a scale error of 10 um/m on X over -1 m to 1 m, and a machine without Y."""

from __future__ import annotations

import csv
import io
from types import SimpleNamespace
from typing import Any

import numpy as np
import pytest

from tests.build import machine
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.physics.catalogue.scale import ScaleFactor
from vcmm.show.pages.field import field_page
from vcmm.show.tables.answers import field_answers
from vcmm.show.tables.error_field import diagonals, field_csv, field_json, maxima, summary
from vcmm.show.tables.table import in_terminal
from vcmm.task.response.volumetric import field


@pytest.fixture(scope="module")
def mapped():
    cmm = machine(ScaleFactor("X", 1e-5))
    return cmm, field(cmm, nodes=3)


def test_maxima(mapped):
    """10e-6 x 1000 mm = 10 µm at both ends, nothing in the middle: 20/3 µm on average."""
    rows = in_terminal(maxima(*mapped)).rows
    assert rows[0][:2] == ["largest tip error", "10.000 µm"]
    assert "X -1000 mm" in rows[0][2]
    assert rows[1] == ["mean tip error", "6.667 µm", "27 points"]
    assert rows[2][1] == "10.000 0.000 0.000 µm"
    assert [r[0] for r in rows[3:]] == ["body diagonal"] * 4
    assert [r[1] for r in in_terminal(summary(mapped[1])).rows][:3] == ["10.000 µm", "6.667 µm", "10.000 µm"]


def test_diagonals(mapped):
    """Along a diagonal of the cube a third of the square of the length lies in X: 20 µm / sqrt(3) = 11.547 µm."""
    table = diagonals(mapped[1])
    assert {row[2].lstrip("+-") for row in in_terminal(table).rows} == {"11.547 µm"}
    body = field_json(mapped[1])["summary"]["body_diagonals_mm"]
    assert [set(d) for d in body] == [{"from", "to", "length_error"}] * 4
    assert abs(body[0]["length_error"]) == pytest.approx(20e-3 / np.sqrt(3), rel=1e-9)


def test_the_file_and_the_document_hold_the_same(mapped):
    rows = list(csv.DictReader(io.StringIO(field_csv(*mapped))))
    errors = field_json(mapped[1])["tip_error_mm"]
    assert len(rows) == len(errors) == 27
    assert set(rows[0]) == {"X_mm", "Y_mm", "Z_mm", "error_x_um", "error_y_um", "error_z_um"}
    for row, error in zip(rows, errors):
        assert float(row["error_x_um"]) == pytest.approx(error[0] * 1e3, abs=1e-9)


def test_a_machine_without_y_has_a_map_and_a_page():
    axes = {a: Axis(a, (0.0, 100.0)) for a in "XZ"}
    lathe = Machine("lathe", "mill", parse_structure("w b Z X t"), axes, (ScaleFactor("X", 1e-5),), ())
    found = field(lathe, nodes=3)
    assert in_terminal(maxima(lathe, found)).rows[1][2] == "9 points"
    assert "Deformed volume" in field_page(lathe, found)


def test_the_largest_error_where_the_inputs_give_nothing():
    """U of a slope, 2 u |x| k: 2 x 2e-6 x 600 mm = 2.4 um at X 600 mm, 0 at X 0, where the error stands that is largest."""
    run = SimpleNamespace(q=lambda axis: np.array([0.0, 600.0]), n=2)
    chain = SimpleNamespace(chain=SimpleNamespace(letters=("X",)))
    u = np.array([[0.0, 0.0, 0.0], [1.2e-3, 0.0, 0.0]])
    errors = np.array([[-10e-3, 0.0, 0.0], [6e-3, 0.0, 0.0]])
    mapped: Any = SimpleNamespace(size=np.array([10e-3, 6e-3]), run=run, tip_error=errors, u=u)
    assert field_answers(chain, mapped)[0].coverage == "the Inputs give no U here, elsewhere up to 2.4 µm"  # type: ignore[arg-type]
    mapped.u = None
    assert field_answers(chain, mapped)[0].coverage == "no Inputs are stated, so no U"  # type: ignore[arg-type]
