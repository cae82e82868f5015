"""Subprograms beside the program."""

from __future__ import annotations

from pathlib import Path

from vcmm.nc.beside import file_beside


def test_the_first_name_that_is_there_in_any_letters(tmp_path: Path):
    (tmp_path / "l140.spf").write_text("M17")
    (tmp_path / "main.mpf").write_text("L140")
    main = str(tmp_path / "main.mpf")
    assert file_beside(main, ["L140.MPF", "L140.SPF"]) == tmp_path / "l140.spf"
    assert file_beside(main, ["L141.SPF"]) is None
    assert file_beside("part.mpf", ["L140.SPF"]) is None  # a text, no file
