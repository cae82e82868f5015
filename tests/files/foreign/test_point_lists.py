"""Bare lists of points of other software: units, separators, names, what is refused with its line; evaluated and converted."""

from __future__ import annotations

import json
from pathlib import Path

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.face.cli import run
from vcmm.files.foreign.convert import convert
from vcmm.files.foreign.point_lists import read_point_list
from vcmm.files.own.measured_data import read_measured_points, read_measured_values


def listed(folder: Path, text: str, name: str = "points.xyz", encoding: str = "utf-8") -> Path:
    path = folder / name
    path.write_bytes(text.encode(encoding))
    return path


@pytest.mark.parametrize(("head", "factor"), [("XYZIJK    METRIC\n", 1.0), ("XYZIJK\n", 25.4)])
def test_the_xyz_file_of_pc_dmis(tmp_path: Path, head: str, factor: float) -> None:
    """Millimetres only where METRIC stands from column 11 on; 1 inch = 25.4 mm. The third row is line 4 of the file."""
    path = listed(tmp_path, head + "1,2,3,0,0,1\n-4,5.5,6,0,0,1\n7,8,9,1,0,0\n")
    found = read_point_list(path)
    assert found is not None
    assert found.points.points == pytest.approx(factor * np.array([[1, 2, 3], [-4, 5.5, 6], [7, 8, 9]]))
    assert found.points.normals is not None
    assert found.points.normals[2].tolist() == [1.0, 0.0, 0.0]
    assert found.points.features is None
    assert found.points.where[2] == f"{path}:4"
    assert ("inches" in "".join(found.notes)) == (factor == 25.4)


@pytest.mark.parametrize(
    ("text", "names"),
    [
        ("1.5 -2 3\n4 5 6\n", None),
        ("# points\n1,5\t-2,0\t3\n4\t5\t6\n", None),
        ("1,5;-2;3\r\n4;5;6\r\n", None),
        ("1.5,-2,3\n4,5,6\n", None),
        ("1,5 -2,0 3,0\n4,0 5,0 6,0\n", None),
        ("top 1.5 -2 3\nbore 4 5 6\n", ("top", "bore")),
        ("top;1,5;-2;3;0;0;1\nbore;4;5;6;1;0;0\n", ("top", "bore")),
    ],
)
def test_separators_decimal_commas_and_names(
    tmp_path: Path, text: str, names: tuple[str, ...] | None
) -> None:
    found = read_point_list(listed(tmp_path, text))
    assert found is not None
    assert found.points.points.tolist() == [[1.5, -2.0, 3.0], [4.0, 5.0, 6.0]]
    assert found.points.features == names
    assert "states no unit; millimetres are taken" in found.notes[-1]


@pytest.mark.parametrize(
    ("text", "says"),
    [
        ("1 2 3\n4 5\n", ':2: "4 5" is no row like the first, 3 numbers'),
        ("top 1 2 3\n4 5 6 7\n", ':2: "4 5 6 7" is no row like the first, a name and 3 numbers'),
        ("1 2 3\n4 x 6\n", ':2: "4 x 6" is no row like the first'),
        ("1 2 3\n4 nan 6\n", ":2: "),
        ("XYZIJK    METRIC\n1,2,3,0,0,0\n", ":2: the vector i, j, k has no length"),
        ("XYZIJK    METRIC\n1,2,3,25\n", ":2: 4 numbers in a row"),
        ("XYZIJK    METRIC\n", ":1: there is no point after the heading"),
    ],
)
def test_what_is_refused(tmp_path: Path, text: str, says: str) -> None:
    with pytest.raises(DataError) as caught:
        read_point_list(listed(tmp_path, text))
    assert says in str(caught.value)


def test_files_with_a_heading_are_none_of_them(tmp_path: Path) -> None:
    assert read_point_list(listed(tmp_path, "feature,x_mm,y_mm,z_mm\ntop,1,2,3\n")) is None
    assert (
        read_point_list(listed(tmp_path, "1 1 2 3\n")) is None
    )  # a number and three more: who knows which three
    assert read_point_list(listed(tmp_path, "\n")) is None


def test_points_are_converted_and_read_back(tmp_path: Path) -> None:
    made = convert(listed(tmp_path, "top 1.5 -2 3 0 0 1\nbore 4 5 6 1 0 0\n", "scan.asc"))
    back = listed(tmp_path, made.texts["points.csv"], "points.csv")
    (part,) = read_measured_points(back)
    assert (made.kind, made.counts, part.features) == ("list of points", {"points": 2}, ("top", "bore"))
    assert part.points.tolist() == [[1.5, -2.0, 3.0], [4.0, 5.0, 6.0]]


def test_values_are_converted_and_read_back(tmp_path: Path) -> None:
    """A report in inches and degrees: 1.5750 in = 40.005 mm; the row without number is told and left out."""
    report = (
        "DIM D1= 2D DISTANCE FROM A TO B UNITS=IN,$\nAX  NOMINAL  +TOL  -TOL  MEAS  DEV  OUTTOL\nM  1.5748  0.0004  0.0004  1.5750  0.0002  0.0000\n"
        "DIM A1= 2D ANGLE FROM A TO B UNITS=DEG,$\nAX  NOMINAL  +TOL  -TOL  MEAS  DEV  OUTTOL\nA  45.0  0.1  0.1  45.018  0.018  0.0\n"
        "DIM V1= LOCATION OF CIRCLE C UNITS=MM,$\nAX  NOMINAL  +TOL  -TOL  MEAS  DEV  OUTTOL\nV  0.0  0.5938  0.8046  -  -  -\n"
    )  # fmt: skip
    made = convert(listed(tmp_path, report, "report.txt"))
    (values,) = read_measured_values(listed(tmp_path, made.texts["values.csv"], "values.csv"))
    assert made.kind == "PC-DMIS report"
    assert {v.name: v.number for v in values} == pytest.approx({"D1": 40.005, "A1": np.radians(45.018)})
    assert [n for n in made.notes if "report.txt:9: this row has no measured value; left out" in n]


def test_on_the_command_line(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    path = listed(tmp_path, "hello\n", "hello.txt")
    assert run(["convert", str(path)]) == 2
    assert "neither a table of CALYPSO" in capsys.readouterr().err
    path = listed(tmp_path, "1 2 3\n", "scan.xyz")
    assert run(["convert", str(path), "--out", str(tmp_path / "out"), "--json"]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["kind"], found["counts"]) == ("list of points", {"points": 1})
    assert any("states no unit" in w for w in found["warning_texts"])
