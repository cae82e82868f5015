"""One reader of tables: declared columns, and the rows that other programs write."""

from __future__ import annotations

import ast
import math
from pathlib import Path

import numpy as np
import pytest

import vcmm
from vcmm.core.errors import DataError
from vcmm.files.sheets import Layout, Sheet, SheetColumn, numbers_of, read_csv

TARGET = SheetColumn("target", units=("mm", "deg"))
DEVIATION = SheetColumn("deviation", units=("um", "arcsec"), others=(("actual", ("mm",)),), optional=True)


def sheet(tmp_path: Path, text: str) -> Sheet:
    path = tmp_path / "runs.csv"
    path.write_text(text, encoding="utf-8")
    return read_csv(path)


def test_numbers_come_in_mm_and_rad(tmp_path):
    """90 deg are pi / 2; 3600 arcsec are one degree."""
    found = sheet(tmp_path, "# note\ntarget_deg,deviation_arcsec\n90,3600\n")
    assert found.heading(TARGET) == "target_deg"
    assert found.missing((TARGET, DEVIATION)) == []
    np.testing.assert_allclose(found.quantities(TARGET), [math.pi / 2], rtol=1e-15)
    np.testing.assert_allclose(found.quantities(DEVIATION), [math.pi / 180], rtol=1e-15)


def test_another_name_with_units_of_its_own(tmp_path):
    found = sheet(tmp_path, "target_mm,actual_mm\n10,10.5\n")
    np.testing.assert_array_equal(found.quantities(DEVIATION), [10.5])


def test_what_is_missing_or_stands_twice_is_said_with_the_line_of_the_header(tmp_path):
    found = sheet(tmp_path, "# note\ndeviation_um,actual_mm\n1,2\n")
    assert found.missing((TARGET, DEVIATION, SheetColumn("run", advice="; number the runs"))) == [
        f"{tmp_path}/runs.csv:2: the column target_mm is missing. Allowed: target_mm, target_deg",
        f"{tmp_path}/runs.csv:2: deviation_um and actual_mm are both there; keep one. Allowed: deviation_um, deviation_arcsec, actual_mm",
        f"{tmp_path}/runs.csv:2: the column run is missing; number the runs",
    ]
    problems: list[str] = []
    assert found.quantities_or(DEVIATION, problems) is None
    assert problems == []


def test_an_optional_column_may_be_absent_and_an_alias_is_the_column(tmp_path):
    found = sheet(tmp_path, "target_mm,x\n1,7\n")
    assert found.missing((TARGET, DEVIATION, SheetColumn("X_mm", aliases=("x",)))) == []
    np.testing.assert_array_equal(found.quantities(SheetColumn("X_mm", aliases=("x",))), [7.0])
    assert found.unknown(("x",), lambda name: f"; not {name}") == [
        f'{tmp_path}/runs.csv:1: unknown column "target_mm"; not target_mm'
    ]


def test_bad_cells_of_all_columns_are_said_at_once(tmp_path):
    found = sheet(tmp_path, "x,y\n1,a\nb,2\n3,4\n")
    with pytest.raises(DataError) as error:
        found.stack(["x", "y"])
    assert [p.split(":", 1)[1].split(" ")[0] for p in error.value.problems] == ["3:", "2:"]


def test_rows_of_other_programs():
    lines = ["! head", "", "  1, 2 // two cells", "// none", "3,4"]
    rows = list(Layout(",", comments=("!",), remark="//").rows(lines, first=7))
    assert [(r.line, r.text, r.cells) for r in rows] == [(9, "1, 2", ["1", "2"]), (11, "3,4", ["3", "4"])]
    assert Layout(r"\s{2,}|\t").cells("Meas X  Meas Y\tform") == ["Meas X", "Meas Y", "form"]


@pytest.mark.parametrize(
    ("cells", "words"),
    [
        (["1", "2,5"], '"1 2,5" is not a number; decimals are written with a point'),
        (["nan"], "nan is not finite"),
        (["1e13"], "1e13 is not finite or far too large"),
    ],
)
def test_cells_that_are_no_numbers(cells, words):
    with pytest.raises(DataError, match=f"^a.dat:3: {words}"):
        numbers_of(cells, "a.dat:3")
    assert numbers_of(["1", "-2.5e-3"], "a.dat:3") == [1.0, -0.0025]


def test_nobody_else_reads_csv():
    """The library csv is imported where tables are read, and where text is written."""
    package = Path(vcmm.__file__).parent
    users = {
        path.relative_to(package).as_posix()
        for path in package.rglob("*.py")
        for node in ast.walk(ast.parse(path.read_text(encoding="utf-8")))
        if isinstance(node, ast.Import) and any(alias.name == "csv" for alias in node.names)
    }
    assert users == {"core/text.py", "files/sheets.py"}
