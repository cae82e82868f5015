"""Parts and their days."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.files.learned.track_questions import read_parts
from vcmm.learn.tracking.doubtful import DatedPart


def test_parts_of_a_spreadsheet(tmp_path):
    path = tmp_path / "parts.csv"
    path.write_text("# week 33\ndate;part\n2026-08-19;17\n2026-08-20;18\n", encoding="utf-8")
    assert read_parts(path) == (DatedPart("17", "2026-08-19"), DatedPart("18", "2026-08-20"))


@pytest.mark.parametrize(
    ("text", "words"),
    [
        ("part,day\n17,2026-08-19\n", ":1: the column date is missing; expected the columns part,date"),
        ("part,date\n17,2026-08-19\n18,soon\n", ":3: "),
        ("part,date\n,2026-08-19\n", ":2: the part has no name"),
        ("part,date\n", ":1: there are no rows below the header"),
    ],
)
def test_what_is_wrong_is_said_with_its_line(tmp_path, text, words):
    path = tmp_path / "parts.csv"
    path.write_text(text, encoding="utf-8")
    with pytest.raises(DataError, match=words):
        read_parts(path)
