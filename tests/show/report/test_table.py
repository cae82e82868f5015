"""Tables in HTML."""

from __future__ import annotations

import xml.etree.ElementTree as ET

import pytest

from tests.show.report.drawn import NAN
from vcmm.core.errors import DataError
from vcmm.show.report import blocks as report


def test_table_has_scopes_and_dashes() -> None:
    html = report.table(
        ["name", "value"],
        [["a", NAN], ["b", 0.12345], ["c", report.Cell("bad & ugly", "bad")], ["d", report.Raw("<svg/>")]],
        caption="T",
        numeric=[1],
        emphasise=[1],
        foot=[["sum", None]],
    )
    tree = ET.fromstring(html)
    assert [th.get("scope") for th in tree.iter("th")] == ["col"] * 2 + ["row"] * 5
    missing = [s for s in tree.iter("span") if s.get("title") == "not available"]
    assert [s.text for s in missing] == ["–", "–"]
    assert "0.1235" in html  # a bare float: four significant digits
    assert '<span class="badge bad">bad &amp; ugly</span>' in html
    assert "<svg/>" in html
    assert html.count('class="strong"') == 1


def test_table_refuses_ragged_rows() -> None:
    with pytest.raises(DataError, match="Table row 2 has 1 cells but the table has 2 columns"):
        report.table(["a", "b"], [["x", 1], ["y"]])
