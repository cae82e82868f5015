"""Every button of the workbench in a browser: save, sweep, exchange, files, folder, measure, place, cancel; previews and scenes while a knob moves."""

from __future__ import annotations

import tomllib
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.browser.conftest import Watched
from tests.browser.test_workbench import served, settled, turn
from tests.plate import PLATE
from vcmm.face.workbench.server import WorkbenchServer
from vcmm.files.own.library import example

pytestmark = pytest.mark.thorough
TOUCHES = "() => document.querySelector('.live').data?.findLast(t => t.name === 'touches')?.x[0]"


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WorkbenchServer]:
    from vcmm.face.workbench.bench import Bench
    from vcmm.files.own.scenario import load_scenario

    folder = tmp_path_factory.mktemp("features")
    for made in served(folder / "plate.toml", PLATE):
        made.bench = Bench(load_scenario(folder / "plate.toml", knobs=False), folder / "plate.toml")
        yield made


@pytest.fixture
def seen(plugged: Any, server: WorkbenchServer) -> Iterator[Watched]:
    with Watched(plugged) as watched:
        watched.page.goto(server.address)
        settled(watched)
        yield watched
        assert watched.complaints == []


def said(seen: Watched, words: str, at: str = "status") -> None:
    seen.page.wait_for_function(
        "([at, words]) => document.getElementById(at).textContent.includes(words)",
        arg=[at, words],
        timeout=120_000,
    )


def test_the_part_moves_before_the_evaluation_and_figures_stay_within_the_stated_error(seen: Watched) -> None:
    """The preview has the scene; its U is the settled one within the error of the trials (1000 here: 4.5 % of U, two standard deviations)."""
    seen.page.wait_for_function(f"() => ({TOUCHES})() !== undefined", timeout=60_000)
    start = seen.page.evaluate(TOUCHES)
    at = float(seen.page.locator('input[name="x"]').input_value())
    turn(seen, "x", at + 20.0)
    seen.page.wait_for_function(f"was => Math.abs(({TOUCHES})() - was) > 15", arg=start, timeout=60_000)
    shown = [row.locator("td").all_inner_texts() for row in seen.page.locator("#rows tr").all()]
    after = settled(seen, x=at + 20.0)
    for name, _, u, *_ in shown:
        assert float(u.strip("≈ ").split()[0]) == pytest.approx(float(after[name].split()[0]), rel=0.09)


def test_the_picture_of_iso_14253_and_the_pill_stand_there(seen: Watched, server: WorkbenchServer) -> None:
    pills = seen.page.locator("#rows .badge")
    assert (
        seen.page.locator("#pictures svg").count() == pills.count() == 2
    )  # the distance of this plate has no limits
    decisions = [c["decision"] for c in server.bench.settle({})["characteristics"]]
    assert pills.all_inner_texts() == [d for d in decisions if d]


def test_what_is_saved_is_the_file_with_the_knobs(seen: Watched) -> None:
    turn(seen, "spread", 2.0)
    settled(seen, spread=2.0)
    with seen.page.expect_download() as waiting:
        seen.page.click("#save")
    made = tomllib.loads(Path(waiting.value.path()).read_text())
    assert waiting.value.suggested_filename == "plate-turned.toml"
    assert made["knobs"] == {"spread": 2.0}


def test_a_sweep_draws_u_against_the_knob(seen: Watched) -> None:
    seen.page.select_option("#along", "spread")
    seen.page.click("#sweep")
    seen.page.wait_for_selector(
        "#swept svg", timeout=120_000
    )  # the words of the status go when the evaluation comes back
    assert "bore diameter" in (seen.page.locator("#swept").text_content() or "")


def test_a_and_b_are_exchanged(seen: Watched) -> None:
    seen.page.click("#pin")
    turn(seen, "spread", 3.0)
    settled(seen, spread=3.0)
    seen.page.click("#swap")
    settled(seen, spread=1.0)
    assert seen.page.locator("#rows td.pinned").first.inner_text().startswith("U ")


def test_measure_and_place_answer(seen: Watched) -> None:
    seen.page.click("#measure")
    said(seen, "bore diameter", "found")
    seen.page.click("#place")
    said(seen, "A short search", "found")
    assert seen.page.locator("#report").is_visible()


def test_files_are_chosen_by_a_button_and_a_folder_whole(seen: Watched, tmp_path: Path) -> None:
    (tmp_path / "values.csv").write_text("characteristic,value_mm\nbore diameter,30.004\n")
    seen.page.set_input_files("#chosen", str(tmp_path / "values.csv"))
    said(seen, "evaluate: done", "said")
    head = example("ballbar")
    folder = tmp_path / "log"
    (folder / "ballbar").mkdir(parents=True)
    (folder / "ballbar.toml").write_bytes(head.read_bytes())
    for name in ("circles.csv", "machine.toml"):
        (folder / "ballbar" / name).write_bytes((head.parent / "ballbar" / name).read_bytes())
    seen.page.set_input_files("#whole", str(folder))
    said(seen, "explained", "said")
    assert "backlash Y" in seen.page.locator("#found").inner_text()


def test_long_work_shows_how_far_it_is_and_can_be_ended(seen: Watched) -> None:
    seen.page.click("#place")
    seen.page.wait_for_selector("#progress:visible", timeout=20_000)
    seen.page.click("#cancel")
    seen.page.wait_for_selector("#progress", state="hidden", timeout=60_000)
    said(seen, "ended")
