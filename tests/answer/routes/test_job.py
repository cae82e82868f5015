"""vcmm routes from the user's chair: own measurements, a drawn machine, disagreement, bad input."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.plate import edited
from vcmm.answer.routes.hidden_machine import (
    HiddenMachine,
    hidden_part,
    shows,
    standards,
    true_values,
    usable_positions,
)
from vcmm.answer.routes.job import routes
from vcmm.core.errors import ModelLimit
from vcmm.face.cli import run
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario

QUICK = ("--trials", "2000")


def document(capsys: pytest.CaptureFixture[str], *words: str) -> tuple[int, dict]:
    code = run(["routes", *words, *QUICK, "--json"])
    out, err = capsys.readouterr()
    assert out, err
    return code, json.loads(out)


def own_files(folder: Path, systematic_um: float) -> list[str]:
    """A calibrated part 20 times, and the part in three positions with a block and a ring."""
    noise = 0.3 * np.tile([-1.0, 1.0], 10)
    rows = [f"bore diameter,{30.002 + 1e-3 * (systematic_um + e):.7f},20.5" for e in noise]
    (folder / "repeats.csv").write_text("characteristic,value_mm,temp_part_C\n" + "\n".join(rows))
    (folder / "calibrated.csv").write_text("characteristic,value_mm,U_um,k\nbore diameter,30.002,0.4,2\n")
    (folder / "values.csv").write_text("characteristic,value_mm\nbore diameter,30.010\n")
    places = [f"{p},bore diameter,{10 + e}" for p, e in (("a", 0.1), ("a", -0.1), ("b", 0.2), ("c", -0.2))]
    (folder / "positions.csv").write_text("position,characteristic,deviation_um\n" + "\n".join(places))
    (folder / "standards.csv").write_text(
        "standard,calibrated_mm,U_um,k,reading_mm\nlength,100,0.2,2,100.0001\nring,30,0.2,2,29.9999\n"
    )
    names = ("repeats", "calibrated", "values", "positions", "standards")
    return [word for n in names for word in (f"--{n}", str(folder / f"{n}.csv"))]


def test_own_measurements(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    """b = 0.5 um: 30.0095; u_p = 0.3 sqrt(20 / 19) um; expansion 1e-6 / K x 0.5 K x 30 mm = 0.015 um.

    Block: 100 e_L + 2 delta = 0.1 um, ring: 30 e_L - 2 delta = -0.1 um: e_L = 0, delta = 0.05 um; mean of a, b, c = 30.010 + 0.1 um.
    """
    scenario = edited(tmp_path)
    files = own_files(tmp_path, 0.5)
    code, found = document(capsys, str(scenario), *files, "--out", str(tmp_path / "out"))
    (c,) = [x for x in found["characteristics"] if x["name"] == "bore diameter"]
    by = {r["route"]: r for r in c["routes"]}
    assert c["reading_mm"] == 30.010
    assert c["true_mm"] is None
    assert by["calibrated part"]["value_mm"] == pytest.approx(30.0095)
    u = {k["name"]: k["u_mm"] * 1e3 for k in by["calibrated part"]["contributions"]}
    assert u["calibration of the calibrated part"] == pytest.approx(0.2)
    assert u["scatter of the reading"] == pytest.approx(0.3 * np.sqrt(20 / 19))
    assert u["expansion of the measured part"] == pytest.approx(0.015, rel=1e-3)
    assert by["several positions"]["value_mm"] == pytest.approx(30.0101, abs=1e-8)
    assert code == int(not found["agree"]) == int(any(abs(a["E_n"]) > 1 for a in c["agreements"]))
    assert {str(tmp_path / "repeats.csv"), str(scenario)} <= {i["file"] for i in found["inputs"]}
    assert {p.name for p in (tmp_path / "out").iterdir()} == {"report.html", "routes.json", "routes.csv"}
    assert (
        json.loads((tmp_path / "out" / "routes.json").read_text())["characteristics"]
        == found["characteristics"]
    )


def test_a_machine_that_is_not_the_one_of_the_file(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """The calibrated part shows 9 um that the model does not know."""
    scenario = edited(tmp_path)
    code, found = document(capsys, str(scenario), *own_files(tmp_path, 9.0))
    assert code == 1
    pairs = {tuple(a["between"]): a for c in found["characteristics"] for a in c["agreements"]}
    assert abs(pairs["virtual CMM", "calibrated part"]["E_n"]) > 1
    assert "scatter of the reading" in pairs["virtual CMM", "calibrated part"]["shared"]


def test_a_drawn_machine_is_kept_and_its_scatter_is_not(tmp_path: Path) -> None:
    scenario = load_scenario(example("plate"))
    task, machine = scenario.task(), HiddenMachine(3)
    first, again = machine.measure(task, 1, 0, 4), machine.measure(task, 1, 0, 4)
    assert np.array_equal(first, again)
    assert np.ptp(first[:, 0]) > 1e-5
    noise = np.std(machine.measure(task, 1, 0, 20)[:, 0], ddof=1)
    drawn = np.std([HiddenMachine(s).measure(task, 1, 0, 1)[0, 0] for s in range(8)], ddof=1)
    assert drawn > noise  # from machine to machine more varies than from day to day


def test_every_route_is_held_to_a_hidden_truth() -> None:
    """One machine: each route's value is within 1.5 U of a truth that it does not know, and no route returns the reading."""
    scenario = load_scenario(example("ring_gauge"))
    found = routes(scenario, settings=replace(scenario.settings, trials=2000, seed=4, certify=10))
    (c,) = found.characteristics
    assert found.simulated
    assert [r.route for r in c.routes] == ["virtual CMM", "calibrated part", "several positions"]
    assert all(0 < abs(c.error(r) or 0.0) < 1.5 for r in c.routes)
    assert len({r.value for r in c.routes}) == 3
    assert c.truth not in (c.reading, *(r.value for r in c.routes))


def test_what_points_scaled_and_moved_do() -> None:
    """A bore of 30 mm: 30 mm per 1, -2 per mm outwards (its normal looks to the axis); its distance of 40 mm to a face: 40, and 1."""
    scenario = load_scenario(example("plate"))
    found = shows(scenario.task())
    assert found[0] == pytest.approx([30.0, -2.0], abs=1e-4)
    assert found[1] == pytest.approx([40.0, 1.0], abs=1e-4)


def test_positions_are_within_reach_and_the_part_stays_the_same() -> None:
    scenario = load_scenario(example("plate"))
    places = usable_positions(scenario)
    assert len(places) == 4
    one = hidden_part(scenario.task(), 1, "x")
    truths = [true_values(replace(scenario.at(p).task(), form=one.form))[0] for p in places.values()]
    assert np.ptp(truths) < 1e-9


@pytest.mark.parametrize(
    ("name", "text", "message"),
    [
        ("calibrated", "characteristic,value_mm\nbore diameter,30.002\n", "U_um"),
        ("calibrated", "characteristic,value_mm,U_um,k\nbore diameter,30.002,0.4,95\n", "calibrated.csv:2: k = 95 is no coverage factor"),
        ("calibrated", "characteristic,value_mm,U_um,k\nbore diameter,30.002,0,2\n", "an uncertainty is above zero"),
        ("calibrated", "characteristic,value_mm,U_um,k\nbore to front,40,0.4,2\n", 'no repeats of "bore to front"'),
        ("repeats", "characteristic,value_mm\nbore diameter,30.002\n", "was measured once"),
        ("repeats", "characteristic,value_mm\nbore diametr,30.002\n", 'Did you mean "bore diameter"'),
        ("repeats", "characteristic,value_mm,temp_part_C\nbore diameter,30,-400\nbore diameter,30,20\n", "below absolute zero"),
        ("positions", "characteristic,value_mm\nbore diameter,30\n", "the column position is missing"),
        ("positions", "position,characteristic,value_mm\na,bore diameter,30\n", "measured in one position"),
        ("positions", "position,characteristic,value_mm\nnan,bore diameter,30\n", '"nan" does not name a position'),
        ("positions", "position,characteristic,value_mm\n１,bore diameter,30\n", '"１" does not name a position'),
        ("standards", "standard,calibrated_mm,U_um,k,reading_mm\nrod,100,0.2,2,100\n", 'standards.csv:2: standard "rod"'),
        ("standards", "standard,calibrated_mm,U_um,k,reading_mm\nring,100,0.2,2,25.4\n", "more than a hundredth off"),
    ],
)  # fmt: skip
def test_files_that_cannot_be_meant(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], name: str, text: str, message: str
) -> None:
    scenario, files = edited(tmp_path), own_files(tmp_path, 0.5)
    (tmp_path / f"{name}.csv").write_text(text)
    assert run(["routes", str(scenario), *files, "--json"]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err


def test_halves_of_a_pair_are_told(tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    scenario = edited(tmp_path)
    own_files(tmp_path, 0.5)
    assert run(["routes", str(scenario), "--repeats", str(tmp_path / "repeats.csv")]) == 2
    assert "takes --calibrated" in capsys.readouterr().err
    assert run(["routes", str(scenario), "--standards", str(tmp_path / "standards.csv")]) == 2
    assert "belong to --positions" in capsys.readouterr().err
    assert run(["routes", str(scenario), "--values", str(tmp_path / "values.csv")]) == 2
    assert "there is no second route" in capsys.readouterr().err


def test_the_page_shows_what_the_command_prints() -> None:
    """docs/routes.md: the published task by three routes."""
    from tests.documented import assert_documented
    from vcmm.show.tables.routes import agreements_table, routes_table

    scenario = load_scenario(example("gaska2014"))
    found = routes(scenario, settings=replace(scenario.settings, trials=20_000))
    assert_documented("routes", [routes_table(found), agreements_table(found)])


def test_a_standard_is_as_long_as_the_travels_allow() -> None:
    """The origin of the part lies at X 50 and Y 100 of 0 to 500 mm: 400 and 300 mm (sides of the part) reach 200 and 150 mm beyond it to either
    side, 50 mm only 25 mm. The 400 mm that were tried alone ended in an internal error."""
    scenario = load_scenario(example("tracked_mill"))
    places = usable_positions(scenario)
    along_x, along_y, ring = standards(scenario, HiddenMachine(1), places)
    assert {abs(f.extent[0]) for f in scenario.part.features.values() if f.extent} == {400.0, 300.0, 40.0}
    assert along_x.calibrated == pytest.approx(50.0, abs=0.001)
    assert along_y.calibrated == pytest.approx(50.0, abs=0.001)
    assert ring.calibrated == pytest.approx(20.0, abs=0.001)
    assert len(along_x.readings) == 5 * len(places)
    away = replace(scenario, pose=replace(scenario.pose, shift=np.array([5000.0, 0.0, 150.0])))
    with pytest.raises(ModelLimit, match="is within the travels in no position; move the part"):
        standards(away, HiddenMachine(1), {"as it lies": away.pose})
