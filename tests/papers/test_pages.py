"""The tables of the documentation are those that the commands print, and the reports hold what they must say."""

from __future__ import annotations

import importlib
from pathlib import Path

import pytest

import vcmm
from vcmm.cli.twins import MODULES
from vcmm.library import path
from vcmm.pages.tables import Shown, html, text
from vcmm.papers.abbe_milling import page as abbe_page
from vcmm.papers.abbe_milling import twin as abbe
from vcmm.report import escape

DOCS = Path(__file__).resolve().parent.parent.parent / "docs"


@pytest.mark.parametrize("name", ["test_piece", "marin2004"])
def test_documentation_shows_what_the_command_prints(name):
    twin, page = (importlib.import_module(module) for module in MODULES[name])
    scenario = vcmm.load_cut(path(name))
    result = twin.run(scenario)
    written = (DOCS / f"{name}.md").read_text(encoding="utf-8")
    for shown in page.tables(result):
        assert text(shown) in written, shown.title
        assert shown.caption in written
    report = page.twin_page(scenario, result)
    assert all(escape(shown.title) in report for shown in page.tables(result))


def test_documentation_of_the_slots():
    """The slots belong to the scenario's machine, so they do not depend on the number of draws."""
    result = abbe.run(vcmm.load_cut(path("abbe_milling")), draws=2)
    written = (DOCS / "abbe_milling.md").read_text(encoding="utf-8")
    _, slots, _ = abbe_page.tables(result)
    assert text(slots) in written
    assert "smaller prediction" in written


def test_a_table_in_words_and_in_html():
    shown = Shown("Title", ("what", "um"), (("a", "1.5"), ("longer", "-10")), "Said.")
    assert text(shown) == "what     um\na       1.5\nlonger  -10"
    assert "Title" in html(shown)[0]
    assert 'class="num"' in html(shown)[1]
