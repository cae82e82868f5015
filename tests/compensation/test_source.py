"""The text of a program byte for byte, its edits, and errors that carry their place."""

from __future__ import annotations

import pytest

from vcmm.compensation.source import (
    Edit,
    apply_edits,
    at_line,
    at_origin,
    code_of,
    read_source,
    semicolon_code,
    separator,
    source_text,
)
from vcmm.core.errors import DataError, ModelLimit


def test_line_ends_and_encoding_stay(tmp_path) -> None:
    raw = b"G1 X1.\r\n(M\xfcller)\nG1 X2.\r"
    (tmp_path / "old.nc").write_bytes(raw)
    source = read_source(tmp_path / "old.nc")
    assert [end for _, end in source.lines] == ["\r\n", "\n", "\r"]
    assert source.encoding == "latin-1"
    assert source.encode(source.text) == raw


def test_edits_keep_their_columns() -> None:
    line = "G1 X10. Y20. F100"
    edits = [Edit(9, 13, "Y20.5"), Edit(5, 8, "9.998"), Edit(13, 13, " Z1.")]
    assert apply_edits(line, edits) == "G1 X9.998 Y20.5 Z1. F100"


def test_comments_are_blanked_in_place() -> None:
    assert code_of("G1 (X9.) X1. ; end") == "G1       X1.      "
    assert semicolon_code('MSG("a;b") X1 ; X2') == 'MSG("a;b") X1     '


def test_words_apart_or_close() -> None:
    assert separator(source_text("G1X1.Y2.\nX2.Y3. F5\n", "a")) == ""
    assert separator(source_text("G1 X1. Y2.\n", "a")) == " "


def test_an_error_carries_its_place_as_data() -> None:
    error = at_line(ModelLimit, "part.nc", 7, "too far", 3)
    assert (str(error), error.line, error.column) == ("part.nc:7:3: too far", 7, 3)


def test_a_line_of_the_written_out_program_becomes_that_of_the_file() -> None:
    """Line 3 of the written-out program comes from line 12; other lines in the sentence stay as they are."""
    error = at_line(DataError, "part.nc", 3, "see part.nc:2")
    moved = at_origin(error, "part.nc", (10, 11, 12))
    assert (type(moved), str(moved), moved.line) == (DataError, "part.nc:12: see part.nc:2", 12)
    assert at_origin(error, "other.nc", (10, 11, 12)) is error
    plain = ModelLimit("part.nc:3: without data")
    assert at_origin(plain, "part.nc", (10, 11, 12)) is plain


@pytest.mark.parametrize("line", [0, 4])
def test_lines_of_no_file_stay(line) -> None:
    error = at_line(ModelLimit, "part.nc", line, "x")
    assert at_origin(error, "part.nc", (10, 11, 12)) is error
