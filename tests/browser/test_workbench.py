"""The workbench in a browser: knobs move U, a dropped recording is diagnosed, other sites get nothing, names stay text."""

from __future__ import annotations

import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import pytest

from tests.browser.conftest import Watched
from tests.plate import PLATE
from tests.show.pages.test_hostile_names import plate
from vcmm.face.workbench.bench import Bench
from vcmm.face.workbench.server import WorkbenchServer
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario

pytestmark = pytest.mark.thorough
SETTLED = "want => document.body.dataset.settled && Object.entries(want).every(([k, v]) => JSON.parse(document.body.dataset.settled)[k] === v)"
DROP = """async ([zone, files]) => {
  const held = new DataTransfer();
  for (const [name, text] of Object.entries(files)) held.items.add(new File([text], name));
  zone.dispatchEvent(new DragEvent("drop", {dataTransfer: held, bubbles: true, cancelable: true}));
}"""


def served(file: Path, text: str) -> Iterator[WorkbenchServer]:
    file.write_text(text.replace("trials = 20000", "trials = 1000"))
    with WorkbenchServer(Bench(load_scenario(file))) as made:
        threading.Thread(target=made.serve_forever, daemon=True).start()
        yield made
        made.shutdown()


@pytest.fixture(scope="module")
def server(tmp_path_factory: pytest.TempPathFactory) -> Iterator[WorkbenchServer]:
    yield from served(tmp_path_factory.mktemp("bench") / "plate.toml", PLATE)


@pytest.fixture
def hostile(tmp_path: Path) -> Iterator[WorkbenchServer]:
    yield from served(tmp_path / "plate.toml", plate())


def settled(seen: Watched, **knobs: float) -> dict[str, str]:
    """U of every characteristic once the whole evaluation with these knobs stands in the page."""
    seen.page.wait_for_function(SETTLED, arg=knobs, timeout=60_000)
    rows = seen.page.locator("#rows tr").all()
    cells = [row.locator("td").all_inner_texts() for row in rows]
    return {name: u for name, _, u, *_ in cells}


def turn(seen: Watched, knob: str, value: float) -> None:
    slider = seen.page.locator(f'input[name="{knob}"]')
    slider.evaluate("(e, v) => { e.value = v; e.dispatchEvent(new Event('input', {bubbles: true})); }", value)


def test_a_knob_moves_u(plugged: Any, server: WorkbenchServer) -> None:
    """U before, a preview on the way, U after: the figures of the evaluation with that knob; no complaint in the console."""
    with Watched(plugged) as seen:
        seen.page.goto(server.address)
        before = settled(seen)
        turn(seen, "spread", 2.9)
        turn(seen, "spread", 3.0)
        seen.page.wait_for_function("() => document.getElementById('rows').className === 'preview'")
        after = settled(seen, spread=3.0)
        assert [url for url in seen.asked if not url.startswith((server.origin, "data:", "blob:"))] == []
        assert seen.complaints == []
    wanted = server.bench.settle({"spread": 3.0})["characteristics"]
    for c in wanted:
        assert float(after[c["name"]].split()[0]) == pytest.approx(1e3 * c["U_mm"], rel=5e-3)
    name = "bore square to top"  # all of it is scatter
    assert float(after[name].split()[0]) == pytest.approx(3.0 * float(before[name].split()[0]), rel=0.1)


def test_a_pose_beyond_the_travels_leaves_no_figures_of_another(
    plugged: Any, server: WorkbenchServer
) -> None:
    with Watched(plugged) as seen:
        seen.page.goto(server.address)
        settled(seen)
        at = float(seen.page.locator('input[name="x"]').input_value())
        turn(seen, "x", float(seen.page.locator('input[name="x"]').get_attribute("max") or 0))
        seen.page.wait_for_function(
            "() => document.getElementById('status').textContent.includes('outside its travel')"
        )
        assert seen.page.locator("#rows tr").count() == 0
        turn(seen, "x", at)
        assert len(settled(seen, x=at)) == 3


def test_two_pages_both_come_to_their_end(plugged: Any, server: WorkbenchServer) -> None:
    """Each page ends its own questions only, and a knob that moves on is no error in the console."""
    with Watched(plugged) as one, Watched(plugged) as two:
        one.page.goto(server.address)
        two.page.goto(server.address)
        for value in (1.5, 2.0, 2.5):
            turn(one, "spread", value)
            one.page.wait_for_timeout(600)
            turn(two, "spread", value + 0.25)
        settled(one, spread=2.5)
        settled(two, spread=2.75)
        assert one.complaints == two.complaints == []


def test_the_scenes_follow_a_knob(plugged: Any, server: WorkbenchServer) -> None:
    with Watched(plugged) as seen:
        seen.page.goto(server.address)
        settled(seen)
        read = "() => document.querySelector('.live').data.findLast(t => t.name === 'touches').x[0]"
        seen.page.wait_for_function("() => document.querySelector('.live').data")
        start = seen.page.evaluate(read)
        at = float(seen.page.locator('input[name="x"]').input_value())
        turn(seen, "x", at + 20.0)
        settled(seen, x=at + 20.0)
        seen.page.wait_for_function(f"was => Math.abs(({read})() - was) > 15", arg=start, timeout=30_000)
        assert seen.page.evaluate(read) - start == pytest.approx(20.0, abs=0.05)


def test_a_dropped_recording_is_diagnosed(plugged: Any, server: WorkbenchServer) -> None:
    """The ball bar of `vcmm new ballbar`, its files dropped side by side."""
    head = example("ballbar")
    files = {name: (head.parent / "ballbar" / name).read_text() for name in ("circles.csv", "machine.toml")}
    files["ballbar.toml"] = head.read_text().replace("ballbar/", "")
    with Watched(plugged) as seen:
        seen.page.goto(server.address)
        settled(seen)
        seen.page.evaluate(DROP, [seen.page.query_selector("#drop"), files])
        seen.page.wait_for_selector("#found p", timeout=120_000)
        assert seen.page.locator("#said").inner_text() == "explained"
        assert "backlash Y" in seen.page.locator("#found").inner_text()


def test_undo_figures_address_pin_and_narrow_screens(plugged: Any, server: WorkbenchServer) -> None:
    """A number typed in is in the address and comes back from it; undo and redo go both ways; A stands beside; 390 px hold it all."""
    with Watched(plugged) as seen:
        seen.page.set_viewport_size({"width": 390, "height": 844})
        seen.page.goto(server.address)
        first = settled(seen)
        wide = "() => document.documentElement.scrollWidth <= innerWidth"
        assert seen.page.evaluate(wide)
        row = seen.page.locator("#rows tr").first.bounding_box()
        assert row["y"] + row["height"] < 844  # the answer before all knobs
        seen.page.click("#pin")
        figure = seen.page.locator('input[data-knob="spread"]')
        figure.fill("2.5")
        figure.press("Enter")
        moved = settled(seen, spread=2.5)
        assert seen.page.url.endswith("#spread=2.5")
        was = seen.page.locator("#rows tr td.pinned").all_inner_texts()
        assert [w.split(" ", 1)[1].startswith(first[n]) for n, w in zip(first, was)] == [True] * len(first)
        seen.page.click("#undo")
        assert settled(seen, spread=1.0) == first
        seen.page.click("#redo")
        assert settled(seen, spread=2.5) == moved
        address = seen.page.url
        assert seen.page.evaluate(wide)
        figure.fill("99")
        figure.press("Enter")
        assert figure.input_value() == "2.5"
        assert "0.5 to 3" in seen.page.locator("#status").inner_text()
        assert seen.complaints == []
    with Watched(plugged) as again:
        again.page.goto(address)
        assert settled(again, spread=2.5) == moved


def test_other_sites_get_nothing(plugged: Any, server: WorkbenchServer) -> None:
    """Under another name of this machine the answer is 403; a page from elsewhere can neither ask nor read."""
    port = server.server_address[1]
    with Watched(plugged) as seen:
        answer = seen.page.goto(f"http://localhost:{port}/?token={server.token}")
        assert answer.status == 403
        ask = "([to, body]) => fetch(to, {method: 'POST', headers: {'X-Token': body}, body: '{}'}).then(() => 'read', () => 'refused')"
        assert seen.page.evaluate(ask, [f"{server.origin}/state", server.token]) == "refused"
        frame = f'<iframe src="{server.address}"></iframe>'
        seen.page.goto("about:blank")
        seen.page.set_content(frame)
        seen.page.wait_for_timeout(500)
        assert not any(f.locator("#rows").count() for f in seen.page.frames)


def test_names_from_files_never_run(plugged: Any, hostile: WorkbenchServer) -> None:
    with Watched(plugged) as seen:
        seen.page.goto(hostile.address)
        settled(seen)
        assert "OWNED" in seen.page.title()  # as text, with the words around it
        assert seen.page.title() != "OWNED"
        assert seen.page.locator("img[src=x]").count() == 0
        assert seen.complaints == []


def test_no_barrier_for_readers(plugged: Any, server: WorkbenchServer) -> None:
    axe = pytest.importorskip(
        "axe_playwright_python.sync_playwright",
        reason="axe-playwright-python is missing: pip install vcmm[browser]",
    )
    with Watched(plugged) as seen:
        seen.page.goto(server.address)
        settled(seen)
        found = axe.Axe().run(seen.page).response["violations"]
    serious = [
        (v["id"], [n["target"] for n in v["nodes"]][:5])
        for v in found
        if v["impact"] in ("serious", "critical")
    ]
    assert serious == [], json.dumps(serious)


def test_a_closed_page_leaves_the_bench_working(plugged: Any, server: WorkbenchServer) -> None:
    with Watched(plugged) as seen:
        seen.page.goto(server.address)
        seen.page.wait_for_selector("input[type=range]")
        turn(seen, "spread", 2.0)
    with Watched(plugged) as seen:
        seen.page.goto(server.address)
        assert len(settled(seen)) == 3
