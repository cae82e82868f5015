"""The exam's own kinematics, plays, contacts and strengths, against numbers made by hand and the reference chains."""

from __future__ import annotations

import csv
import json
import tomllib
from dataclasses import replace

import numpy as np
import pytest

from benchmarks.exam import blocks, machines
from benchmarks.exam.concealed_axis import play
from benchmarks.exam.concealed_heat import lagged
from benchmarks.exam.concealed_readings import index_change
from benchmarks.exam.design import Design, since_reversal
from benchmarks.exam.kinema import Chain, Errors, tip_error, turn
from benchmarks.exam.machines import BRIDGE
from benchmarks.exam.observe import Hidden, join, observed
from benchmarks.exam.strength import amplitude_for, whitener
from tests.conftest import data_file


def _design(**more) -> Design:
    row = {"q": {a: np.array([v]) for a, v in zip("XYZ", (100.0, 200.0, -300.0))}}
    row |= {"offset": np.array([[0.0, 0.0, -100.0]]), "normal": np.array([[1.0, 0.0, 0.0]])}
    return Design("one", BRIDGE, "probe", "indicated - true", **(row | more))


def test_squareness_turns_the_travel_of_the_second_axis() -> None:
    # C0Y = 10 urad at Y = 200 mm: the tip goes by -10e-6 * 200 = -2 um in x (second order: 1e-8 mm)
    d = _design()
    found = tip_error(BRIDGE.chain, d.q, d.offset, Errors(square={"C0Y": 1e-5}))
    assert found[0] == pytest.approx([-2e-3, 0.0, 0.0], abs=2e-8)


def test_location_of_a_table_moves_the_tip_the_other_way() -> None:
    chain = Chain("w C' X' Y' b Z t")
    q = {a: np.zeros(1) for a in "XYZC"}
    six = np.array([[0.005, 0, 0, 0, 0, 0]])
    assert tip_error(chain, q, np.zeros((1, 3)), Errors(place={"C": six}))[0] == pytest.approx(
        [-0.005, 0, 0], abs=1e-12
    )


def test_turn_by_a_right_angle() -> None:
    assert turn(np.array([[0.0, 0.0, np.pi / 2]]))[0] @ [1.0, 0.0, 0.0] == pytest.approx(
        [0.0, 1.0, 0.0], abs=1e-12
    )


def test_an_axis_beyond_its_target_is_indicated_smaller() -> None:
    # + 2 um of X, measured along + x: indicated - true = - 2 um; a path reports actual - commanded = + 2 um
    d = _design()
    motion = tip_error(BRIDGE.chain, d.q, d.offset, Errors(actual={"X": np.array([2e-3])}))
    assert observed(d, motion, Hidden()) == pytest.approx([-2e-3])
    assert observed(replace(d, observed="actual - commanded"), motion, Hidden()) == pytest.approx([2e-3])


def test_ball_is_met_a_little_past_the_normal() -> None:
    # a tip 10 um beside the normal of a ball with R + r = 12.5 mm: sag 0.01^2 / (2 * 12.5) = 4 nm; error = -sag
    d = _design(hidden={"ball_radius": np.array([12.5])})
    assert observed(d, np.array([[0.0, 0.01, 0.0]]), Hidden()) == pytest.approx([-4e-6], rel=1e-6)


def test_carriage_is_dragged_half_the_gap_behind() -> None:
    # X goes 0 -> 10 -> 9.999 -> 5 with a play of 4 um: -2 um, then -1 um (held), then +2 um
    path = np.zeros((4, 3))
    path[:, 0] = [0.0, 10.0, 9.999, 5.0]
    d = _design(nodes=path, row_node=np.array([1, 2, 3]))
    assert play(d, "X", 4e-3) == pytest.approx([-2e-3, -1e-3, 2e-3])
    sense, since = since_reversal(path)
    assert sense[:, 0].tolist() == [1, 1, -1, -1]
    assert since[:, 0] == pytest.approx([0.0, 10.0, 0.001, 5.0])


def test_lag_filter_reaches_63_percent_after_one_time_constant() -> None:
    t = np.arange(0.0, 601.0, 1.0)
    step = np.where(t > 0, 1.0, 0.0)
    assert lagged(t, step, 300.0, 0.0)[300] == pytest.approx(1 - np.exp(-1), abs=2e-3)


@pytest.mark.parametrize(("warmer", "higher", "ppm"), [(1.0, 0.0, -0.93), (0.0, 1.0, 0.268)])
def test_air_index_per_kelvin_and_hectopascal(warmer: float, higher: float, ppm: float) -> None:
    # 271.76e-6 / 293.15 K = 0.927 ppm/K; 271.76e-6 / 1013.25 hPa = 0.268 ppm/hPa
    air = {"temp_air_C": 20.0 + warmer, "pressure_hPa": 1013.25 + higher, "humidity_pct": 50.0}
    there = index_change(_design(columns={k: np.array([v]) for k, v in air.items()}))
    assert there[0] * 1e6 == pytest.approx(ppm, abs=0.05)


def test_delta_of_plain_noise_is_root_n_over_sigma() -> None:
    # nine rows, no nuisance, no calibration: 1 um everywhere over 0.7 um * sqrt(6/4) = 3 / 0.8573
    d = _design(
        q={a: np.full(9, v) for a, v in zip("XYZ", (100.0, 200.0, -300.0))},
        offset=np.tile([0.0, 0.0, -100.0], (9, 1)),
        normal=np.tile([1.0, 0.0, 0.0], (9, 1)),
    )
    assert whitener(d, calibration=False).delta(np.full(9, 1e-3)) == pytest.approx(3 / (0.7 * np.sqrt(1.5)))
    assert amplitude_for(7.0, lambda a: 2 * a) == pytest.approx(3.5)
    with pytest.raises(ValueError, match="cannot see"):
        amplitude_for(7.0, lambda a: 0.0)


def test_effects_are_added() -> None:
    both = join(
        [
            Hidden(shift=np.array([[1.0, 0, 0]])),
            Hidden(shift=np.array([[0, 2.0, 0]]), reading=np.array([3.0])),
        ]
    )
    assert both.shift.tolist() == [[1.0, 2.0, 0.0]]
    assert np.asarray(both.reading).tolist() == [3.0]


@pytest.mark.parametrize("number", range(0, len(blocks.RICH), 13))
def test_concealed_effects_have_the_strength_asked_for(number: int, tmp_path) -> None:
    case = blocks.build("A", 3, number, tmp_path, delta=7.0, rows=200)
    assert case.truth.deltas[0] == pytest.approx(7.0, rel=0.01)
    again = blocks.build("A", 3, number, tmp_path, delta=7.0, rows=200)
    assert (case.values == again.values).all()


def test_a_null_is_white_once_whitened(tmp_path) -> None:
    # m whitened values, p free: chi-square / m near 1 (three cases together: 1 +- 0.12 with t tails)
    seen = []
    for number in (0, 16, 40):
        case = blocks.build("B", 3, number, tmp_path)
        d, m = case.design, case.machine
        six = {a: m.stored(a, d.q[a]) for a in m.kind.linear}
        from benchmarks.exam.observe import tip_motion

        white = case.white.apply(case.values - observed(d, tip_motion(d, Errors(six, m.square)), Hidden()))
        seen.append(white @ white / (len(white) - case.white.basis.shape[1]))
    assert np.mean(seen) == pytest.approx(1.0, abs=0.15)


def test_machine_tables_are_written_as_they_are(tmp_path) -> None:
    m = machines.draw(BRIDGE, np.random.default_rng(1))
    machines.write(m, tmp_path)
    first = (tmp_path / "errors.csv").read_text().split("\n#\n")[0].splitlines()
    assert first[1] == "X EXX EYX EZX EAX EBX ECX"
    assert float(first[3].split()[1]) == pytest.approx(m.table["X"][1, 0], abs=1e-11)


def _tables(text: str) -> list[tuple[list[str], np.ndarray]]:
    out = []
    for block in text.split("#"):
        lines = [line for line in block.splitlines() if line.strip() and not line.startswith("//")]
        if lines:
            out.append(
                (
                    lines[0].replace(",", " ").split(),
                    np.array([[float(v) for v in r.replace(",", " ").split()] for r in lines[1:]]),
                )
            )
    return out


def _reference_cases() -> list[str]:
    try:
        return [c["name"] for c in json.loads(data_file("reference/kinematics.json").read_text())["cases"]]
    except (pytest.skip.Exception, OSError):
        return ["(absent)"]


@pytest.mark.parametrize("name", _reference_cases())
def test_exact_chain_agrees_with_the_reference(name: str) -> None:
    path = data_file("reference/kinematics.json")
    case = next(c for c in json.loads(path.read_text())["cases"] if c["name"] == name)
    machine = tomllib.loads((path.parent / case["machine"]).read_text())
    rows = list(csv.DictReader((path.parent / case["positions"]).read_text().splitlines()))
    if any(a.get("error_frame") == "fixed" for a in machine["axes"].values()) or machine.get("effects"):
        pytest.skip("the exam has no fixed error frames and no effects in its machine files")
    points = {
        w: {a: tuple(float(v.split()[0]) for v in t[w]) for a, t in machine["axes"].items() if w in t}
        for w in ("centre", "measured_at")
    }
    letters = list(machine["axes"])
    q = {
        a: np.array([np.radians(float(r[f"{a}_deg"])) if a in "ABC" else float(r[f"{a}_mm"]) for r in rows])
        for a in letters
    }
    offset = np.array([[float(r.get(f"offset_{c}_mm") or 0) for c in "xyz"] for r in rows])
    six = {a: np.zeros((len(rows), 6)) for a in letters}
    square, place = {}, {a: np.zeros((len(rows), 6)) for a in letters}
    for head, values in _tables(
        (path.parent / case["machine"]).with_name(machine["errors"]["table"]).read_text()
    ):
        arguments = [w for w in head if w in letters]
        if len(arguments) > 1:
            pytest.skip("the exam has no grids")
        for k, word in enumerate(head):
            if word in letters:
                continue
            i = (
                ("EX", "EY", "EZ", "EA", "EB", "EC").index(word[:2])
                if word[0] == "E"
                else "XYZABC".index(word[0])
            )
            if arguments:
                six[word[2]][:, i] = np.interp(q[arguments[0]], values[:, 0], values[:, k])
            elif word[2] in "ABC":
                place[word[2]][:, i] = values[0, k]
            else:
                square[word] = values[0, k]
    chain = Chain(case["structure"], points["centre"], points["measured_at"])
    place = {a: p for a, p in place.items() if a in "ABC"}
    assert tip_error(chain, q, offset, Errors(six, square, place)) == pytest.approx(
        np.array(case["tip_error_mm"]), abs=1e-9
    )
