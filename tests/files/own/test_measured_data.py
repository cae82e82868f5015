"""points.csv and values.csv: columns, units, parts, and what is refused with its line."""

from __future__ import annotations

from pathlib import Path

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.files.own.measured_data import read_measured_points, read_measured_values


def written(folder: Path, text: str) -> Path:
    path = folder / "measured.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_points_of_two_parts_in_another_unit(tmp_path: Path) -> None:
    text = "part;feature;x_in;y_in;z_in\nb;top;1;0;-2\na;top;0;0;0\nb;bore;0.5;0;0\n"
    first, second = read_measured_points(written(tmp_path, text))
    assert (first.part, second.part) == ("b", "a")
    assert np.array_equal(first.points, [[25.4, 0.0, -50.8], [12.7, 0.0, 0.0]])
    assert first.features == ("top", "bore")
    assert [w.rpartition(":")[2] for w in first.where] == ["2", "4"]
    assert first.normals is None
    assert first.styli is None


def test_points_with_normals_and_without_labels(tmp_path: Path) -> None:
    (one,) = read_measured_points(written(tmp_path, "x_mm,y_mm,z_mm,nx,ny,nz\n1,2,3,0,0,1\n"))
    assert one.part == ""
    assert one.features is None
    assert np.array_equal(one.normals, [[0.0, 0.0, 1.0]])


def test_values_as_lengths_angles_and_deviations(tmp_path: Path) -> None:
    text = "characteristic,value_mm,value_deg,deviation_um\nbore,30.01,,\nslope,,90,\nstep,,,-2.5\n"
    (values,) = read_measured_values(written(tmp_path, text))
    assert [(v.name, v.angle, v.deviation) for v in values] == [
        ("bore", False, False),
        ("slope", True, False),
        ("step", False, True),
    ]
    assert [v.number for v in values] == pytest.approx([30.01, np.pi / 2, -2.5e-3])


@pytest.mark.parametrize(
    ("text", "message"),
    [
        (
            "feature,x,y,z\ntop,1,2,3\n",
            'measured.csv:1: the columns x_mm, y_mm, z_mm are missing. "x" states no unit',
        ),
        ("feature,x_mm,y_mm\ntop,1,2\n", "measured.csv:1: the column z_mm is missing"),
        ("featur,x_mm,y_mm,z_mm\ntop,1,2,3\n", 'unknown column "featur". Did you mean "feature"'),
        (
            "feature,x_mm,y_mm,z_mm\ntop,1,2,3\ntop,1,2,nan\n",
            'measured.csv:3: "nan" in column z_mm is not finite',
        ),
        ("feature,x_mm,y_mm,z_mm,nx\ntop,1,2,3,0\n", "the column ny is missing"),
    ],
)
def test_points_that_cannot_be_read(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(DataError) as caught:
        read_measured_points(written(tmp_path, text))
    assert message in str(caught.value)


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("characteristic,value\nbore,30\n", '"value" states no known unit'),
        ("characteristic,value_mm\nbore,30\nbore,31\n", 'measured.csv:3: "bore" is given twice'),
        ("characteristic,value_mm,value_um\nbore,30,1\n", '"bore" has 2 values'),
        ("characteristic,value_mm\nbore,\n", '"bore" has 0 values'),
        (
            "characteristic,value_mm\nbore,thirty\n",
            'measured.csv:2: "thirty" in column value_mm is not a finite number',
        ),
        ("characteristic;value_mm\nbore;30,002\n", "is not a finite number; decimals take a point"),
        ("characteristic,value_mm\nbore,1_000\n", '"1_000" in column value_mm is not a finite number'),
        ("name,value_mm\nbore,30\n", "the column characteristic is missing"),
    ],
)
def test_values_that_cannot_be_read(tmp_path: Path, text: str, message: str) -> None:
    with pytest.raises(DataError) as caught:
        read_measured_values(written(tmp_path, text))
    assert message in str(caught.value)


def test_points_of_vcmm_measure_are_read(tmp_path):
    text = (
        "feature,measured_x_mm,measured_y_mm,measured_z_mm,nominal_x_mm,nominal_y_mm,nominal_z_mm,nx,ny,nz,error_um\n"
        "top,1,2,3.001,1,2,3,0,0,1,1\n"
    )
    (one,) = read_measured_points(written(tmp_path, text))
    assert one.points.tolist() == [[1.0, 2.0, 3.001]]
    assert (one.features, one.normals.tolist()) == (("top",), [[0.0, 0.0, 1.0]])
