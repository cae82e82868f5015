"""The mill that `vcmm new tracked_mill` copies: its year is what its case draws, and the commands of docs/track.md find what is concealed in it."""

from __future__ import annotations

import json
import shlex
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np
import pytest
from vcmm_twins.tracked_mill import recorded

from tests.hostile.judge import ask
from vcmm.core.run import Run
from vcmm.files.own.library import companions, example, folder
from vcmm.files.own.machine import load_machine
from vcmm.files.own.schemas import json_schema

LINEAR = ("scale_factor[X].k", "scale_factor[Y].k", "scale_factor[Z].k")
SQUARE = ("squareness[C0Y].angle", "squareness[B0Z].angle", "squareness[A0Z].angle")
NUMBERS = (*LINEAR, *SQUARE)  # in the order of the case, um/m and urad


def test_the_recordings_are_what_the_case_makes() -> None:
    made = recorded.texts()
    for name, text in made.items():
        stored = (folder() / "tracked_mill" / name).read_text(encoding="utf-8")
        if name.endswith(".toml"):
            assert stored == text
            continue
        assert stored.splitlines()[0] == text.splitlines()[0]
        assert numbers(stored) == pytest.approx(numbers(text), abs=1e-6)
    lists = {f"tracked_mill/{n}" for n in ("machine.toml", "checks.toml", "parts.csv")}
    assert set(companions("tracked_mill")) == lists | {f"tracked_mill/{n}" for n in made}


def numbers(text: str) -> np.ndarray:
    return np.array([[float(v) for v in row.split(",")] for row in text.splitlines()[1:]])


def test_the_formula_of_the_case_is_the_machine_of_the_file() -> None:
    """Tip errors by the sum in the head of the case and by vcmm, for numbers of every kind: signs and frames agree to second order, a nanometre."""
    machine = load_machine(folder() / "tracked_mill" / "machine.toml")
    theta, warm = np.array([15.0, -3.0, 2.0, 42.0, -4.0, 2.5]), np.array([18.5, 22.0, 23.0])
    new = []
    for effect in machine.effects:
        if f"{effect.id}.k" in LINEAR or f"{effect.id}.angle" in SQUARE:
            name = "k" if effect.name == "scale_factor" else "angle"
            new.append(type(effect)(effect.where, theta[NUMBERS.index(f"{effect.id}.{name}")] * 1e-6))
        elif effect.name == "scale_expansion":
            new.append(type(effect)(effect.where, recorded.EXPANSION * 1e-6))
    q = np.array([[0.0, 0.0, 0.0], [450.0, 300.0, 200.0], [120.0, 480.0, 410.0]])
    columns = {f"temp_scale_{a}_C": np.full(len(q), t) for a, t in zip("xyz", warm)}
    run = Run({a: q[:, i] for i, a in enumerate("XYZ")}, np.zeros((len(q), 3)), columns=columns)
    assert len(new) == 9
    found = replace(machine, effects=tuple(new)).tip_error(run)
    assert found * 1e3 == pytest.approx(recorded.tip(theta, warm, q), abs=1e-3)


@pytest.fixture(scope="module")
def year(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The folder after the commands that `vcmm new` prints."""
    place = tmp_path_factory.mktemp("year")
    with pytest.MonkeyPatch.context() as here:
        here.chdir(place)
        written = ask(["new", "tracked_mill"])
        assert written.code == 0, written.err
        for line in written.out.strip().splitlines():
            word, *words = shlex.split(line)
            assert word == "vcmm"
            answer = ask(words)
            assert answer.code == 0, answer.err
    return place


def document(year: Path, *more: str) -> dict[str, Any]:
    """vcmm.track/1 of the state that lies there."""
    with pytest.MonkeyPatch.context() as here:
        here.chdir(year)
        answer = ask(["track", "tracked_mill/machine.toml", "tracked_mill/checks", *more, "--json"])
    assert answer.code == 0, answer.err
    found: dict[str, Any] = json.loads(answer.out)
    return found


@pytest.mark.thorough
def test_the_collision_is_named_with_its_size_and_its_two_dates(year: Path) -> None:
    """18 June lies between the ball bar of the 5th and the plate of the 22nd: C0Y + 38 urad and what it wandered, below 1 urad."""
    (alarm,) = document(year)["alarms"]
    assert (alarm["since"], alarm["date"]) == ("2026-06-05", "2026-06-22")
    assert alarm["changed"][0]["name"] == "squareness[C0Y].angle"
    assert alarm["changed"][0]["probability"] > 0.9
    said = alarm["diagnosis"]
    assert said.startswith("explained: squareness C0Y, angle +")
    assert "a collision" in said
    size, u = (float(v) for v in said.partition("angle ")[2].partition(" urad")[0].split(" ± "))
    assert abs(size - recorded.COLLISION) < 3 * u
    assert u < 4.0


@pytest.mark.thorough
def test_the_bands_hold_the_truth_of_the_days(year: Path) -> None:
    """Six numbers on 21 days; correlated from day to day, so that three quarters are asked for and none beyond five u."""
    theta, found = recorded.truth(), {p["input"]: p for p in document(year)["parameters"]}
    days = [day for day, _ in recorded.calendar()]
    inside = []
    for i, name in enumerate(NUMBERS):
        off = (np.array(found[name]["value"]) - theta[days, i]) / np.array(found[name]["u"])
        assert np.abs(off).max() < 5.0
        inside.append((np.abs(off) < 1.96).mean())
    assert np.mean(inside) > 0.75


@pytest.mark.thorough
def test_parts_of_the_days_between_are_doubtful_by_what_pencil_says(year: Path) -> None:
    """The bores lie 300 mm apart in X and 200 mm in Y, 360.56 mm in all. A tool-side or table-side Y turned by c moves the tip by -c y in X; measured
    is the opposite, so that the distance is indicated longer by c 200 300 / 360.56 = 166.4 mm c: 6.3 um for 38 urad.
    """
    (found,) = document(year, "--task", "tracked_mill.toml", "--parts", "tracked_mill/parts.csv")["doubtful"]
    assert [p["part"] for p in found["parts"]] == [f"housing {n}" for n in (101, 102, 103, 104)]
    shift = {s["characteristic"]: s for s in found["shifts"]}
    assert abs(shift["bores"]["shift"] - 166.4 * 38e-6) < 2 * shift["bores"]["u"]
    assert shift["bores"]["shift"] > 3 * shift["bores"]["u"]
    assert abs(abs(shift["square"]["shift"]) - 38e-6) < 2 * shift["square"]["u"]


@pytest.mark.thorough
def test_the_plan_keeps_the_limit_and_costs_less_than_an_interval(year: Path) -> None:
    words = (
        "--task",
        "tracked_mill.toml",
        "--limit",
        "length = 2 um",
        "--checks",
        "tracked_mill/checks.toml",
    )
    found = document(year, *words, "--days", "90")
    plan = found["plan"]
    assert plan["kept"]
    assert plan["cost"] < plan["fixed_interval"]["cost"]
    assert {n["check"] for n in found["next_checks"]} == {
        "sphere plate",
        "ball bar, three planes",
        "laser along X",
    }
    assert all(n["U_after"]["length"] < 2e-3 for n in found["next_checks"])


@pytest.mark.thorough
def test_the_document_with_all_that_may_be_asked_is_valid_by_its_schema(year: Path) -> None:
    jsonschema = pytest.importorskip(
        "jsonschema", reason="jsonschema comes with nbformat: pip install vcmm[notebook]"
    )
    words = ("--task", "tracked_mill.toml", "--limit", "length = 2 um", "--limit", "square = 20 urad")
    lists = ("--checks", "tracked_mill/checks.toml", "--parts", "tracked_mill/parts.csv", "--learn-rest")
    found = document(year, *words, *lists, "--at", "2027-02-01")
    known = jsonschema.Draft202012Validator(json_schema("track"))
    assert [f"{list(e.absolute_path)}: {e.message}" for e in known.iter_errors(found)] == []
    assert {"limits", "next_checks", "plan", "doubtful", "learned"} <= found.keys()
    written = json.loads((year / "tracked_mill" / "checks-track" / "track.json").read_text(encoding="utf-8"))
    assert list(known.iter_errors(written)) == []


def test_the_task_names_its_machine_under_another_name(tmp_path: Path) -> None:
    """`vcmm new mine --from tracked_mill`: what the scenario and the printed commands name lies in the folder mine."""
    answer = ask(["new", "mine", "--from", "tracked_mill", "--out", str(tmp_path)])
    assert answer.code == 0, answer.err
    assert 'machine = "mine/machine.toml"' in (tmp_path / "mine.toml").read_text(encoding="utf-8")
    assert f"vcmm track {tmp_path / 'mine' / 'machine.toml'} {tmp_path / 'mine' / 'checks'}" in answer.out
    assert "45 files in" in answer.err
    assert ask(["check", str(tmp_path / "mine.toml")]).code == 0
    assert example("year") == example("tracked_mill")
