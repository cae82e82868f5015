"""Files come into being whole or not at all."""

from __future__ import annotations

import pytest

from vcmm.core.errors import Environment
from vcmm.show.console.files import output_folder, write_files, write_text


def test_a_folder_that_can_be_made_is_not_made_yet(tmp_path):
    assert output_folder(tmp_path / "a" / "b") == tmp_path / "a" / "b"
    assert list(tmp_path.iterdir()) == []
    assert write_text(tmp_path / "a" / "b" / "c.txt", "said") == tmp_path / "a" / "b" / "c.txt"
    assert (tmp_path / "a" / "b" / "c.txt").read_text() == "said"


def test_a_folder_that_cannot_be_written(tmp_path):
    (tmp_path / "file").write_text("")
    with pytest.raises(Environment, match="choose another with --out"):
        output_folder(tmp_path / "file" / "below")


def test_no_draft_is_left_where_a_file_cannot_be_replaced(tmp_path):
    (tmp_path / "b.txt").mkdir()
    with pytest.raises(Environment, match="choose another folder"):
        write_files(tmp_path, {"c.txt": "c", "b.txt": "b"})
    assert not list(tmp_path.glob(".*.part"))
