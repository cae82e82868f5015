"""What stands around a measurement, as the scenario states it."""

from __future__ import annotations

import pytest

from tests.plate import edited, line_of
from vcmm.core.errors import DataError
from vcmm.files.own.scenario import load_scenario


def around(folder, lines: str):
    return edited(folder, ("[job]\n", f"[surroundings]\n{lines}\n[job]\n"))


@pytest.mark.parametrize(
    ("line", "words"),
    [
        ('head = { quill = "80 0 400 mm" }', "quill must be three positive lengths"),
        ('head = { quill = "-80 80 400 mm" }', "quill must be three positive lengths"),
        ('clamps.left = { centre = "0 0 0 mm", size = "10 10 0 mm" }', "the size of left must be three positive lengths"),
    ],
)  # fmt: skip
def test_no_side_of_a_body_may_be_missing(tmp_path, line, words):
    path = around(tmp_path, line)
    with pytest.raises(DataError, match=words) as caught:
        load_scenario(path)
    assert str(caught.value).startswith(f"{path}:{line_of(path.read_text(), line[:5])}: ")


def test_what_is_stated_stands(tmp_path):
    path = around(tmp_path, 'head = { quill = "90 80 400 mm" }\nclamps.left = { centre = "1 2 3 mm", size = "10 20 30 mm" }')  # fmt: skip
    found = load_scenario(path).surroundings
    assert found.head.quill == pytest.approx((90.0, 80.0, 400.0))
    (clamp,) = found.clamps
    assert (clamp.name, tuple(clamp.size)) == ("left", (10.0, 20.0, 30.0))
    assert clamp.pose.shift == pytest.approx([1.0, 2.0, 3.0])
