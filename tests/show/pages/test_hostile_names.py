"""Names from files stand in pages as text and never as markup; nothing in a page's script or attributes is theirs."""

from __future__ import annotations

import re
import shutil
import subprocess
from html.parser import HTMLParser
from pathlib import Path

import pytest

from tests.hostile.corpus import ERRORS, MACHINE
from tests.hostile.judge import ask, inside
from tests.plate import PLATE
from tests.shop.machining import shop
from vcmm.files.own.recording import load_recording
from vcmm.files.own.recording_writer import save_recording

EVIL = "<img src=x onerror=document.title='OWNED'>\\\"><script>document.title='OWNED'</script></title>&lt;'=`"


def plate() -> str:
    """The plate with such a name for scenario, machine, features, characteristics and stylus."""
    text = PLATE.replace("[machine]", f'name = "{EVIL}"\n[machine]', 1).replace(
        "bridge CMM", f"{EVIL}machine"
    )
    for name in ("top", "front", "bore"):
        text = text.replace(f'"{name}"', f'"{EVIL}{name}"')
        text = re.sub(rf"(?m)^{name}(?=\s*= {{ type)", lambda m: f'"{EVIL}{m[0]}"', text)
    for name in ("bore diameter", "bore square to top", "bore to front"):
        text = text.replace(f'name = "{name}"', f'name = "{EVIL}{name}"')
    text = text.replace("styli.down", f'styli."{EVIL}down"').replace(
        'stylus = "down"', f'stylus = "{EVIL}down"'
    )
    return text.replace("trials = 20000", "trials = 1000")


def boss() -> str:
    return (
        shop.SCENARIO.replace("boss =", f'"{EVIL}boss" =')
        .replace('"boss"', f'"{EVIL}boss"')
        .replace('"form"', f'"{EVIL}form"')
    )


class Markup(HTMLParser):
    """Counts the markup of a page, and of its texts those that hold the name."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.tags: dict[str, int] = {}
        self.handlers: list[str] = []
        self.named = 0
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags[tag] = self.tags.get(tag, 0) + 1
        self.handlers += [name for name, _ in attrs if name.startswith("on")]

    def handle_data(self, data: str) -> None:
        self.named += "OWNED" in data


def few(text: str) -> str:
    return text.replace("trials = 20000", "trials = 1000")


def lay_out(folder: Path) -> None:
    files = {
        "plate.toml": few(plate()), "plain.toml": few(PLATE),
        "machine.toml": MACHINE.replace("bridge CMM", EVIL), "errors.csv": ERRORS,
        "boss.toml": boss(), "mill.toml": shop.MACHINE.replace('"mill"', f'"{EVIL}mill"') + '[repeatability]\nu = "1 um"\n',
        "setup.toml": shop.SETUP, "part.nc": shop.PROGRAM,
    }  # fmt: skip
    for name, text in files.items():
        (folder / name).write_text(text)


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    folder = tmp_path_factory.mktemp("evil")
    lay_out(folder)
    jobs = {
        "uncertainty": ("plate.toml",), "field": ("machine.toml",), "cut": ("boss.toml",),
    }  # fmt: skip
    with inside(folder):
        for verb, words in jobs.items():
            answer = ask((verb, *words, "--out", verb))
            assert answer.code == 0, answer.err
        assert ask(("uncertainty", "plain.toml", "--out", "plain")).code == 0
    return folder


@pytest.mark.parametrize("page", ["uncertainty/report.html", "field/field.html", "cut/report.html"])
def test_names_are_text(pages, page):
    text = (pages / page).read_text()
    seen = Markup(text)
    assert seen.named >= 2
    assert seen.tags["img"] == text.count('<img class="poster" alt=')  # the stills of our scenes and no other
    assert seen.handlers == []


def test_names_bring_no_script(pages):
    evil, plain = (
        Markup((pages / name / "report.html").read_text()).tags for name in ("uncertainty", "plain")
    )
    assert evil["script"] == plain["script"]


@pytest.mark.thorough
@pytest.mark.skipif(shutil.which("chromium") is None, reason="needs chromium")
def test_a_browser_runs_nothing_of_it(pages):
    page = pages / "uncertainty/report.html"
    words = [
        "chromium",
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--virtual-time-budget=1000",
        "--dump-dom",
    ]
    dom = subprocess.run(
        [*words, f"file://{page}"], capture_output=True, text=True, check=True, timeout=60
    ).stdout
    title = re.search("<title>(.*?)</title>", dom, re.DOTALL)
    assert title is not None
    assert title[1].startswith("Virtual measurement report: &lt;img")


def test_tables_in_files_cannot_run_in_a_spreadsheet(pages, tmp_path):
    text = PLATE.replace('name = "bore diameter"', 'name = "=cmd()"').replace(
        "trials = 20000", "trials = 1000"
    )
    (tmp_path / "plate.toml").write_text(text.replace('name = "bore to front"', 'name = "a, \\"b\\""'))
    with inside(tmp_path):
        assert ask(("uncertainty", "plate.toml", "--out", "u")).code == 0
    rows = (tmp_path / "u/budget.csv").read_text().split("\n")
    assert any(row.startswith("'=cmd(),") for row in rows)
    assert not any(row.startswith("=") for row in rows)
    assert any(row.startswith('"a, ""b""",') for row in rows)


def test_a_recording_keeps_labels_that_look_like_formulas(tmp_path):
    from tests.hostile.corpus import BARE, LOG, TOUCHES, TOUCHES_CSV

    files = {
        "r.toml": TOUCHES,
        "machine.toml": BARE,
        "log.csv": LOG,
        "touches.csv": TOUCHES_CSV.replace(",down,", ",'=down,"),
    }
    for name, content in files.items():
        (tmp_path / name).write_text(content)
    first = load_recording(tmp_path / "r.toml")[0]
    assert set(first.run.labels["stylus"]) == {"=down"}
    save_recording(first, tmp_path / "again.toml")
    assert ",'=down," in (tmp_path / "again.csv").read_text()
    again = load_recording(tmp_path / "again.toml")[0]
    assert again.run.labels["stylus"].tolist() == first.run.labels["stylus"].tolist()
