"""CSV files of positions: columns by name and unit; every mistake with its line."""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.core.errors import DataError, UsageError
from vcmm.files.columns import check_channel, file_columns, known_column, read_csv, read_positions


def _write(tmp_path, text: str):
    path = tmp_path / "positions.csv"
    path.write_text(text, encoding="utf-8")
    return path


def test_positions_offsets_columns_and_labels(tmp_path):
    path = _write(
        tmp_path,
        "# taken on Monday\nX_mm;C_deg;offset_z_mm;temp_part_C;probe_angle_deg;stylus\n1;90;-80;20.5;180;down\n\n2;-90;-80;21;0;side\n",
    )
    run = read_positions(path, ("X", "C"))
    assert run.q("X").tolist() == [1.0, 2.0]
    assert run.q("C") == pytest.approx([np.pi / 2, -np.pi / 2])
    assert run.offset.tolist() == [[0.0, 0.0, -80.0]] * 2
    assert run.column("temp_part_C").tolist() == [20.5, 21.0]
    assert run.column("probe_angle_rad") == pytest.approx([np.pi, 0.0])
    assert run.labels["stylus"].tolist() == ["down", "side"]
    assert "C_rad" not in run.columns


@pytest.mark.parametrize(
    ("text", "line", "words"),
    [
        ("X_mm,Y_mm\n1,2\n", 1, ["the column Z_mm is missing", "axes X Y Z"]),
        ("X_mm,Y_mm,Z\n1,2,3\n", 1, ["Z_mm is missing"]),
        ("X_mm,Y_mm,Z_mm\n1,2\n", 2, ["2 cells where the header names 3"]),
        ("# note\nX_mm,Y_mm,Z_mm\n\n1,2,3\n1,2,x\n", 5, ['"x" in column Z_mm is not a number']),
        ("X_mm;Y_mm;Z_mm\n1;2;3,5\n", 2, ["decimals take a point"]),
        (
            "X_mm;Y_mm;Z_mm\n" + 8 * "1,25;2;3\n",
            2,
            ['"1,25" in column X_mm is not a number; decimals take a point (8 of 8 rows'],
        ),
        (
            "X_mm,Y_mm,Z_mm\n1,25,2,0,3,0\n1,5,2,0,3,0\n",
            2,
            ["6 cells where the header names 3, and so in all 2 rows; decimals take a point"],
        ),
        (
            "X_mm,Y_mm,Z_mm,sense_X\n1,2,3,1\n1,2,3,up\n",
            3,
            ['"up" in column sense_X', "write 1 where the axis last moved up"],
        ),
        ("X_mm,Y_mm,Z_mm\n1,2,nan\n", 2, ["is not finite"]),
        ("X_mm,Y_mm,Z_mm,offset_x\n1,2,3,4\n", 1, ['unknown column "offset_x". Did you mean "offset_x_mm"']),
        ("X_mm,Y_mm,Z_mm,temp_prat\n1,2,3,4\n", 1, ['Did you mean "temp_part_C"']),
        ("X_mm,Y_mm,Z_mm,stilus\n1,2,3,a\n", 1, ['Did you mean "stylus"']),
        ("X_mm,Y_mm,Z_mm,X_mm\n1,2,3,4\n", 1, ['"X_mm" is named twice']),
        ("X_mm,Y_mm,Z_mm\n", 1, ["there are no rows"]),
        ("", 1, ["the file is empty"]),
    ],
)
def test_what_is_refused(tmp_path, text, line, words):
    path = _write(tmp_path, text)
    with pytest.raises(DataError) as caught:
        read_positions(path, ("X", "Y", "Z"))
    message = str(caught.value)
    assert f"{path}:{line}: " in message
    assert all(word in message for word in words), message


def test_all_problems_at_once(tmp_path):
    path = _write(tmp_path, "X_mm,Y_m,Z_mm,foo\n1,2,x,4\n1,2,y,4\n")
    with pytest.raises(DataError) as caught:
        read_positions(path, ("X", "Y", "Z"))
    assert len(caught.value.problems) == 5
    assert "Convert the values of Y_m (1 m = 1000 mm) and name the column Y_mm" in str(
        caught.value
    )  # a new name alone would keep metres


def test_a_missing_file_shows_what_is_there(tmp_path):
    _write(tmp_path, "")
    with pytest.raises(DataError, match=r'does not exist. Did you mean "positions.csv"'):
        read_csv(tmp_path / "position.csv")


def test_columns_of_the_contract_are_known():
    known = file_columns()
    for name in (
        "time_s", "since_reversal_X_mm", "speed_X_mm_s", "accel_X_mm_s2", "temp_scale_x_C", "temp_gradient_C", "humidity_pct",
        "spindle_angle_deg", "force_x_N", "head_A_deg", "tool_radius_mm", "raw_X_mm", "dead_path_mm", "d_um", "d_urad", "u_um",
        "from_x_mm", "load_x_mm", "feed_mm_min", "probe_angle_deg", "temp_bed_C", "u_temp_bed_C", "u_X_mm",
    ):  # fmt: skip
        assert known_column(name, known), name
    assert not known_column("temp_part", known)


def test_channels_are_columns_of_a_run():
    check_channel("temp_part_C")
    check_channel("probe_angle_rad")
    with pytest.raises(UsageError, match="no column of a run"):
        check_channel("probe_angle_deg")


def test_a_column_in_another_unit_is_converted_not_renamed(tmp_path):
    """1 rad = 180 / pi = 57.29577951 deg: a new name alone would turn 0.1 rad into 0.1 deg."""
    with pytest.raises(DataError) as caught:
        read_positions(_write(tmp_path, "X_mm,C_rad\n1,0.1\n"), ("X", "C"))
    said = " ".join(caught.value.problems)
    assert "the column C_deg is missing. Convert the values of C_rad (1 rad = 57.29577951 deg)" in said
    assert "rename" not in said
    assert "Did you mean" not in said
