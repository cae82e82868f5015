"""What a command has read is not replaced by what it writes."""

from __future__ import annotations

import pytest

from vcmm.core.errors import UsageError
from vcmm.core.own_files import command_files
from vcmm.core.text import read_text
from vcmm.core.whole_files import write_files


def test_data_stay_and_own_results_do_not(tmp_path):
    (tmp_path / "data.csv").write_text("1")
    (tmp_path / "second name.csv").symlink_to("data.csv")
    with command_files():
        read_text(tmp_path / "data.csv")
        for name in ("data.csv", "second name.csv"):
            with pytest.raises(UsageError, match=f"{name} is one of the files that this command reads"):
                write_files(tmp_path, {"other.txt": "2", name: "2"})
        assert sorted(p.name for p in tmp_path.iterdir()) == ["data.csv", "second name.csv"]  # all or none
        write_files(tmp_path, {"result.csv": "2"})
        read_text(tmp_path / "result.csv")  # read back, as delivered
        write_files(tmp_path, {"result.csv": "3"})
    assert (tmp_path / "data.csv").read_text() == "1"
    write_files(tmp_path, {"data.csv": "4"})  # a program that calls vcmm decides itself
    assert (tmp_path / "data.csv").read_text() == "4"
