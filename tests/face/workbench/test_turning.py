"""Saving what was turned, the sweep of a knob, progress and cancel, whole folders: each against figures of another way."""

from __future__ import annotations

import html
import json
import re
import threading
import time
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from tests.plate import PLATE, edited
from vcmm.core.errors import DataError, UsageError
from vcmm.face.workbench.bench import Bench, GivenUp, diagnose_files
from vcmm.face.workbench.live import preview
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario, turned_knobs
from vcmm.task.measuring.knobs import knobs_of, with_knobs

TURNED = {"x": 310.0, "turn": 45.0, "room": 1.5, "styli": 1.2, "touches": 2, "spread": 0.5}


def bench_of(path: Path) -> Bench:
    return Bench(load_scenario(path, knobs=False), path)


def test_a_saved_file_is_the_task_with_its_knobs_turned(tmp_path: Path) -> None:
    path = edited(tmp_path, ('name = "bridge CMM"', 'name = "bridge CMM"  # mine'))
    bench = bench_of(path)
    saved = bench.text_with_knobs(TURNED)
    assert saved["name"] == "plate-turned.toml"
    again = tmp_path / saved["name"]
    again.write_text(saved["toml"])
    assert "# mine" in saved["toml"]
    assert 'shift = "310 250 -300 mm"' in saved["toml"]
    assert turned_knobs(again) == {"room": 1.5, "styli": 1.2, "touches": 2.0, "spread": 0.5}
    wanted, found = (
        preview(s, seed=1)["characteristics"]
        for s in (with_knobs(load_scenario(path), TURNED), load_scenario(again))
    )
    for a, b in zip(wanted, found):
        assert b["U"] == pytest.approx(a["U"], rel=1e-9)
        assert b["value"] == pytest.approx(a["value"], abs=1e-9)
    # opened again, its knobs stand where they were left, and saved again it says the same
    other = bench_of(again)
    assert other.state()["turned"] == {"room": 1.5, "styli": 1.2, "touches": 2.0, "spread": 0.5}
    second = other.text_with_knobs(other.state()["turned"])
    assert second == saved
    plain = other.text_with_knobs({})
    assert "[knobs]" not in plain["toml"]


def test_knobs_of_a_file_by_hand(tmp_path: Path) -> None:
    """room 2 K: 21.2 + 2 = 23.2 degC; spread 0.5: 0.7 um becomes 0.35 um; styli 1.5: the tip at -180 mm instead of -120."""
    text = PLATE + '[knobs]\nroom = "2 K"\nspread = 0.5\nstyli = 1.5\ntouches = 3\n'
    (tmp_path / "p.toml").write_text(text)
    turned = load_scenario(tmp_path / "p.toml")
    assert turned.constants["temp_part_C"] == pytest.approx(23.2)
    assert turned.plan.styli["down"].offset[2] == pytest.approx(-180.0)
    assert len(turned.plan.steps[0].points) == 27
    scatter = next(i for i in turned.machine.inputs if i.redraw == "touch")
    assert scatter.law.scale == pytest.approx(0.35e-3)


@pytest.mark.parametrize(
    ("line", "says"),
    [
        ("spread = 9.0", "from 0.5 to 3"),
        ("touches = 1.5", "whole number"),
        ("room = 2.0", "unit"),
        ("speed = 1.0", "speed"),
    ],
)
def test_wrong_knobs_of_a_file_are_told_with_their_line(tmp_path: Path, line: str, says: str) -> None:
    (tmp_path / "p.toml").write_text(f"{PLATE}[knobs]\n{line}\n")
    with pytest.raises(DataError) as told:
        load_scenario(tmp_path / "p.toml")
    assert says in str(told.value)
    assert f"p.toml:{len(PLATE.splitlines()) + 2}" in str(told.value)


def test_a_task_without_a_file_is_not_saved(tmp_path: Path) -> None:
    with pytest.raises(UsageError, match="not read from a file"):
        Bench(load_scenario(edited(tmp_path))).text_with_knobs({})


@pytest.mark.thorough
def test_a_sweep_is_the_previews_one_by_one(tmp_path: Path) -> None:
    """Numbers of the answer, numbers of the picture, and previews asked for by themselves are the same.

    By pencil: all of U of "bore square to top" is scatter, so it is proportional to the knob of the scatter.
    """
    bench = bench_of(edited(tmp_path))
    found = bench.sweep({"styli": 1.1}, "spread")
    assert found["at"][0] == 0.5
    assert found["at"][-1] == 3.0
    assert found["reasons"] == []
    pictured = [
        json.loads(html.unescape(m)) for m in re.findall(r'data-chart="([^"]*)"', "".join(found["pictures"]))
    ]
    assert [p["chart"] for p in pictured] == ["sweep"]
    assert pictured[0]["U"] == found["U"]
    assert pictured[0]["at"] == found["at"]
    i = 3
    alone = preview(with_knobs(bench.scenario, {"styli": 1.1, "spread": found["at"][i]}), bench.scenario.settings.seed)  # fmt: skip
    for c in alone["characteristics"]:
        assert found["U"][c["name"]][i] == pytest.approx(c["U"], rel=1e-12)
    square = np.array(found["U"]["bore square to top"])
    assert square / square[0] == pytest.approx(np.array(found["at"]) / 0.5, rel=0.02)


@pytest.mark.thorough
def test_a_sweep_says_where_the_machine_ends(tmp_path: Path) -> None:
    bench = bench_of(edited(tmp_path))
    found = bench.sweep({}, "x")
    assert 0 < len(found["reasons"]) < len(found["at"])
    for us in found["U"].values():
        assert sum(u is None for u in us) == len(found["reasons"])
    assert "travel" in found["reasons"][0]
    with pytest.raises(UsageError, match="no knob"):
        bench.sweep({}, "speed")


def test_long_work_tells_how_far_it_is_and_ends_when_cancelled(tmp_path: Path) -> None:
    bench, ended = bench_of(edited(tmp_path, ("trials = 20000", "trials = 5000"))), []

    def work() -> None:
        try:
            bench.sweep({}, "spread", "page")
        except GivenUp:
            ended.append(True)

    thread = threading.Thread(target=work)
    thread.start()
    seen: list[float] = []
    until = time.monotonic() + 60.0
    while (not seen or seen[-1] == 0.0) and time.monotonic() < until and thread.is_alive():
        share = bench.progress("page")["share"]
        if share is not None:
            seen.append(share)
        time.sleep(0.02)
    assert 0.0 < seen[-1] < 1.0
    assert bench.progress("another") == {"text": "", "share": None}
    bench.cancel("page")
    thread.join(30.0)
    assert ended == [True]
    assert bench.progress("page")["share"] is None


@pytest.mark.thorough
def test_the_untouched_files_of_an_example_are_taken_as_a_folder(tmp_path: Path) -> None:
    head = example("ballbar")
    files: dict[str, bytes] = {"mine/ballbar.toml": head.read_bytes()}
    for name in ("circles.csv", "machine.toml"):
        files[f"mine/ballbar/{name}"] = (head.parent / "ballbar" / name).read_bytes()
    assert diagnose_files(files, tmp_path)["verdict"] == "explained"


def test_a_file_and_a_folder_of_one_name_are_told(tmp_path: Path) -> None:
    head = b'vcmm = "recording/1"\n'
    with pytest.raises(UsageError, match="same name"):
        diagnose_files({"r.toml": head, "a": b"", "a/b.csv": b""}, tmp_path)


@pytest.mark.parametrize(
    "name", ["../a.csv", "a/../b.csv", "/etc/passwd", "a//b", "a/.b", "a/b/c/d/e/f.csv", "a\\b", "C:/a", "a/"]
)
def test_names_that_leave_the_folder_are_refused(name: str) -> None:
    from vcmm.face.workbench.server import PLAIN

    assert not PLAIN.fullmatch(name)
    assert PLAIN.fullmatch("a/b c.csv")


def test_knobs_stand_once_in_the_list_of_the_page(tmp_path: Path) -> None:
    bench: Any = bench_of(edited(tmp_path))
    names = [k["name"] for k in bench.state()["knobs"]]
    assert names == [k.name for k in knobs_of(bench.scenario)]
    assert len(set(names)) == len(names)
