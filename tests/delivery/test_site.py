"""The documentation as web pages: built without a warning, every page there, every local link answered."""

from __future__ import annotations

import re
import subprocess
import sys
from pathlib import Path
from urllib.parse import unquote

import pytest

ROOT = Path(__file__).resolve().parents[2]
pytestmark = pytest.mark.thorough


@pytest.fixture(scope="module")
def site(tmp_path_factory: pytest.TempPathFactory) -> Path:
    pytest.importorskip("sphinx", reason="sphinx is missing: pip install vcmm[docs]")
    out = tmp_path_factory.mktemp("site")
    words = [
        sys.executable,
        "-m",
        "sphinx",
        "-W",
        "--keep-going",
        "-q",
        "-d",
        str(out / "trees"),
        "-b",
        "html",
        "docs",
        str(out / "html"),
    ]
    done = subprocess.run(words, cwd=ROOT, capture_output=True, text=True)
    assert done.returncode == 0, done.stderr
    return out / "html"


def test_every_page_is_there(site: Path) -> None:
    sources = {p.stem for p in (ROOT / "docs").glob("*.md")}
    assert sources <= {p.stem for p in site.glob("*.html")}


def test_local_links_are_answered(site: Path) -> None:
    missing = []
    for page in site.glob("*.html"):
        for link in re.findall(
            r'<(?:a|img)[^>]+(?:href|src)="([^"#:?]+)[#"?]', page.read_text(encoding="utf-8")
        ):
            if not (page.parent / unquote(link)).exists():
                missing.append(f"{page.name}: {link}")
    assert missing == []


def test_the_lessons_stand_there_as_they_were_run(site: Path) -> None:
    """Each with a picture and with what it printed: U of the ring gauge is that of its file (0.54 um)."""
    pages = {p.stem: p.read_text(encoding="utf-8") for p in (site / "lesson").glob("*.html")}
    assert sorted(pages) == sorted(p.stem for p in (ROOT / "notebooks").glob("[0-9][0-9]_*.py"))
    assert [name for name, page in pages.items() if "<img" not in page or "Traceback" in page] == []
    assert "U = 0.54 um" in pages["01_first_uncertainty"]
