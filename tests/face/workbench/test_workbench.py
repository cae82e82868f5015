"""The workbench: knobs, previews, one computation at a time, and a server that answers to its own page only."""

from __future__ import annotations

import http.client
import json
import threading
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.plate import PLATE
from vcmm.core.errors import Environment, UsageError
from vcmm.face.workbench.bench import MOST_PAGES, Bench, GivenUp
from vcmm.face.workbench.live import preview
from vcmm.face.workbench.server import WorkbenchServer
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario
from vcmm.task.measuring.knobs import knobs_of, with_knobs
from vcmm.task.measuring.scenario import Scenario


@pytest.fixture(scope="module")
def scenario(tmp_path_factory: pytest.TempPathFactory) -> Scenario:
    path = tmp_path_factory.mktemp("bench") / "plate.toml"
    path.write_text(PLATE.replace("trials = 20000", "trials = 1000"))
    return load_scenario(path)


@pytest.fixture(scope="module")
def server(scenario: Scenario) -> Iterator[WorkbenchServer]:
    with WorkbenchServer(Bench(scenario)) as made:
        threading.Thread(target=made.serve_forever, daemon=True).start()
        yield made
        made.shutdown()


def asked(server: WorkbenchServer, path: str, body: Any = None, **headers: str) -> tuple[int, Any]:
    connection = http.client.HTTPConnection("127.0.0.1", server.server_address[1], timeout=60)
    given = {"X-Token": server.token, **{k.replace("_", "-"): v for k, v in headers.items()}}
    connection.request(
        "POST" if body is not None else "GET", path, None if body is None else json.dumps(body), given
    )
    answer = connection.getresponse()
    text = answer.read().decode()
    connection.close()
    return answer.status, json.loads(text) if answer.headers["Content-Type"] == "application/json" else text


def test_knobs_stand_where_the_scenario_does(scenario: Scenario) -> None:
    assert [k.name for k in knobs_of(scenario)] == [
        "x",
        "y",
        "z",
        "turn",
        "room",
        "styli",
        "touches",
        "spread",
    ]
    same = with_knobs(scenario, {k.name: k.start for k in knobs_of(scenario)})
    assert np.allclose(same.pose.rotation, scenario.pose.rotation, atol=1e-15)
    assert preview(same)["characteristics"] == preview(scenario)["characteristics"]


def test_knobs_turn_what_they_say(scenario: Scenario) -> None:
    start = {k.name: k.start for k in knobs_of(scenario)}
    moved = with_knobs(
        scenario,
        {"x": start["x"] + 7.0, "turn": start["turn"] + 90.0, "room": 2.0, "styli": 2.0, "touches": 3},
    )
    assert moved.pose.shift[0] - scenario.pose.shift[0] == pytest.approx(7.0)
    assert np.degrees(moved.pose.turns()[2] - scenario.pose.turns()[2]) % 360 == pytest.approx(90.0)
    assert len(moved.plan.steps[0].points) == 3 * len(scenario.plan.steps[0].points)
    name, stylus = next(iter(scenario.plan.styli.items()))
    assert moved.plan.styli[name].offset == pytest.approx(2.0 * stylus.offset)
    for column, value in scenario.constants.items():
        assert moved.constants[column] - value == pytest.approx(0.0 if "gradient" in column else 2.0)


@pytest.mark.parametrize(("knobs", "says"), [({"speed": 1.0}, "no knob"), ({"x": 1e9}, "the knob goes from"), ({"x": "3"}, "finite number"), ({"x": float("nan")}, "finite")])  # fmt: skip
def test_knobs_that_cannot_be_turned(scenario: Scenario, knobs: dict[str, Any], says: str) -> None:
    with pytest.raises(UsageError, match=says):
        with_knobs(scenario, knobs)


@pytest.mark.thorough
def test_a_preview_is_what_the_evaluation_says(scenario: Scenario) -> None:
    """The same number, where the evaluation takes trials within their error: with 20 000 trials a quantile of 2.5 % of a normal law is known to sqrt(0.025 0.975 / 20000) / 0.0584 = 1.9 % of u, 1 % of U; three times that."""
    from vcmm.face import api

    seen = {c["name"]: c for c in preview(scenario)["characteristics"]}
    whole = api.uncertainty(scenario, trials=20_000).characteristics
    assert {c.type for c in whole} >= {"size", "distance", "perpendicularity"}
    for c in whole:
        rel = 1e-9 if not c.trials or c.extreme else 0.03
        assert seen[c.name]["U"] == pytest.approx(1e3 * c.expanded, rel=rel)
        assert seen[c.name]["value"] == pytest.approx(c.value, abs=1e-9)


def test_more_touches_less_scatter(scenario: Scenario) -> None:
    """Four touches at every place halve the share of the scatter: u^2 falls by three quarters of it."""

    def parts(knobs: dict[str, float]) -> dict[str, float]:
        found = preview(with_knobs(scenario, knobs))["characteristics"][0]
        return {b["input"]: b["share"] * found["u"] ** 2 for b in found["budget"]}

    one, four, wide = parts({"touches": 1}), parts({"touches": 4}), parts({"spread": 2.0})
    name = next(n for n in one if n.startswith("scatter"))
    assert four[name] == pytest.approx(one[name] / 4, rel=1e-6)
    assert wide[name] == pytest.approx(one[name] * 4, rel=1e-6)


def test_a_newer_question_ends_an_older_one(scenario: Scenario) -> None:
    bench = Bench(scenario)
    started = threading.Event()
    outcome: list[object] = []

    def slow() -> None:
        wanted = bench._check_newest

        def told(question: int) -> None:
            started.set()
            newer.wait(20)
            wanted(question)

        bench._check_newest = told  # type: ignore[method-assign]
        try:
            outcome.append(bench.settle({}))
        except GivenUp as why:
            outcome.append(why)

    newer = threading.Event()
    thread = threading.Thread(target=slow)
    thread.start()
    assert started.wait(20)
    bench._ask()
    newer.set()
    thread.join(60)
    assert isinstance(outcome[0], GivenUp)


def test_one_page_does_not_end_the_question_of_another(scenario: Scenario) -> None:
    bench = Bench(scenario)
    first = bench._ask("a")
    bench._ask("b")
    bench._check_newest(first)
    bench._ask("a")
    with pytest.raises(GivenUp):
        bench._check_newest(first)


def test_pages_long_closed_are_forgotten(scenario: Scenario) -> None:
    bench = Bench(scenario)
    for number in range(3 * MOST_PAGES):
        bench._ask(str(number))
    assert len(bench._newest) == MOST_PAGES
    bench._check_newest((str(3 * MOST_PAGES - 1), 1))


def test_a_warmer_room_is_that_of_the_file(tmp_path: Path) -> None:
    """Sensors read what is there: 8 K on the knob are 28 degC in the file. By hand: 50 mm, 11.5 um/(m K), scales compensated: 4.6 um."""
    ring = load_scenario(example("ring_gauge"))
    stated = ", ".join(
        f'{name} = "28 degC"' for name in ("part", "scale_x", "scale_y", "scale_z", "air", "spindle")
    )
    text = example("ring_gauge").read_text()
    warm = text.replace('temperature = { part = "20.0 degC" }', f"temperature = {{ {stated} }}")
    assert warm != text
    (tmp_path / "warm.toml").write_text(warm)
    written = load_scenario(tmp_path / "warm.toml")
    assert isinstance(ring, Scenario)
    assert isinstance(written, Scenario)
    by_knob, by_file = (preview(s)["characteristics"][0] for s in (with_knobs(ring, {"room": 8.0}), written))
    assert by_knob["value"] == pytest.approx(by_file["value"], abs=1e-9)
    assert by_knob["U"] == pytest.approx(by_file["U"], rel=1e-9)
    assert by_knob["value"] == pytest.approx(50.0 + 4.6e-3, abs=1e-6)


def test_owners_have_the_words_of_the_evaluation(scenario: Scenario) -> None:
    from vcmm.face import api

    seen = preview(scenario)["characteristics"]
    whole = {
        b.input: b.what for c in api.uncertainty(scenario, trials=1000).characteristics for b in c.budget
    }
    owners = [b for c in seen for b in c["budget"]]
    assert owners
    for b in owners:
        assert b["what"] == whole[b["input"]]


def test_a_page_that_closes_leaves_no_traceback(
    server: WorkbenchServer, capfd: pytest.CaptureFixture[str]
) -> None:
    """A reset in the middle of an answer is silent; a fault of ours is not."""
    for fault, told in ((BrokenPipeError(32, "Broken pipe"), False), (ZeroDivisionError("ours"), True)):
        try:
            raise fault
        except Exception:
            server.handle_error(None, ("127.0.0.1", 1))
        assert ("Traceback" in capfd.readouterr().err) is told


def test_the_page_comes_to_who_has_the_token(server: WorkbenchServer) -> None:
    status, page = asked(server, f"/?token={server.token}")
    assert status == 200
    assert page.count("<script") == 4
    assert asked(server, "/?token=x")[0] == 403
    assert asked(server, f"/etc/passwd?token={server.token}")[0] == 404
    assert asked(server, f"/../../etc/passwd?token={server.token}")[0] == 404


@pytest.mark.parametrize("headers", [{"Host": "evil.example:80"}, {"Host": "localhost:1"}, {"Origin": "http://evil.example"}, {"X_Token": "x"}])  # fmt: skip
def test_other_sites_get_nothing(server: WorkbenchServer, headers: dict[str, str]) -> None:
    status, answer = asked(server, "/state", {}, **headers)
    assert status == 403
    assert set(answer) == {"error"}


def test_questions_and_wrong_questions(server: WorkbenchServer) -> None:
    assert asked(server, "/state", {})[1]["knobs"][0]["name"] == "x"
    status, answer = asked(server, "/preview", {"knobs": {"spread": 2.0}})
    assert status == 200
    assert answer["preview"] is True
    assert asked(server, "/preview", {"knobs": {"z": 1e9}})[0] == 422
    assert asked(server, "/preview", {})[0] == 422
    assert asked(server, "/preview", [1])[0] == 400
    assert asked(server, "/run", {})[0] == 404
    assert asked(server, "/diagnose", {"files": {"../machine.toml": ""}}) == (422, {"error": "a dropped file needs a plain name: letters, digits, dots, dashes"})  # fmt: skip
    outside = 'vcmm = "recording/1"\nmachine = "/etc/passwd"\ndata = "a.csv"\n'
    assert (
        "a file outside the given files is named"
        in asked(server, "/diagnose", {"files": {"r.toml": outside, "a.csv": "x"}})[1]["error"]
    )
    long = 'vcmm = "recording/1"\nname = "' + "long " * 2000 + '"\n'
    assert asked(server, "/diagnose", {"files": {"r.toml": long}})[0] == 422
    assert "drop one recording" in asked(server, "/diagnose", {"files": {"a.csv": "x"}})[1]["error"]


def test_a_whole_evaluation_brings_its_scenes(server: WorkbenchServer) -> None:
    status, answer = asked(server, "/settled", {"knobs": {"room": 1.0}})
    assert status == 200
    assert answer["schema"] == "vcmm.uncertainty/1"
    assert [len(f["data"]) > 3 for f in answer["figures"]] == [True, True]


def test_a_taken_port_is_said(server: WorkbenchServer, scenario: Scenario) -> None:
    with pytest.raises(Environment, match="--port"):
        WorkbenchServer(Bench(scenario), server.server_address[1])
