"""The eight lessons: numbered, and their numbers those that the command gives for the same scenario.

The eighth writes an effect of its own, which no command knows: its numbers are asserted in its own cells.
"""

from __future__ import annotations

import json
from pathlib import Path
from typing import Any

import pytest

from tests.hostile.judge import ask
from tests.house.test_notebooks import NOTEBOOKS, read, run_cell
from vcmm.files.own.library import example

LESSONS = {p.stem[:2]: p for p in NOTEBOOKS if p.stem[:2].isdigit()}


def test_there_are_nine_in_their_order() -> None:
    assert list(LESSONS) == [f"{n:02d}" for n in range(1, 10)]
    for n, file in enumerate(LESSONS.values(), 1):
        assert f"\n# # {n}. " in file.read_text(encoding="utf-8")


def values_of(lesson: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> dict[str, Any]:
    monkeypatch.setenv("MPLBACKEND", "agg")
    monkeypatch.chdir(tmp_path)
    namespace: dict[str, Any] = {"__name__": "__main__"}
    for cell in read(LESSONS[lesson]).cells:
        if cell.cell_type == "code":
            run_cell(cell.source, lesson, namespace)
    return namespace


def printed(*words: str) -> Any:
    answer = ask(words)
    assert answer.code in (0, 1), answer.err
    return json.loads(answer.out)


@pytest.mark.thorough
@pytest.mark.parametrize(
    ("lesson", "scenario"), [("01", "ring_gauge"), ("02", "plate"), ("03", "certificate")]
)
def test_uncertainties_are_those_of_the_command(
    lesson: str, scenario: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch
) -> None:
    result = values_of(lesson, tmp_path, monkeypatch)["result"]
    wanted = printed("uncertainty", str(example(scenario)), "--json")["characteristics"]
    for c, w in zip(result.characteristics, wanted, strict=True):
        assert (c.name, c.value, c.expanded) == (w["name"], w["value_mm"], w["U_mm"])
        assert [b.u for b in c.budget] == [b["u_mm"] for b in w["budget"]]


@pytest.mark.thorough
def test_a_cut_part_is_that_of_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    result = values_of("05", tmp_path, monkeypatch)["result"]
    wanted = printed("cut", str(example("turned_shaft")), "--trials", "1000", "--json")["characteristics"]
    for c, w in zip(result.uncertainty.characteristics, wanted, strict=True):
        if "value_mm" in w:
            assert (c.name, c.value, c.expanded) == (w["name"], w["value_mm"], w["U_mm"])


@pytest.mark.thorough
def test_a_diagnosis_is_that_of_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    found = values_of("07", tmp_path, monkeypatch)["found"]
    wanted = printed("diagnose", str(example("worn_cmm")), "--seed", "1", "--json")
    assert found.verdict == wanted["verdict"]
    assert [(a.effect, a.probability) for a in found.answer] == [
        (a["effect"], a["probability"]) for a in wanted["answer"]
    ]


@pytest.mark.thorough
def test_a_pose_is_that_of_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """With the [placement] that the lesson prints at its head."""
    found = values_of("04", tmp_path, monkeypatch)["found"]
    lines = LESSONS["04"].read_text(encoding="utf-8").splitlines()
    start = lines.index("#     [placement]")
    stated = "\n".join(line.removeprefix("#     ") for line in lines[start : start + 3])
    file = tmp_path / "plate.toml"
    file.write_text(f"{example('plate').read_text(encoding='utf-8')}\n{stated}\n", encoding="utf-8")
    wanted = printed(
        "place", str(file), "--evaluations", "500", "--scan", "128", "--trials", "5000", "--json"
    )
    assert list(found.best.pose[:3]) == wanted["pose"]["shift_mm"]
    assert list(found.best.pose[3:]) == wanted["pose"]["turn_rad"]
    assert found.best.value == wanted["objective"]["value"]
    assert found.present.value == wanted["present"]["value"]


@pytest.mark.thorough
def test_a_calibration_is_that_of_the_command(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """Lowest and highest value of all eighteen curves, within 0.01 nm and 0.01 nrad."""
    found = values_of("06", tmp_path, monkeypatch)["found"]
    machine = example("traced_cmm").parent / "traced_cmm" / "machine.toml"
    wanted = printed("calibrate", str(example("traced_cmm")), "--machine", str(machine), "--json")[
        "identified"
    ]
    assert [w["error"] for w in wanted] == list(found.identified.names)
    curves = [w for w in wanted if w["error"].startswith("E")]
    assert len(curves) == 18
    for w in curves:
        scale = {"um": 1e3, "urad": 1e6}[w["unit"]]
        _, value, _ = found.band(w["error"])
        assert (scale * value.min(), scale * value.max()) == pytest.approx((w["low"], w["high"]), abs=1e-5)
