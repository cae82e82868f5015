"""Edits of TOML texts: the values change, and nothing else."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from vcmm.core.errors import DataError
from vcmm.files.own.placement_writer import number_text, placed_text, pose_texts
from vcmm.files.toml_edits import editable, move_names, with_comment_under, with_value_for_table

WRITTEN = """vcmm = "scenario/1"  # head
[machine]  # ours
name = "x"
# inside
[machine.errors]
table = 'errors.csv'   # the table

# over the part
[part]
a = 1
[machine.axes.X]
travel = [1, 2]
# over the pose
[pose]  # here
shift = [
  "1 mm",  # one
  "2 mm",
  "3 mm",
]  # after
turn = '0 0 1 deg'   # turned

# plan
[[plan.steps]]
points = "errors.csv"
"""


@pytest.fixture
def source(tmp_path):
    (tmp_path / "a").mkdir()
    (tmp_path / "b").mkdir()
    (tmp_path / "a" / "errors.csv").write_text("C0Y\n0\n")
    path = tmp_path / "a" / "scenario.toml"
    path.write_text(WRITTEN)
    return path


def test_names_of_files_are_seen_from_the_new_folder(source, tmp_path):
    for quote in "\"'":
        source.write_text(f"table = {quote}errors.csv{quote}  # said\nother = {quote}none.csv{quote}\n")
        document = editable(source)
        move_names(document, tmp_path / "a", tmp_path / "b")
        assert document.as_string() == f'table = "../a/errors.csv"  # said\nother = {quote}none.csv{quote}\n'


def test_in_the_same_folder_nothing_moves(source, tmp_path):
    document = editable(source)
    move_names(document, tmp_path / "a", tmp_path / "b" / ".." / "a")
    assert document.as_string() == WRITTEN


def test_a_table_gives_way_to_a_name(source):
    """All tables of the machine go, wherever they stand; what stands over the table that follows stays."""
    document = editable(source)
    with_value_for_table(document, "machine", "m.toml")
    text = document.as_string()
    assert text.startswith('vcmm = "scenario/1"  # head\nmachine = "m.toml"\n')
    assert "[machine" not in text
    assert "# inside" not in text
    assert "\n# over the part\n[part]\na = 1\n# over the pose\n[pose]  # here\n" in text


def test_a_name_gives_way_to_a_name(source):
    source.write_text("machine = 'a.toml'  # ours\n[part]\na = 1\n")
    document = editable(source)
    with_value_for_table(document, "machine", "m.toml")
    assert document.as_string() == 'machine = "m.toml"  # ours\n[part]\na = 1\n'


def test_values_over_several_lines_and_dotted_keys_are_replaced(source, tmp_path):
    six = np.array([1.0, 2.5, 3.0, 0.0, 0.0, np.pi / 2])
    text = placed_text(source, tmp_path / "b" / "placed.toml", six)
    assert '[pose]  # here\nshift = "1 2.5 3 mm"  # after\nturn = "0 0 90 deg"   # turned\n' in text
    assert text.count("../a/errors.csv") == 2
    source.write_text('pose.shift = "1 2 3 mm"\n[part]\na = 1\n')
    assert tomllib.loads(placed_text(source, source, six))["pose"] == {
        "shift": "1 2.5 3 mm",
        "turn": "0 0 90 deg",
    }


def test_a_comment_stands_under_its_key():
    assert with_comment_under("[pose]\na = 1\n", ("pose",), "said") == "[pose]\n# said\na = 1\n"
    assert with_comment_under("b = 1\npose = { a = 1 }\n", ("pose",), "x") == "b = 1\npose = { a = 1 }\n# x\n"


def test_numbers_of_a_pose():
    assert pose_texts(np.array([0.1, -0.0, 300.0, 0.0, 0.0, np.radians(30.0)])) == (
        "0.1 0 300 mm",
        "0 0 30 deg",
    )
    assert number_text(-1e-9, 6) == "0"


def test_what_is_no_toml_is_said_with_its_line(source):
    source.write_text("a = 1\nb =\n")
    with pytest.raises(DataError, match=r"scenario.toml:2: not valid TOML"):
        editable(source)
