"""Figures of recorded tests against numbers computed by hand: circles, diagonals, lengths; and on the command line."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.learn.calibration.drawn import TRAVEL, bare
from vcmm.core.errors import UsageError
from vcmm.core.run import Run
from vcmm.face.cli import run
from vcmm.files.own.recording_writer import save_recording
from vcmm.learn.calibration.deviations import RecordedTest
from vcmm.learn.calibration.spindle import limits_of
from vcmm.learn.calibration.standard_figures import evaluate_recordings
from vcmm.physics.structure.squareness import Squareness
from vcmm.task.instruments import find
from vcmm.task.instruments.ball_bar import circle
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.instruments.laying import join_layouts, layout, rows, simulate_reading
from vcmm.task.response.recording import Recording

CENTRE = (300.0, 250.0, -200.0)


def figures(recording, iso, certificate=None, limits=()):
    found, notes = evaluate_recordings([RecordedTest(recording, bare(), certificate)], iso, limits_of(limits))
    return {f.name: f for f in found}, notes


def ball_bar(start: float = 0.0) -> Recording:
    """Both senses of a circle of 150 mm every 5 degrees, with C0Y = 20 urad: r = -1.5 um sin 2a; the cup (3, -2) um off; 1 um
    between the senses; the bar 4 um long."""
    there = circle(bare(), CENTRE, 150.0, "XY", 1e-4, calibrated=True)
    back = circle(bare(), CENTRE, 150.0, "XY", 1e-4, sweep=(360.0 + start, start), calibrated=True)
    out = join_layouts("circle", [there, back])
    way = bare().prepare(out.run).tip
    angle = np.arctan2(way[:, 1] - 250.0, way[:, 0] - 300.0)
    radial = -1.5e-3 * np.sin(2 * angle) + 3e-3 * np.cos(angle) - 2e-3 * np.sin(angle) + 4e-3
    radial[72:] -= 1e-3
    labels = {"run": np.repeat(["1", "2"], 72)}
    return replace(out, run=replace(out.run, labels=labels), value=radial, measuring=False)


def test_a_recorded_circle_by_hand():
    # about the common centre: G = 3 um in each sense, H = 1 um; G(b) from 4 + 1.5 down to 3 - 1.5: 4 um; F max = 5.5 um, F min =
    # 1.5 um, D = 3.5 um; u of the bar's length 0.5 um shows in D and F alone
    bar = InstrumentCertificate.of(find("ball bar"), {"length": "0.5 um"})
    found, notes = figures(ball_bar(), "230-4", bar, ["G+ = 3.1 um", "F max = 5 um"])
    expected = {
        "G+ XY": 3,
        "G- XY": 3,
        "G(b) XY": 4,
        "D XY": 3.5,
        "F max XY": 5.5,
        "F min XY": 1.5,
        "H XY": 1,
    }
    assert {n: f.value_um for n, f in found.items()} == pytest.approx(expected, abs=1e-6)
    assert found["D XY"].u_um == pytest.approx(0.5, rel=0.05)
    assert found["G+ XY"].u_um == pytest.approx(0.0, abs=1e-9)
    assert found["G+ XY"].p_pass == 1.0
    assert found["F max XY"].p_pass == pytest.approx(0.159, abs=0.03)  # 0.5 um = 1 u above the limit
    assert notes == []


def test_a_circle_in_the_other_sense_is_compared_at_the_same_angles():
    # read 2.5 degrees beside: linear between readings 5 degrees apart, off by at most 1.5 um * (2 * 0.0873)^2 / 8 = 0.006 um
    found, _ = figures(ball_bar(2.5), "230-4")
    assert found["H XY"].value_um == pytest.approx(1.0, abs=0.015)
    assert found["G(b) XY"].value_um == pytest.approx(4.0, abs=0.02)
    assert found["H XY"].u_um is None


def test_a_bar_of_unknown_length_has_no_radial_deviation():
    one = replace(ball_bar(), nuisance={"centre": "", "radius": ""})
    found, notes = figures(one, "230-4")
    assert set(found) == {"G+ XY", "G- XY", "G(b) XY", "H XY"}
    assert "need a calibrated one" in notes[0]


def test_a_grid_plate_gives_the_same_circle():
    # x and y of a grid plate instead of the length: the same radial deviations
    bar = ball_bar()
    n = bar.run.n
    value = np.stack([bar.value * bar.direction[:, i] for i in range(2)], axis=1).ravel()
    plate = replace(
        bar, kind="displacement", value=value, row=np.repeat(np.arange(n), 2), direction=np.tile(np.eye(3)[:2], (n, 1)),
        other=np.full(2 * n, -1, dtype=np.intp), nuisance={"rigid": ""},
    )  # fmt: skip
    found, _ = figures(plate, "230-4")
    assert found["G(b) XY"].value_um == pytest.approx(4.0, abs=1e-6)
    with pytest.raises(UsageError, match="not read along the radius"):
        figures(plate.take(slice(0, None, 2)), "230-4")


def test_circles_that_are_none():
    bar = ball_bar()
    with pytest.raises(UsageError, match="0 readings were taken clockwise"):
        figures(bar.take(slice(0, 72)), "230-4")
    moved = replace(bar, run=replace(bar.run, position={**bar.run.position, "X": 0.5 * bar.run.q("X")}))
    with pytest.raises(UsageError, match="off the circle"):
        figures(moved, "230-4")
    angle = np.radians(np.r_[np.arange(0, 360, 5), np.arange(360, 0, -5)])
    turn = np.r_[np.ones(72), -np.ones(72)]
    senses = {
        "sense_X": np.sign(-np.sin(angle) * turn),
        "sense_Y": np.sign(np.round(np.cos(angle), 9) * turn),
    }
    assert figures(replace(bar, run=bar.run.with_columns(senses)), "230-4")[0]["H XY"].value_um > 0.9
    wrong = {k: -v for k, v in senses.items()}
    with pytest.raises(UsageError, match="labels of the directions are exchanged"):
        figures(replace(bar, run=bar.run.with_columns(wrong)), "230-4")


def diagonal(start, end, name="d", runs=2) -> Recording:
    """A laser along a line of the volume, there and back."""
    start, end = np.array(start, dtype=float), np.array(end, dtype=float)
    share = np.tile(np.r_[np.linspace(0, 1, 6), np.linspace(1, 0, 6)], runs)[:, None]
    points = start + share * (end - start)
    way = (end - start) / np.linalg.norm(end - start)
    run = rows({a: points[:, i] for i, a in enumerate("XYZ")}, np.zeros(3), {"setup": [name] * len(points)})
    turn = np.tile(np.repeat([1.0, -1.0], 6), runs)
    run = run.with_columns({f"sense_{a}": turn * s for a, s in zip("XYZ", np.sign(way))})
    return layout(name, "displacement", run, way, {"zero": "setup"}, 1e-9)


def square(recording: Recording) -> Recording:
    return simulate_reading(recording, bare().with_effect(Squareness("C0Y", 20e-6)), np.random.default_rng(0))


def test_recorded_diagonals_by_hand():
    # C0Y = 20 urad changes a length L by -c x y / L: 20e-6 * 600 * 500 / 877.5 = 6.838 um through the body, over XY 20e-6 * 600 *
    # 500 / 781.0 = 7.682 um; laser u(scale) = 1 um/m: u = 0.8775 um
    laser = InstrumentCertificate.of(find("laser linear"), {"scale": "1 um/m"})
    body = square(diagonal((0, 0, -400), (600, 500, 0), "one"))
    found, notes = figures(body, "230-6", laser, ["E PPP = 8 um"])
    assert found["E PPP"].value_um == pytest.approx(6.838, abs=1e-3)
    assert found["E PPP"].u_um == pytest.approx(0.8775, rel=0.05)
    assert found["Ed"].value_um == found["E PPP"].value_um
    assert found["B PPP"].value_um == pytest.approx(0.0, abs=1e-5)
    assert found["E PPP"].p_pass == pytest.approx(0.907, abs=0.03)  # (8 - 6.838) / 0.8775 = 1.324 u
    assert notes == ["ISO 230-6 takes four body diagonals; here: PPP"]
    face = square(diagonal((600, 0, -200), (0, 500, -200), "two"))
    found, _ = figures(face, "230-6")
    assert found["E PN0"].value_um == pytest.approx(7.682, abs=1e-3)
    assert "Ed" not in found
    both, _ = figures(join_layouts("both", [body, face]), "230-6")
    assert {"E PPP", "E PN0", "Ed", "Ef"} <= set(both)
    with pytest.raises(UsageError, match="beside a line"):
        figures(
            replace(
                join_layouts("both", [body, face]),
                run=replace(join_layouts("b", [body, face]).run, labels={}),
            ),
            "230-6",
        )


def test_diagonals_that_are_none():
    one = diagonal((0, 0, -400), (600, 500, 0))
    across = replace(one, direction=np.tile([0.0, 0.0, 1.0], (one.m, 1)))
    with pytest.raises(UsageError, match="not along the diagonal"):
        figures(across, "230-6")
    wrong = one.run.with_columns({"sense_Y": -one.run.column("sense_Y")})
    with pytest.raises(UsageError, match="labels up and down are exchanged"):
        figures(replace(one, run=wrong), "230-6")


def gauge(offset: float = 0.0) -> Recording:
    """Five lengths along X, each three times; indicated - true = -10 um/m L, and 0.5 um more in the second of every three."""
    length = np.repeat([100.0, 200.0, 300.0, 400.0, 500.0], 3)
    position = {
        "X": np.r_[length + 50.0, np.full(15, 50.0)],
        "Y": np.full(30, 250.0),
        "Z": np.full(30, -200.0),
    }
    start = {f"from_{c}_mm": np.full(30, v) for c, v in zip("xyz", (50.0, 250.0 + offset, -200.0))}
    run = Run(position, np.tile([0.0, offset, 0.0], (30, 1)), start)
    value = -1e-5 * length + np.tile([0.0, 0.5e-3, 0.0], 5)
    return Recording(
        "gauge",
        "length",
        run,
        value,
        True,
        np.arange(15),
        np.tile([1.0, 0.0, 0.0], (15, 1)),
        15 + np.arange(15),
    )


def test_recorded_lengths_by_hand():
    # E0: 5 um at 500 mm; R0 0.5 um. Limit 3 um + L/250: 5 um at 500 mm, reached exactly; u(scale) 1 um/m: half of the draws pass
    scale = InstrumentCertificate.of(find("step gauge"), {"scale": "1 um/m"})
    found, notes = figures(gauge(), "10360-2")
    assert {n: f.value_um for n, f in found.items()} == pytest.approx({"E0": 5.0, "R0": 0.5})
    assert len(notes) == 2
    assert "105" in notes[0]
    assert "takes 66% of the longest diagonal" in notes[1]
    found, _ = figures(gauge(), "10360-2", scale, ["E0 = 3.01 um + L/250"])
    assert found["E0"].limit_um == pytest.approx(5.01)
    assert found["E0"].u_um == pytest.approx(0.5, rel=0.05)
    assert found["E0"].p_pass == pytest.approx(0.508, abs=0.05)
    assert found["R0"].u_um == pytest.approx(0.0, abs=1e-9)
    assert set(figures(gauge(150.0), "10360-2")[0]) == {"E150"}
    with pytest.raises(UsageError, match="both ends on one artefact"):
        figures(ball_bar(), "10360-2")


def test_recorded_tests_on_the_command_line(tmp_path, capsys):
    """What is written is evaluated: the figures are those of the recordings in memory."""
    head = 'vcmm = "machine/1"\nstructure = "w b Y X Z t"\n'
    travels = "".join(f'[axes.{a}]\ntravel = ["{lo} mm", "{hi} mm"]\n' for a, (lo, hi) in TRAVEL.items())
    (tmp_path / "machine.toml").write_text(head + travels)
    save_recording(ball_bar(), tmp_path / "bar.toml")
    with (tmp_path / "bar.toml").open("a") as file:
        file.write('[instrument]\nname = "ball bar"\nu = { length = "0.5 um" }\n')
    for i, ends in enumerate((((0, 0, -400), (600, 500, 0)), ((0, 500, -400), (600, 0, 0)))):
        save_recording(square(diagonal(*ends, f"d{i}")), tmp_path / f"d{i}.toml")
    save_recording(gauge(), tmp_path / "gauge.toml")
    cases = {
        ("bar",): ("230-4", {"G(b) XY": 4.0, "H XY": 1.0}),
        ("d0", "d1"): ("230-6", {"E PPP": 6.838, "E PNP": 6.838, "Ed": 6.838}),
        ("gauge",): ("10360-2", {"E0": 5.0, "R0": 0.5}),
    }
    for names, (iso, expected) in cases.items():
        assert run(["test", *(str(tmp_path / f"{n}.toml") for n in names), "--iso", iso, "--json"]) == 0
        found = {f["name"]: f for f in json.loads(capsys.readouterr().out)["figures"]}
        assert {n: found[n]["value_um"] for n in expected} == pytest.approx(expected, abs=2e-3)
        of_lengths = (
            {"ratio", "u_ratio", "at_mm"} if iso == "10360-2" else set()
        )  # E/MPE grows or falls with the length
        keys = {"name", "value_um", "u_um", "limit_um", "p_pass"} | of_lengths
        assert set(found[next(iter(expected))]) == keys
    words = ["test", str(tmp_path / "bar.toml"), "--iso", "230-4", "--limit", "G(b) = 3.5 um"]
    assert run(words) == 1
    assert "G(b) XY" in capsys.readouterr().out
