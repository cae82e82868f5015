"""Reading a text file, or saying why not."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.core.text import read_text


def test_a_byte_order_mark_is_no_text(tmp_path):
    path = tmp_path / "a.toml"
    path.write_bytes(b"\xef\xbb\xbfname = 1")
    assert read_text(path) == "name = 1"


def test_a_missing_file_names_its_neighbours(tmp_path):
    (tmp_path / "plate.toml").write_text("")
    with pytest.raises(DataError, match=r'does not exist. Did you mean "plate.toml"\?'):
        read_text(tmp_path / "plat.toml")
    with pytest.raises(DataError, match=r"Files there: plate.toml"):
        read_text(tmp_path / "zzzzzz.toml")
    with pytest.raises(DataError, match="There is no folder"):
        read_text(tmp_path / "no" / "a.toml")


def test_another_encoding_is_named(tmp_path):
    path = tmp_path / "a.csv"
    path.write_bytes("Länge".encode("latin-1"))
    with pytest.raises(DataError, match=r"not UTF-8 text .* at byte 1"):
        read_text(path)
