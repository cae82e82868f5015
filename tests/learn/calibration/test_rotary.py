"""Rotary axes: drawn harmonics and location errors are recovered, written and read back; what a set-up does not tell is named."""

from __future__ import annotations

import json
from dataclasses import replace
from functools import lru_cache

import numpy as np
import pytest

from tests.learn.calibration.turning import (
    ANGLES,
    HEAD,
    TABLE,
    U,
    bare,
    draw,
    errors_of,
    recorded,
    set_ups,
    truth,
)
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.grid import node_weights
from vcmm.core.run import Run
from vcmm.face.cli import run
from vcmm.files.learned.calibrated_machine import machine_texts
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.files.own.recording_writer import save_recording
from vcmm.learn.calibration.checks import check_agreement
from vcmm.learn.calibration.job import calibrate, ranges_of, spans_of
from vcmm.learn.calibration.model import error_model
from vcmm.learn.calibration.readings import readings
from vcmm.learn.calibration.rotary import average_line
from vcmm.physics.structure.component import ComponentPolynomial
from vcmm.physics.structure.rotary import RotaryCyclic
from vcmm.physics.structure.squareness import RotaryLocation
from vcmm.task.instruments.laser import line
from vcmm.task.instruments.rotary import held_bar, hold_tip, index_axis, r_test
from vcmm.task.response.nuisance import nuisance_columns
from vcmm.task.response.observe import Observer


@lru_cache
def found_on(structure: str, axis: str):
    rng = np.random.default_rng(5)
    machine = draw(structure, axis, rng)
    read = recorded(machine, set_ups(bare(structure), axis), rng)
    return machine, read, calibrate(read, bare(structure), only=errors_of(axis))


@pytest.mark.parametrize(("structure", "axis"), [(TABLE, "C"), (HEAD, "B")])
def test_what_was_drawn_is_recovered_within_its_bands(structure, axis):
    machine, _, found = found_on(structure, axis)
    # a shift of a head's centre line is one with the place of the nest and the length of the tool: no reading tells it
    open_ = {f"{a}0{axis}" for a in "XZ"} if structure == HEAD else set()
    assert set(found.identified.names) == set(errors_of(axis)) - open_
    assert {n for c in found.identified.combinations for n in c.names} == open_
    scores = []
    for name in found.identified.names:
        nodes, value, u = found.band(name)
        if name[0] == "E":
            assert value[-1] == pytest.approx(value[0], abs=1e-9)  # once round is the same place
        scores.append((value - truth(machine, axis, nodes)[name]) / u)
        assert np.abs(scores[-1]).max() < 4.5, name
    pooled = np.concatenate(scores)
    assert (np.abs(pooled) < 1.96).mean() > 0.85
    assert 0.5 < np.sqrt((pooled**2).mean()) < 1.3


def test_harmonics_are_reported():
    # ECC as drawn: amplitude of the second harmonic is hypot(c2, s2)
    machine, _, found = found_on(TABLE, "C")
    row = next(f for f in found.figures() if f["error"] == "ECC")
    waves = next(e.coefficients for e in machine.effects if e.where == "ECC")
    second = row["harmonics"][1]
    assert second["order"] == 2
    assert abs(second["amplitude"] - np.hypot(*waves[2:4]) * 1e6) < 4 * second["u"]
    assert 0.05 < second["u"] < 1.0


def test_where_the_ball_of_an_r_test_stands():
    """About (10, -5): from the centre the ball is (200, 5), after a quarter turn of the table the other way (5, -200)."""
    place = hold_tip(
        bare(TABLE), "C", np.array([0.0, np.pi / 2]), (210.0, 0.0, 50.0), (0.0, 0.0, 0.0)
    ).position
    assert [place[a].round(9).tolist() for a in "XYZ"] == [[210.0, 15.0], [0.0, -205.0], [50.0, 50.0]]


def test_an_r_test_by_hand():
    # table C about (10, -5): X0C = 20 um moves the table by +20 um, the tip against it by -20 um; at C = 90 deg the table has turned by
    # -90 deg, so that the machine's -X is the workpiece's -Y (x machine = R(-q) x workpiece: workpiece = R(q) machine)
    machine = bare(TABLE).with_effect(RotaryLocation("X0C", offset=20e-3))
    one = replace(r_test(bare(TABLE), "C", np.radians([0.0, 90.0]), (110, -5, 0), U), nuisance={})
    assert one.run.q("X") == pytest.approx([110.0, 10.0])
    assert one.run.q("Y") == pytest.approx([-5.0, -105.0])
    read = -Observer(one, machine).baseline().reshape(2, 3)  # actual - commanded
    assert read == pytest.approx(np.array([[-20e-3, 0, 0], [0, -20e-3, 0]]), abs=1e-12)
    # ECC = 10 urad: table forward by 10 urad moves the tip back: at 100 mm from the centre -1 um in y of the workpiece
    turned = bare(TABLE).with_effect(RotaryCyclic("ECC", np.array([10e-6, 0.0])))
    read = -Observer(one, turned).baseline().reshape(2, 3)
    assert read[0] == pytest.approx([0, -1e-3, 0], abs=1e-12)
    angle = index_axis(bare(TABLE), "C", np.radians([0.0, 180.0]), 1e-7)
    assert np.abs(Observer(angle, turned).baseline()) == pytest.approx([10e-6, 10e-6])
    bar = held_bar(bare(TABLE), "C", np.radians([0.0, 90.0]), (110, -5, 0), (10, -5, 0), U)
    assert -Observer(replace(bar, nuisance={}), machine).baseline() == pytest.approx([-20e-3, 0.0], abs=1e-9)
    with pytest.raises(ModelLimit, match="cannot bring the tip there"):
        hold_tip(bare("w C' b X t"), "C", ANGLES, (110, -5, 0), (0, 0, 0))


def test_the_average_line_leaves_the_machine_as_it_is():
    """Any theta and what it is turned into move the tip the same way, at angles between the nodes too."""
    for structure, axis in ((TABLE, "C"), (HEAD, "B"), ("w A' b Y X Z t", "A")):
        machine = bare(structure)
        model = error_model({axis: (0.0, 2 * np.pi)}, 17)
        rng = np.random.default_rng(1)
        theta = np.concatenate([_smooth(c, rng) for c in model.curves] + [np.zeros(4)])
        where = Run(
            {a: np.full(5, 20.0) if a in "XYZ" else np.linspace(0.3, 6.0, 5) for a in machine.chain.letters},
            np.tile([30.0, 40.0, -100.0], (5, 1)),
        )
        moved = average_line(model, machine) @ theta
        assert np.abs(moved - theta).max() > 1e-4
        both = [machine.with_effect(*model.effects(t)) for t in (theta, moved)]
        first, second = (m.tip_error(m.prepare(where)) for m in both)
        assert np.abs(first).max() > 1e-3
        assert first == pytest.approx(second, abs=2e-6)  # mm, of 2 um: the spline of a cosine over 33 nodes


def _smooth(curve, rng) -> np.ndarray:
    """A wave of 1 and 2 per turn by the convention of the curve."""
    size = 1e-3 if not curve.turns else 1e-5
    waves = [f(k * curve.nodes) for k in ((2,) if curve.is_centred else (1, 2)) for f in (np.cos, np.sin)]
    return size * np.stack(waves, axis=1) @ rng.standard_normal(len(waves))


def test_a_periodic_spline_goes_round():
    nodes = np.linspace(0, 2 * np.pi, 17)
    weights = node_weights(nodes, np.array([-0.1, 2 * np.pi - 0.1, 7.0]), "periodic")
    assert weights @ np.cos(nodes) == pytest.approx(np.cos([-0.1, -0.1, 7.0]), abs=2e-4)


def test_one_ball_on_the_axis_does_not_tell_the_tilt():
    rng = np.random.default_rng(2)
    machine = draw(TABLE, "C", rng)
    one = r_test(bare(TABLE), "C", ANGLES, (10, -5, 200), U)
    found = calibrate(
        recorded(machine, [one], rng), bare(TABLE), only=["EZC", "ECC", *errors_of("C")[6:8], "A0C"]
    )
    assert "EZC" in found.identified.names
    told = {n: c.text for c in found.identified.combinations for n in c.names}
    assert "indexing table" in told["ECC"]


def test_rotary_errors_beside_known_linear_ones_on_the_command_line(tmp_path, capsys):
    """The machine file says where the axis is; what is written is read back and leaves the noise of the recordings."""
    _, read, _ = found_on(TABLE, "C")
    axes = "".join(f'[axes.{a}]\ntravel = ["-800 mm", "800 mm"]\n' for a in "XYZ")
    turn = '[axes.C]\ntravel = ["-360 deg", "360 deg"]\ncentre = ["10 mm", "-5 mm", "0 mm"]\n'
    (tmp_path / "bare.toml").write_text(f'vcmm = "machine/1"\nstructure = "{TABLE}"\n{axes}{turn}')
    files = []
    for one in read:
        save_recording(one, tmp_path / f"{one.name}.toml", "bare.toml")
        files.append(str(tmp_path / f"{one.name}.toml"))
    out = tmp_path / "machine.toml"
    words = ["--machine", str(tmp_path / "bare.toml"), "--errors", " ".join(errors_of("C"))]
    assert run(["calibrate", *files, *words, "--out", str(out), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert {f["error"] for f in document["identified"]} == set(errors_of("C"))
    assert document["not_identified"] == []
    again = load_machine(out)
    assert again.axes["C"].centre == (10.0, -5.0, 0.0)
    one, _ = load_recording(files[0], again)
    nuisance, _ = nuisance_columns(one, again)
    left = one.value - Observer(one, again).baseline()
    left -= nuisance @ np.linalg.lstsq(nuisance, left, rcond=None)[0]
    stated = next(r for r in document["residuals"] if r["recording"] == read[0].name)
    assert np.sqrt((left**2).mean()) * 1e3 == pytest.approx(stated["rms"], rel=0.02)
    # one that only places C in its table is not made anew without it
    placed = (tmp_path / "bare.toml").read_text() + '[errors]\ntable = "errors.csv"\n'
    (tmp_path / "placed.toml").write_text(placed)
    (tmp_path / "errors.csv").write_text("X EXX\n-800 0\n0 0\n800 0\n#\nX0C\n0.01\n")
    one = line(bare(TABLE), "X", np.linspace(0, 300, 4), {"Y": 0.0, "Z": 0.0, "C": 0.0}, np.zeros(3), "X", U)
    save_recording(one, tmp_path / "line.toml", "placed.toml")
    words = [str(tmp_path / "line.toml"), "--machine", str(tmp_path / "placed.toml"), "--errors", "EXX"]
    assert run(["calibrate", *words, "--out", str(tmp_path / "new.toml")]) == 2
    assert "the error table states X0C" in capsys.readouterr().err


def stored(found, folder, prior=None):
    for name, text in machine_texts(found, folder / "machine.toml", ["r"], prior).items():
        (folder / name).write_text(text)
    return load_machine(folder / "machine.toml")


def test_a_file_with_rotary_errors_is_recalibrated(tmp_path):
    """Errors of C, and a lost motion of C beside them. X read again: C stays to the last digit. Then one R-test after C was moved by
    8 um in X: the location follows, and what nobody says has changed is only known better.
    """
    _, _, found = found_on(TABLE, "C")
    first = stored(found, tmp_path)
    lost = '\n[[effects]]\neffect = "backlash"\naxis = "C"\ngap = "5 urad"\n'
    (tmp_path / "machine.toml").write_text((tmp_path / "machine.toml").read_text() + lost)
    known = load_machine(tmp_path / "machine.toml")
    rng = np.random.default_rng(8)
    stretched = known.with_effect(ComponentPolynomial("EXX", np.array([0.0, 10e-3])))
    place = line(known, "X", np.linspace(0, 300, 7), {"Y": 0.0, "Z": 0.0, "C": 0.0}, np.zeros(3), "X", 0.1e-3)
    (tmp_path / "second").mkdir()
    linear = calibrate(recorded(stretched, [place], rng), known, only=["EXX"])
    second = stored(linear, tmp_path / "second", tmp_path / "machine.toml")
    assert "EXX" in linear.identified.names
    for name in errors_of("C"):
        (nodes, value, u), (again, same, later) = found.band(name), linear.band(name)
        assert again == pytest.approx(nodes, abs=1e-9, nan_ok=True)
        assert same == pytest.approx(value, abs=1e-9 + 1e-6 * np.abs(value).max())
        assert later == pytest.approx(u, rel=1e-3)
    assert (
        [e.name for e in second.effects if e.where == "C"]
        == [e.name for e in known.effects if e.where == "C"]
        != []
    )
    turn = np.linspace(-np.pi, np.pi, 9)
    middle = {
        a: np.full(9, 150.0 if a == "X" else 0.0) for a in "XYZ"
    }  # where EXX is nothing, by its convention
    at = Run(middle | {"C": turn}, np.full((9, 3), 50.0), {"sense_C": np.ones(9)})
    assert second.tip_error(at) == pytest.approx(known.tip_error(at), abs=0.1e-3)
    moved = known.with_effect(RotaryLocation("X0C", offset=8e-3))
    test = set_ups(bare(TABLE), "C")[0]
    third = calibrate(recorded(moved, [test], rng), known, only=["X0C", "Y0C"])
    was, now = found.band("X0C"), third.band("X0C")
    assert now[1][0] - was[1][0] == pytest.approx(8e-3, abs=4 * np.hypot(now[2][0], was[2][0]))
    assert now[2][0] < 1e-3
    for name in ("ECC", "EAC", "EZC"):
        _, before, u = found.band(name)
        assert np.all(np.abs(third.band(name)[1] - before) < u)  # read again, and better known: not changed
        assert np.all(third.band(name)[2] < 1.001 * u)
    assert first.axes["C"] == known.axes["C"]


def test_errors_in_a_frame_that_stands_still_are_not_taken_over(tmp_path):
    _, read, found = found_on(TABLE, "C")
    stored(found, tmp_path)
    text = (
        (tmp_path / "machine.toml")
        .read_text()
        .replace('centre = ["10', 'error_frame = "fixed"\ncentre = ["10')
    )
    assert "error_frame" in text
    (tmp_path / "machine.toml").write_text(text)
    with pytest.raises(ModelLimit, match='error_frame = "fixed", which a recalibration cannot take'):
        calibrate(read, load_machine(tmp_path / "machine.toml"))


@pytest.mark.thorough
def test_known_linear_errors_stay_and_their_uncertainty_counts(tmp_path):
    """EXX = 10 um/m, known to 0.5 um, beside the errors of C: the location keeps its truth and becomes less certain by EXX."""
    machine, _, alone = found_on(TABLE, "C")
    rng = np.random.default_rng(5)
    axes = "".join(f'[axes.{a}]\ntravel = ["-800 mm", "800 mm"]\n' for a in "XYZ")
    turn = '[axes.C]\ntravel = ["-360 deg", "360 deg"]\ncentre = ["10 mm", "-5 mm", "0 mm"]\n'
    nodes = np.linspace(-800, 800, 9)
    (tmp_path / "errors.csv").write_text("X EXX\n" + "".join(f"{q:g} {1e-5 * q:.10g}\n" for q in nodes))
    (tmp_path / "m.toml").write_text(
        f'vcmm = "machine/1"\nstructure = "{TABLE}"\n{axes}{turn}[errors]\ntable = "errors.csv"\n'
        '[errors.uncertainty]\ntranslation = "0.5 um"\ncorrelation_length = "400 mm"\n'
    )
    known = load_machine(tmp_path / "m.toml")
    stretched = machine.with_effect(ComponentPolynomial("EXX", np.array([0.0, 1e-2])))
    found = calibrate(recorded(stretched, set_ups(bare(TABLE), "C"), rng), known, only=errors_of("C"))
    assert set(errors_of("C")) <= set(found.kept_model.names)
    assert "EXX" in found.kept_model.names
    for name in ("X0C", "Y0C", "EYC", "ECC"):
        at, value, u = found.band(name)
        assert np.abs((value - truth(machine, "C", at)[name]) / u).max() < 4.5
    assert found.band("X0C")[2][0] > 1.5 * alone.band("X0C")[2][0]


def test_three_ball_bars_tell_the_location():
    """Radial, tangential and axial bars (ISO 10791-6) beside known error curves: X0C = 15 um, B0C = 30 urad, within 4 u."""
    rng = np.random.default_rng(4)
    truth_ = [RotaryLocation("X0C", offset=15e-3), RotaryLocation("B0C", tilt=30e-6)]
    machine = bare(TABLE).with_effect(*truth_)
    ball, cups = (210.0, -5.0, 100.0), ((60.0, -5.0, 100.0), (210.0, 145.0, 100.0), (210.0, -5.0, -50.0))
    bars = [
        replace(held_bar(bare(TABLE), "C", ANGLES, ball, cup, U), name=f"bar {i}")
        for i, cup in enumerate(cups)
    ]
    names = ("X0C", "Y0C", "A0C", "B0C")
    # at one height, without the axial bar, a shift is a tilt times the height: neither is told
    with pytest.raises(UsageError, match="X0C, B0C: cannot be told apart"):
        calibrate(recorded(machine, bars[:2], rng), bare(TABLE), only=names)
    found = calibrate(recorded(machine, bars, rng), bare(TABLE), only=names)
    assert set(found.identified.names) == set(names)
    for name, true in zip(names, (15e-3, 0.0, 0.0, 30e-6)):
        _, value, u = found.band(name)
        assert abs(value[0] - true) < 4 * u[0], name


def test_an_r_test_near_zero_contradicts_nothing():
    """Scatter of 0.2 um about no error at all agrees with any factor; an R-test reads um, never arcsec."""
    machine, rng = bare(TABLE), np.random.default_rng(0)
    read = recorded(machine, set_ups(machine, "C"), rng)
    model = error_model(ranges_of(spans_of(read), machine), 5)
    parts = [readings(r, machine, model) for r in read]
    check_agreement(parts, model)
    turned = replace(parts[0], value=-parts[0].value - 0.1 * parts[0].errors[:, -4])  # X0C = 0.1 mm
    shifted = [replace(p, value=p.value + 0.1 * p.errors[:, -4]) for p in parts[1:]]
    with pytest.raises(UsageError, match=r"R-test 1 contradicts.*times -1; its sign"):
        check_agreement([turned, *shifted], model)
