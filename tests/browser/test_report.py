"""Reports in a browser without network: drawn, readable, right, turned by keys, printed, accessible."""

from __future__ import annotations

import io
import json
import math
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.browser.conftest import JOBS, Watched

pytestmark = pytest.mark.thorough
SHARED = ("uncertainty", "cut")  # pages with scenes
REPORT = {"field": "field.html"}

PLACES = """live => {
  const scene = live._fullLayout.scene._scene, box = live.querySelector("canvas").getBoundingClientRect();
  const {model, view, projection} = scene.glplot.cameraParams, scale = scene.dataScale;
  const times = (m, v) => [0, 1, 2, 3].map(i => m[i] * v[0] + m[4 + i] * v[1] + m[8 + i] * v[2] + m[12 + i] * v[3]);
  const out = [];
  live.data.forEach((trace, curve) => Array.isArray(trace.hovertext) && trace.type === "scatter3d" && trace.hovertext.forEach((text, i) => {
    const at = times(projection, times(view, times(model, [trace.x[i] * scale[0], trace.y[i] * scale[1], trace.z[i] * scale[2], 1])));
    if (text) out.push({curve, i, text, x: box.x + (1 + at[0] / at[3]) / 2 * box.width, y: box.y + (1 - at[1] / at[3]) / 2 * box.height});
  }));
  return out;
}"""


def address(reports: Path, name: str) -> str:
    return (reports / name / REPORT.get(name, "report.html")).as_uri()


def pixels(shown: bytes) -> np.ndarray:
    from PIL import Image

    return np.asarray(Image.open(io.BytesIO(shown)).convert("RGB")).astype(int)


@pytest.mark.parametrize("name", JOBS)
def test_a_page_needs_nothing_from_outside(unplugged: Any, reports: Path, name: str) -> None:
    """It asks for itself only, and complains of nothing, scrolled from its first to its last line."""
    with Watched(unplugged) as seen:
        seen.page.goto(address(reports, name))
        for number in range(seen.page.locator(".scene").count()):
            seen.scene(number)
        assert [url for url in seen.asked if not url.startswith(("data:", "blob:"))] == [
            address(reports, name)
        ]
        assert seen.complaints == []


def test_values_are_those_of_the_document(unplugged: Any, reports: Path) -> None:
    """Every number of the table of results is the number of uncertainty.json, rounded to the digits shown."""
    wanted = json.loads((reports / "uncertainty/uncertainty.json").read_text())["characteristics"]
    with Watched(unplugged) as seen:
        seen.page.goto(address(reports, "uncertainty"))
        table = seen.page.locator("table").first
        heads = table.locator("thead th").all_inner_texts()
        rows = [
            dict(zip(heads, row.locator("th, td").all_inner_texts()))
            for row in table.locator("tbody tr").all()
        ]
    assert [row["characteristic"] for row in rows] == [c["name"] for c in wanted]
    for row, c in zip(rows, wanted):
        for head, key, scale in (("y", "value_mm", 1.0), ("U", "U_mm", 1e3), ("nominal", "nominal_mm", 1.0)):
            digits = len(row[head].partition(".")[2])
            assert float(row[head]) == pytest.approx(c[key] * scale, abs=0.5001 * 10.0**-digits)
        assert row["decision"] == c["decision"]


@pytest.mark.parametrize("name", SHARED)
def test_scenes_are_not_blank_and_keys_turn_them(unplugged: Any, reports: Path, name: str) -> None:
    """A fiftieth of the picture is drawn, in a hundred colours; a key changes it, Home restores it."""
    with Watched(unplugged) as seen:
        seen.page.goto(address(reports, name))
        for number in range(seen.page.locator(".scene").count()):
            live = seen.scene(number).locator(".live")
            seen.page.locator(".scene").nth(number).focus()
            seen.page.wait_for_timeout(500)
            first = pixels(live.screenshot())
            drawn = (np.abs(first - first[2, 2]).sum(axis=2) > 30).mean()
            assert drawn > 0.02
            assert len(np.unique(first.reshape(-1, 3), axis=0)) > 100
            seen.page.keyboard.press("ArrowLeft")
            seen.page.wait_for_timeout(500)
            assert (np.abs(pixels(live.screenshot()) - first).sum(axis=2) > 30).mean() > 0.01
            seen.page.keyboard.press("Home")
            seen.page.wait_for_timeout(500)
            assert (np.abs(pixels(live.screenshot()) - first).sum(axis=2) > 30).mean() < 0.002


def test_hovering_a_touch_reads_it(unplugged: Any, reports: Path) -> None:
    """The mouse on the place of a touch: the text is that of this touch, or of one whose ellipsoid stands before it."""
    with Watched(unplugged) as seen:
        seen.page.goto(address(reports, "uncertainty"))
        live = seen.scene(1).locator(".live")
        seen.page.wait_for_timeout(500)
        places = live.evaluate(PLACES)
        assert len(places) > 10
        for place in places[:: max(1, len(places) // 6)]:
            near = [p for p in places if math.hypot(p["x"] - place["x"], p["y"] - place["y"]) < 25.0]
            wanted = {re.sub(r"<br>|\s+", "", p["text"]) for p in near}
            assert hovered(seen, live, place, wanted) in wanted


def hovered(seen: Watched, live: Any, place: dict[str, float], wanted: set[str]) -> str:
    """What is read at a place, without blanks: one of `wanted`, or the last thing read within 100 tries (software rendering is slow)."""
    said = ""
    for _ in range(100):
        seen.page.mouse.move(place["x"] - 3, place["y"] - 3)
        seen.page.mouse.move(place["x"], place["y"])
        seen.page.wait_for_timeout(200)
        labels = live.locator(".hovertext text").all_text_contents()
        said = re.sub(r"\s+", "", labels[0]) if labels else said
        if said in wanted:
            break
    return said


def test_print_has_a_page_for_every_characteristic_and_three_more(unplugged: Any, reports: Path) -> None:
    wanted = json.loads((reports / "uncertainty/uncertainty.json").read_text())["characteristics"]
    with Watched(unplugged) as seen:
        seen.page.goto(address(reports, "uncertainty"))
        printed = seen.page.pdf(format="A4")
    assert (
        len(re.findall(rb"/Type\s*/Page\b(?!s)", printed)) == len(wanted) + 3
    )  # answers with the part, notes with what was assumed, the machine


@pytest.mark.parametrize("look", ["light", "dark"])
@pytest.mark.parametrize("name", JOBS)
def test_no_barrier_for_readers(unplugged: Any, reports: Path, name: str, look: str) -> None:
    """axe-core finds nothing serious."""
    axe = pytest.importorskip(
        "axe_playwright_python.sync_playwright",
        reason="axe-playwright-python is missing: pip install vcmm[browser]",
    )
    with Watched(unplugged, color_scheme=look) as seen:
        seen.page.goto(address(reports, name))
        if seen.page.locator(".scene").count():
            seen.scene(0)
        found = axe.Axe().run(seen.page).response["violations"]
    serious = [
        (v["id"], [n["target"] for n in v["nodes"]][:5])
        for v in found
        if v["impact"] in ("serious", "critical")
    ]
    assert serious == []


def test_tables_do_not_scroll_sideways(unplugged: Any, reports: Path) -> None:
    with Watched(unplugged) as seen:
        seen.page.goto(address(reports, "uncertainty"))
        wide = seen.page.locator(".scroll").evaluate_all("all => all.map(e => e.scrollWidth - e.clientWidth)")
    assert max(wide) <= 0
