"""Paths of programs in a browser: coloured by error before and after compensation, followed by a slider."""

from __future__ import annotations

import io
import re
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.browser.conftest import Watched
from tests.shop.machining import shop
from vcmm.face.cli import run

pytestmark = pytest.mark.thorough
SCALE = '[[effects]]\neffect = "scale_factor"\naxis = "X"\nk = "100 um/m"\n'
SLIDE = "(e, share) => { e.value = Math.round(share * e.max); e.dispatchEvent(new Event('input', {bubbles: true})); }"


@pytest.fixture(scope="module")
def compensated(tmp_path_factory: pytest.TempPathFactory) -> Path:
    folder = tmp_path_factory.mktemp("path")
    setup = shop.SETUP + "[control]\ncompensation = []\n"
    file = shop.write(folder, machine=SCALE, setup=setup)
    assert run(["compensate", str(file), "--plot", "--out", str(folder / "new.nc")]) == 0
    return folder / "new.html"


def chosen(seen: Watched, program: str, kind: str, share: float = 1.0) -> tuple[np.ndarray, str]:
    """(pixels of the canvas, what is said) with these choices."""
    from PIL import Image

    figure = seen.page.locator("[data-path]")
    figure.locator("select[name=program]").select_option(label=program)
    figure.locator("select[name=colour]").select_option(kind)
    figure.locator("input[type=range]").evaluate(SLIDE, share)
    shown = Image.open(io.BytesIO(figure.locator("canvas").screenshot())).convert("RGB")
    return np.asarray(shown).astype(int), figure.locator("output").inner_text()


def coloured(shown: np.ndarray) -> int:
    """Pixels that are neither paper nor grey."""
    return int((np.ptp(shown, axis=2) > 60).sum())


def test_errors_shrink_where_the_program_is_compensated(unplugged: Any, compensated: Path) -> None:
    """X is 100 um/m too long: the worst of the boss at X -60 mm is 6 um off before, the last digit after; both in one scale of colours."""
    with Watched(unplugged) as seen:
        seen.page.goto(compensated.as_uri())
        said = {}
        for program in ("as programmed", "compensated"):
            places = [chosen(seen, program, "error", share / 40)[1] for share in range(8, 40)]
            said[program] = max(float(m[1]) for t in places if (m := re.search(r"off by ([\d.]+) µm", t)))
        assert said["as programmed"] == pytest.approx(6.0, abs=0.1)
        assert said["compensated"] < 1.0
        before, after = (chosen(seen, program, "error")[0] for program in ("as programmed", "compensated"))
        hues = [len(np.unique(p[np.ptp(p, axis=2) > 60] // 32, axis=0)) for p in (before, after)]
        assert hues[0] > hues[1]  # the compensated path has one band
        assert seen.complaints == []
        assert [url for url in seen.asked if not url.startswith("data:")] == [compensated.as_uri()]


def test_the_slider_and_the_colours(unplugged: Any, compensated: Path) -> None:
    with Watched(unplugged) as seen:
        seen.page.goto(compensated.as_uri())
        half, said = chosen(seen, "as programmed", "feed", 0.4)
        assert "600 mm/min" in said
        assert "line 10: G2 X0 Y60. I0 J-60." in said
        assert 0 < coloured(half) < 0.8 * coloured(chosen(seen, "as programmed", "feed")[0])
        assert seen.page.locator("[data-scale=feed]").is_visible()
        assert not seen.page.locator("[data-scale=error]").is_visible()


def test_the_report_of_a_cut_shows_its_path(unplugged: Any, reports: Path) -> None:
    with Watched(unplugged) as seen:
        seen.page.goto((reports / "cut" / "report.html").as_uri())
        figure = seen.page.locator("[data-path]")
        figure.scroll_into_view_if_needed()
        assert figure.locator("select[name=colour] option").all_inner_texts() == ["error", "feed", "tool"]
        assert "of 243" in figure.locator("output").inner_text()
        program = figure.locator(".listing ol")
        program.locator("li", has_text=re.compile(r"G2 ")).first.click()  # from the program to the path
        said = figure.locator("output").inner_text()
        assert "G2" in said
        assert program.locator("li[aria-current]").inner_text() in said
        program.press("ArrowDown")
        assert figure.locator("output").inner_text() != said
        figure.locator("input[type=search]").fill("G41")
        assert all("G41" in line for line in program.locator("li:visible").all_inner_texts())
        assert float(figure.get_attribute("data-scale")) > 0
        assert seen.complaints == []
