"""The first screen of every report at 1280 x 800 and at 390 x 844: value, U, decision and main contributor stand on it.

Pictures of these screens are written to the folder that VCMM_SCREENS names, where it is set.
"""

from __future__ import annotations

import os
from pathlib import Path
from typing import Any

import pytest

from tests.browser.conftest import Watched
from tests.learn.tracking.small_folder import write_year
from vcmm.face.cli import run

pytestmark = pytest.mark.thorough
SCREENS = ((1280, 800), (390, 844))
VALUES = "characteristic,value_mm\nbore diameter,30.004\nbore to front,39.9985\nbore square to top,0.003\n"
# the parts of the first line that a job has: an NC program has no U and no decision
PARTS = {
    "uncertainty": ("name", "value", "verdict", "why"),
    "evaluate": ("name", "value", "verdict", "why"),
    "sheet": ("name", "value", "verdict", "why"),
    "cut": ("name", "value", "verdict", "why"),
    "place": ("name", "value", "verdict", "why"),
    "diagnosis": ("name", "value", "verdict", "why"),
    "calibration": ("name", "value", "verdict", "why"),
    "compensation": ("name", "value", "verdict", "why"),
    "field": ("name", "value", "why"),
    "nc": ("name", "value", "verdict"),
    "compare": ("name", "value"),
    "demo": ("name", "value", "verdict", "why"),
    "track": ("name", "value", "verdict"),
    "thermal": ("name", "value"),
    "routes": ("name", "value", "verdict"),
    "test": ("name", "value"),
}
STATED = {  # words that a first line holds where it states an uncertainty and a decision
    "uncertainty": ("±", "k = ", "conform", "mostly"), "evaluate": ("±", "k = ", "conform", "mostly"), "sheet": ("±", "conform", "mostly"),
    "cut": ("p = 95", "conform", "mostly"), "place": ("gain", "±", "the part"), "diagnosis": ("±", "confirm by"), "calibration": ("A = ", "±", "largest"),
    "compensation": ("met", "at most"), "demo": ("±", "conforms", "mostly"), "nc": ("Time",), "compare": ("rms",), "field": ("µm",),
    "track": ("recordings",), "thermal": ("µm",), "routes": ("µm",), "test": ("µm",),
}  # fmt: skip


@pytest.fixture(scope="module")
def pages(reports: Path, tmp_path_factory: pytest.TempPathFactory) -> dict[str, Path]:
    """Report of every job."""
    folder = tmp_path_factory.mktemp("answers")
    for name in ("plate", "pallet_block", "traced_cmm", "turned_shaft", "ballbar"):
        assert run(["new", name, "--out", str(folder)]) == 0
    (folder / "values.csv").write_text(VALUES)
    plate = str(folder / "plate.toml")
    jobs = (
        ["evaluate", plate, "--values", str(folder / "values.csv"), "--trials", "1000", "--out", str(folder / "evaluate")],
        ["place", plate, "--evaluations", "60", "--scan", "40", "--trials", "1000", "--out", str(folder / "place")],
        ["calibrate", str(folder / "traced_cmm.toml"), "--machine", str(folder / "traced_cmm/machine.toml"), "--report", str(folder / "calibration.html")],
        ["compensate", str(folder / "pallet_block.toml"), "--out", str(folder / "new.nc"), "--plot"],
        ["nc", str(folder / "turned_shaft/part.nc"), "--setup", str(folder / "turned_shaft/setup.toml"), "--plot", "--out", str(folder)],
        ["compare", str(folder / "ballbar.toml"), "--out", str(folder / "compare")],
        ["demo", "--out", str(folder / "demo")],
        ["track", str(write_year(folder / "year", 4, lambda week: 2.0)), str(folder / "year/checks"), "--out", str(folder / "track"), "--no-explain"],
        ["calibrate", "thermal", str(folder / "traced_cmm/warm_up.toml"), "--machine", str(folder / "traced_cmm/machine.toml"), "--report", str(folder / "thermal.html")],
        ["routes", plate, "--trials", "1000", "--out", str(folder / "routes")],
        ["test", str(folder / "ballbar.toml"), "--iso", "230-4", "--report", str(folder / "test.html")],
    )  # fmt: skip
    for words in jobs:
        assert run(words) in (0, 1), words
    return {
        "uncertainty": reports / "uncertainty/report.html", "cut": reports / "cut/report.html", "diagnosis": reports / "diagnosis/report.html",
        "field": reports / "field/field.html", "evaluate": folder / "evaluate/report.html", "sheet": folder / "evaluate/sheet.html",
        "place": folder / "place/report.html", "calibration": folder / "calibration.html", "compensation": folder / "new.html",
        "nc": folder / "part.html", "compare": next((folder / "compare").glob("*.html")), "demo": folder / "demo/report.html",
        "track": folder / "track/report.html", "thermal": folder / "thermal.html", "routes": folder / "routes/report.html",
        "test": folder / "test.html",
    }  # fmt: skip


@pytest.mark.parametrize("size", SCREENS, ids=["1280", "390"])
@pytest.mark.parametrize("name", PARTS)
def test_the_answer_is_on_the_first_screen(
    unplugged: Any, pages: dict[str, Path], name: str, size: tuple[int, int]
) -> None:
    width, height = size
    with Watched(unplugged) as seen:
        seen.page.set_viewport_size({"width": width, "height": height})
        seen.page.goto(pages[name].as_uri())
        if folder := os.environ.get("VCMM_SCREENS"):
            seen.page.screenshot(path=Path(folder) / f"{name}-{width}.png")
        first = seen.page.locator(".answers li").first
        for part in PARTS[name]:
            box = first.locator(f".{part}").bounding_box()
            assert box is not None
            assert box["width"] > 0
            assert first.locator(f".{part}").inner_text().strip()
            assert 0 <= box["x"] <= width - box["width"], f"{part} lies beside the screen"
            assert box["y"] + box["height"] <= height, f"{part} lies below the screen"
        words = first.inner_text()
        assert [w for w in STATED[name] if w not in words] == []
        # the page itself does not scroll sideways
        assert seen.page.evaluate("document.documentElement.scrollWidth") <= width


def test_links_lead_to_sections(unplugged: Any, pages: dict[str, Path]) -> None:
    """Every link of the first lines and of the contents has its place on the page."""
    for path in pages.values():
        with Watched(unplugged) as seen:
            seen.page.goto(path.as_uri())
            lost = seen.page.evaluate(
                "[...document.querySelectorAll('.answers a, .contents a')].filter(a => !document.getElementById(a.getAttribute('href').slice(1))).length"
            )
            assert lost == 0
            # a page of one or two sections shows them without a list of contents
            sections = seen.page.locator("main h2, body h2").count()
            assert path.name == "part.html" or sections < 3 or seen.page.locator(".contents a").count() >= 2
