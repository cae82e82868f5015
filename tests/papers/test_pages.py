"""The tables of the documentation are those that the commands print, and the reports hold what they must say."""

from __future__ import annotations

from pathlib import Path

import pytest

import vcmm
from vcmm.cli.twins import TWINS
from vcmm.library import path
from vcmm.papers.abbe_milling import page as abbe_page
from vcmm.papers.abbe_milling import twin as abbe
from vcmm.report import escape
from vcmm.tables.table import text

DOCS = Path(__file__).resolve().parent.parent.parent / "docs"


@pytest.mark.parametrize("name", ["test_piece", "marin2004"])
def test_documentation_shows_what_the_command_prints(name):
    twin, page = TWINS[name]()
    scenario = vcmm.load_cut(path(name))
    result = twin.run(scenario)
    written = (DOCS / f"{name}.md").read_text(encoding="utf-8")
    for table in page.tables(result):
        assert text(table) in written, table.title
        assert table.caption in written
    report = page.twin_page(scenario, result)
    assert all(escape(table.title) in report for table in page.tables(result))


def test_documentation_of_the_slots():
    """The slots belong to the scenario's machine, so they do not depend on the number of draws."""
    result = abbe.run(vcmm.load_cut(path("abbe_milling")), draws=2)
    written = (DOCS / "abbe_milling.md").read_text(encoding="utf-8")
    _, slots, _ = abbe_page.tables(result)
    assert text(slots) in written
    assert "smaller prediction" in written
