"""Words that people read: what was replaced by a better word does not come back, in messages, pages and documentation."""

from __future__ import annotations

import ast
import re
from pathlib import Path

import pytest

ROOT = Path(__file__).resolve().parents[2]
OLD = {  # what it was, and the word now
    r"Measured virtually: how well": "Virtual measurement report",
    r"Who owns U\b": "Main uncertainty contributors",
    r"[Cc]ollapsed Monte Carlo": "Monte Carlo (linear model)",
    r"coverage not shown": "coverage not demonstrated",
    r"nothing of what is indicated": "no noise correction was applied",
    r"of what is indicated (is|are) taken off": "indicated value corrected by",
    r"\bconforms with \d": "probability of conformity",
    r"On rows never fitted": "Cross-validation",
    r"[Ww]ith them \d": "probability of either",
    r"explained by physics that the machine file lacks": "Effects missing from the machine model",
    r"\ban oracle's": "theoretical best",
    r"taken as perfectly qualified": "assumed perfectly qualified",
    r"a JSON object is due": "expected a JSON object",
    r"the plan leaves the machine": "some points are out of travel",
    r"what inputs do only together": "interaction",
}
SHOWN = re.compile(
    r"\bdrawn per\b|\btiers?\b"
)  # "varies per", "method": words of code and of physics elsewhere
PAGES = [ROOT / "README.md", *sorted((ROOT / "docs").glob("*.md"))]


def texts(file: Path) -> list[str]:
    """Texts of a module that somebody may read: every string but docstrings and keys."""
    tree = ast.parse(file.read_text(encoding="utf-8"))
    docs = {
        id(n.body[0].value)
        for n in ast.walk(tree)
        if isinstance(n, ast.Module | ast.ClassDef | ast.FunctionDef) and n.body and isinstance(n.body[0], ast.Expr)
    }  # fmt: skip
    return [
        n.value
        for n in ast.walk(tree)
        if isinstance(n, ast.Constant) and isinstance(n.value, str) and id(n) not in docs
    ]


def every_text() -> dict[str, str]:
    """What people read, by file: pages, texts of modules, scripts of pages, scenarios, lessons."""
    out = {str(p.relative_to(ROOT)): p.read_text(encoding="utf-8") for p in PAGES}
    for folder in ("vcmm", "scenarios"):
        for file in (ROOT / folder).rglob("*.py"):
            out[str(file.relative_to(ROOT))] = "\n".join(texts(file))
    for pattern in ("vcmm/**/*.js", "scenarios/*.toml", "notebooks/*.py"):
        for file in ROOT.glob(pattern):
            out[str(file.relative_to(ROOT))] = file.read_text(encoding="utf-8")
    return out


@pytest.fixture(scope="module")
def read() -> dict[str, str]:
    return every_text()


@pytest.mark.parametrize("old", OLD)
def test_an_old_phrase_is_gone(read: dict[str, str], old: str) -> None:
    assert [name for name, text in read.items() if re.search(old, text)] == [], f"say: {OLD[old]}"


def test_no_tier_and_no_drawn_per_in_what_commands_say(read: dict[str, str]) -> None:
    """Keys of documents keep "tier"; a sentence has "method" and "varies per"."""
    found = [
        (name, line)
        for name, text in read.items()
        if name.startswith(("vcmm/show", "vcmm/face"))
        for line in text.splitlines()
        if SHOWN.search(line) and line.strip() != "tier"
    ]
    assert found == []


def test_the_workbench_says_connecting_and_computing() -> None:
    script = (ROOT / "vcmm/face/workbench/workbench.js").read_text(encoding="utf-8")
    assert "computing" in script
    assert not re.search(r'"(asking|evaluating)', script)


def test_a_column_of_a_budget_says_varies_per() -> None:
    from vcmm.show.tables.uncertainty import BUDGET

    heads = {column.page_head or column.head for column in BUDGET}
    assert "varies per" in heads
    assert "redraw" not in heads


def test_the_jobs_of_the_front_page_are_lines_of_twelve_words() -> None:
    """README's table of jobs: a command that there is, and one line of at most twelve words."""
    from vcmm.face.cli import run

    text = (ROOT / "README.md").read_text(encoding="utf-8")
    jobs = re.findall(r"^\| `vcmm [^|]*\| ([^|]+) \|$", text, re.MULTILINE)
    assert len(jobs) >= 15
    for verb in re.findall(r"^\| `vcmm (\w+)` \|", text, re.MULTILINE):
        assert run([verb, "--help"]) == 0
    assert [j for j in jobs if len(j.split()) > 12] == []


def test_the_glossary_has_the_words_of_the_standards() -> None:
    """VIM, GUM, ISO 230, ISO 10360, and what PC-DMIS and CALYPSO call it."""
    text = (ROOT / "docs" / "glossary.md").read_text(encoding="utf-8")
    for word in (
        "VIM",
        "GUM",
        "ISO 230",
        "ISO 10360",
        "PC-DMIS",
        "CALYPSO",
        "measurand",
        "coverage interval",
    ):
        assert word in text
