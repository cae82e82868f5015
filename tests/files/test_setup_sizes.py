"""Sizes that no tool has are a wrong unit."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.files.own.setup import load_setup

TOOL = 'vcmm = "setup/1"\n[tools.1]\nlength = "120 mm"\ndiameter = "10 mm"\n'


@pytest.mark.parametrize(
    ("was", "now", "said"),
    [
        ('diameter = "10 mm"', 'diameter = "10 um"', r"setup.toml:4: .*diameter is 0.01 mm, and a tool has 0.02 to 1000 mm; check its unit"),
        ('diameter = "10 mm"', 'diameter = "10 m"', "diameter is 10000 mm"),
        ('length = "120 mm"', 'length = "120 m"', "length is 120000 mm, and a tool has at most 3000 mm"),
        ('diameter = "10 mm"', 'shape = "turning"\nnose_radius = "0.8 um"', "nose_radius is 0.0008 mm, and a tool has 0.001 to 100 mm"),
        ('diameter = "10 mm"', 'shape = "turning"\noffset_x = "-40 m"', "offset_x is -40000 mm"),
    ],
)  # fmt: skip
def test_a_size_that_no_tool_has_is_refused_with_its_line(tmp_path, was, now, said):
    path = tmp_path / "setup.toml"
    path.write_text(TOOL.replace(was, now))
    with pytest.raises(DataError, match=said):
        load_setup(path)


def test_the_smallest_and_the_largest_tool_are_read(tmp_path):
    path = tmp_path / "setup.toml"
    path.write_text(TOOL.replace('"10 mm"', '"20 um"') + '[tools.2]\nlength = "0 mm"\ndiameter = "1 m"\n')
    assert [t.diameter for t in load_setup(path).tools.values()] == pytest.approx([0.02, 1000.0])
