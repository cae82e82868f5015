"""What README and the first tutorial promise: pictures, numbers, commands, links, files of the package."""

from __future__ import annotations

import json
import re
import shlex
import tomllib
from pathlib import Path
from typing import Any

import pytest

from tests.house.test_docs import ROOT, blocks
from tools.readme_pictures import FOLDER, PICTURES, numbers_in
from vcmm.face.cli import run

README = (ROOT / "README.md").read_text(encoding="utf-8")
FIRST = ROOT / "docs" / "first_uncertainty.md"
PROJECT = tomllib.loads((ROOT / "pyproject.toml").read_text(encoding="utf-8"))["project"]
LONG = {"machined", "diagnosed"}  # a minute of processor each: make test-all


def compare(found: Any, shown: Any, where: str) -> None:
    """The same keys, words, and numbers but for rounding of another processor."""
    if isinstance(found, dict):
        assert found.keys() == shown.keys(), where
        for key, value in found.items():
            compare(value, shown[key], f"{where}.{key}")
    elif isinstance(found, list):
        for i, pair in enumerate(zip(found, shown, strict=True)):
            compare(*pair, f"{where}[{i}]")
    elif isinstance(found, float):
        assert found == pytest.approx(shown, rel=1e-6, abs=1e-9), where
    else:
        assert found == shown, where


@pytest.mark.parametrize(
    "name", [pytest.param(n, marks=[pytest.mark.thorough] if n in LONG else []) for n in PICTURES]
)
def test_a_picture_shows_the_result_of_today(name: str):
    """Run python tools/readme_pictures.py NAME where a result has moved, and say so in CHANGELOG."""
    found = json.loads(json.dumps(PICTURES[name]()[1]))
    compare(found, numbers_in(FOLDER / f"{name}.png"), name)


def test_every_picture_is_drawn_by_the_tool():
    shown = re.findall(r"!\[[^\]]+\]\(docs/images/(\w+)\.png\)", README)
    assert shown == list(PICTURES)


def test_readme_counts_as_the_judge_has_counted():
    """The rows of README are those of docs/referee.md: held with its bounds."""
    judge = (ROOT / "docs" / "referee.md").read_text(encoding="utf-8")
    rows = [
        [c.strip() for c in line.split("|")[1:-1]]
        for line in judge.splitlines()
        if line.startswith("| evaluate")
    ]
    held = {tuple(row[1:5]): (row[7], row[8]) for row in rows}
    for cell in (
        ("bore48", "size", "bow", "exact"),
        ("plane100", "flatness", "cusps", "exact"),
        ("circle36", "roundness", "scratch", "exact"),
        ("circle36", "size", "waves", "ar"),
    ):
        share, bounds = held[cell]
        assert f"{share} ({bounds})" in README, cell


@pytest.mark.thorough
def test_the_first_tutorial_runs(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str]
):
    """As somebody new would: the commands of the page in their order, the limits written as it says; U and interval are those it shows."""
    monkeypatch.chdir(tmp_path)
    said: dict[str, Any] = {}
    for block in blocks(FIRST):
        if block.note:
            (tmp_path / block.note).write_text(block.text, encoding="utf-8")
        elif block.language == "toml":
            _write_limits(tmp_path / "certificate.toml", tomllib.loads(block.text)["machine"]["certificate"])
        elif block.language == "text":
            words = shlex.split(block.text)[1:]
            more = ["--json"] if words[0] in ("uncertainty", "evaluate") else []
            capsys.readouterr()
            assert run([*words, *more]) == 0, capsys.readouterr().err
            said[words[0]] = capsys.readouterr().out
    page = FIRST.read_text(encoding="utf-8")
    for c in json.loads(said["uncertainty"])["characteristics"]:
        owner = max(c["budget"], key=lambda line: line["share"])
        row = next(line for line in page.splitlines() if line.startswith(f"| {c['name']} |"))
        assert f"{1e3 * c['U_mm']:.2f} µm | {c['decision']} |" in row
        assert f"({100 * owner['share']:.0f} %" in row
    bore = json.loads(said["evaluate"])["characteristics"][0]["interval_mm"]
    low, high = (1e3 * (end - 30.0) for end in bore)
    assert f"{low:.2f} to {high:.2f} µm above its nominal diameter" in page
    assert (tmp_path / "result" / "report.html").is_file()


def _write_limits(file: Path, limits: dict[str, str]) -> None:
    """Each limit on its own line of the file, where it stands already."""
    text = file.read_text(encoding="utf-8")
    for key, value in limits.items():
        text, times = re.subn(rf'^{key} = "[^"]*"', f'{key} = "{value}"', text, flags=re.MULTILINE)
        assert times == 1, key
    file.write_text(text, encoding="utf-8")


def test_packages_are_those_that_readme_names():
    base = {re.split(r"[><=]", name)[0] for name in PROJECT["dependencies"]}
    extras = PROJECT["optional-dependencies"]
    assert not base & {"pyvista", "plotly", "pandas"}
    assert {"view", "frames", "step", "parquet", "cluster", "notebook"} <= set(extras)
    for extra in re.findall(r"vcmm\[(\w+)\]", README):
        assert extra in extras
    conda = (ROOT / "conda" / "meta.yaml").read_text(encoding="utf-8")
    for one in PROJECT["dependencies"]:
        name, least = one.split(">=")
        assert re.search(rf"- {name}(-base)? >={re.escape(least)}$", conda, re.MULTILINE), one


def test_one_version_everywhere():
    import vcmm

    version = vcmm.__version__
    assert PROJECT["version"] == version
    assert f"version: {version}" in (ROOT / "CITATION.cff").read_text(encoding="utf-8")
    assert f'version = "{version}"' in (ROOT / "conda" / "meta.yaml").read_text(encoding="utf-8")
    assert f"## {version}" in (ROOT / "CHANGELOG.md").read_text(encoding="utf-8")


def test_what_was_promised_of_the_engine_is_named():
    assert "t-distributions" in README
    assert "Monte Carlo engine" in README


def test_the_paper_cites_what_its_list_holds():
    paper = (ROOT / "paper" / "paper.md").read_text(encoding="utf-8")
    listed = set(re.findall(r"@\w+\{([\w-]+),", (ROOT / "paper" / "paper.bib").read_text(encoding="utf-8")))
    assert set(re.findall(r"@([a-z]+[\w-]*\d[\w-]*)", paper)) == listed
    for heading in ("# Summary", "# Statement of need", "# References"):
        assert f"\n{heading}\n" in paper
