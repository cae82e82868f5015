"""Interpolations: kernels by hand, the file is what was fitted, held-out readings against the joint normal law."""

from __future__ import annotations

import json
from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.learn.calibration.drawn import STRUCTURE, bare, draw, laser_and_plates, recorded, tracers
from vcmm.core.errors import UsageError
from vcmm.face.cli import run
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording_writer import save_recording
from vcmm.learn.calibration.cross_validation import compare_interpolations, held_rows, predict_rows
from vcmm.learn.calibration.interpolation import (
    INTERPOLATIONS,
    as_kind,
    interpolation_of,
    read_positions,
    swings,
)
from vcmm.learn.calibration.job import calibrate
from vcmm.learn.calibration.model import Curve, ErrorModel
from vcmm.learn.calibration.prior import KERNELS, unit_factor
from vcmm.learn.calibration.readings import readings
from vcmm.task.response.observe import Observer


@pytest.fixture(scope="module")
def line():
    """The laser linear of X on a drawn machine."""
    rng = np.random.default_rng(11)
    machine = draw(rng)
    return machine, recorded(machine, laser_and_plates(bare())[:1], rng)


def test_kernels_by_hand():
    """Matern 5/2 one length apart: (1 + 2.236068 + 1.666667) exp(-2.236068) = 0.523994. Legendre of degree 2 at -1, 0, 1:
    1 + 3 x x' + 5 P2 P2' is 9 and 3 at the end with itself and the other end, 2.25 in the middle."""
    curve = Curve("EXX", np.array([0.0, 50.0, 100.0]))
    assert KERNELS["gaussian process"](curve, 50.0)[0, 1] == pytest.approx(0.523994, abs=1e-6)
    power = KERNELS["polynomial"](curve, 100.0)
    assert (power[0, 0], power[0, 2], power[1, 1]) == pytest.approx((9.0, 3.0, 2.25))
    assert KERNELS["table"](curve, 1.0) == pytest.approx(np.eye(3))


def test_a_straightness_of_degree_two_is_a_parabola():
    """Without its line nothing but P2 is left of a polynomial of degree 2; what a millionth of the variance adds is no shape."""
    nodes = np.linspace(0.0, 100.0, 9)
    curve = Curve("EYX", nodes, kind="polynomial")
    size, ways = np.linalg.eigh(
        curve.free @ unit_factor(curve, 100.0) @ unit_factor(curve, 100.0).T @ curve.free.T
    )
    parabola = curve.projector @ (nodes - 50.0) ** 2
    assert abs(ways[:, -1] @ parabola) / np.linalg.norm(parabola) == pytest.approx(1.0, abs=1e-6)
    assert size[-2] < 1e-5 * size[-1]


def test_a_table_stands_where_lines_were_read(line):
    curve = Curve("EXX", np.linspace(0.0, 600.0, 33))
    assert read_positions(line[1], curve) == pytest.approx(np.linspace(0.0, 600.0, 13))
    (kept,) = as_kind(ErrorModel((curve,), ()), "table", line[1]).curves
    assert (kept.kind, len(kept.nodes)) == ("table", 13)


@pytest.mark.thorough
@pytest.mark.parametrize("name", INTERPOLATIONS[:5])
def test_every_interpolation_finds_the_curve_and_the_file_is_what_was_fitted(line, name, tmp_path, capsys):
    """Read back, the file leaves the residuals of the document; the curve is what was read (a small net may miss half)."""
    (one,) = line[1]
    save_recording(one, tmp_path / "line.toml", "unused.toml")
    out = tmp_path / "machine.toml"
    words = ["calibrate", str(tmp_path / "line.toml"), "--structure", STRUCTURE, "--errors", "EXX"]
    assert run([*words, "--interpolation", name, "--out", str(out), "--json"]) == 0
    document = json.loads(capsys.readouterr().out)
    assert document["interpolation"] == name
    again = load_machine(out)
    left = one.value - Observer(one, again).baseline()
    left -= left.mean()
    assert np.sqrt((left**2).mean()) * 1e3 == pytest.approx(document["residual_um"], rel=2e-3)
    (stored,) = (e for e in again.effects if e.about.is_calibrated)
    assert ("linear" if name == "table" else "cubic") in out.read_text()
    nodes, value = stored.own_nodes(), np.asarray(stored.values)
    at = one.run.q("X")[one.row]
    read = one.value - one.value.mean()
    away = np.interp(at, nodes, value) * one.sign - read
    assert rms(away - away.mean()) < (0.5 if name.startswith("i-") else 0.15) * rms(read)


def rms(values):
    return float(np.sqrt((values**2).mean()))


def test_held_rows_are_inside_and_other_recordings_stay_whole(line):
    one = line[1][0]
    assert np.unique(one.run.q("X")[one.row][held_rows(one)]) == pytest.approx([100.0, 250.0, 400.0, 550.0])
    rng = np.random.default_rng(0)
    plate = recorded(line[0], laser_and_plates(bare())[18:19], rng)[0]
    assert not held_rows(plate).any()
    lengths = recorded(line[0], tracers(bare(), step=3)[:1], rng)[0]
    again = replace(lengths.take(np.tile(np.arange(27), 2)), name="twice")
    held = held_rows(again)
    assert held.sum() == 18  # nine of 27 places, each with all of its readings
    assert held[:27].tolist() == held[27:].tolist()
    for axis in "XYZ":  # and no plane of the grid is lost
        assert len(np.unique(again.run.q(axis)[again.row][~held])) == 3


def test_a_polynomial_that_swings_is_named_with_its_place():
    # u = 0.3 and 0.4 urad: 0.5 urad together; 2 urad apart at 300 mm are 4 of these, 1.4 urad are 2.8
    curve = Curve("EAX", np.linspace(0.0, 600.0, 3), kind="polynomial")
    model = ErrorModel((curve,), ())

    def post(middle, u):
        return SimpleNamespace(model=model, theta=np.array([0, middle, 0.0]), covariance=u**2 * np.eye(3))

    (said,) = swings(post(2e-6, 0.3e-6), post(0.0, 0.4e-6))
    assert "EAX: polynomial and spline differ by 2 urad at X = 300 mm, 4 times" in said
    assert swings(post(1.4e-6, 0.3e-6), post(0.0, 0.4e-6)) == []


def test_the_prediction_is_that_of_the_joint_normal_law(line):
    """Readings held out given those kept: theta of a known normal law, a zero of 0.1 mm, by one big inverse."""
    one = line[1][0]
    model = ErrorModel((Curve("EXX", np.linspace(0.0, 600.0, 5)),), ())
    part = readings(one, bare(), model)
    rng = np.random.default_rng(2)
    root = rng.standard_normal((5, 5)) * 2e-3
    before, held = root @ root.T, held_rows(one)
    joint = part.errors @ before @ part.errors.T + 1e-2 * part.nuisance @ part.nuisance.T + np.diag(part.u**2)
    gain = joint[np.ix_(held, ~held)] @ np.linalg.inv(joint[np.ix_(~held, ~held)])
    mean, spread = (
        gain @ part.value[~held],
        joint[np.ix_(held, held)] - gain @ joint[np.ix_(~held, held)],
    )
    kept = np.linalg.inv(
        part.errors[~held] @ before @ part.errors[~held].T
        + 1e-2 * part.nuisance[~held] @ part.nuisance[~held].T
        + np.diag(part.u[~held] ** 2)
    )
    lever = before @ part.errors[~held].T @ kept
    post = SimpleNamespace(
        theta=lever @ part.value[~held],
        covariance=before - lever @ part.errors[~held] @ before,
        noise=(SimpleNamespace(u=1.0),),
    )
    found = predict_rows(SimpleNamespace(posterior=post), 0, part, held)
    assert part.value[held] - found.error == pytest.approx(mean, abs=1e-6)
    assert found.u == pytest.approx(np.sqrt(np.diag(spread)), rel=1e-4)


def test_splines_predict_what_was_held_out_within_their_band(line):
    spline, table = compare_interpolations(line[1], bare(), only=("EXX",), names=("spline", "table"))
    assert spline.n == table.n == 8  # 4 places, both ways
    assert spline.rms_um < 0.6
    assert spline.inside >= 0.75
    assert spline.rms_urad is None


@pytest.mark.parametrize(
    ("words", "message"),
    [
        (["--structure", STRUCTURE, "--interpolation", "spine"], 'Did you mean "spline"'),
        (["--structure", STRUCTURE, "--compare-interpolations", "--out", "m.toml"], "writes no machine file"),
    ],
)
def test_wrong_words(line, words, message, tmp_path, capsys):
    save_recording(line[1][0], tmp_path / "line.toml", "unused.toml")
    assert run(["calibrate", str(tmp_path / "line.toml"), *words]) == 2
    out, err = capsys.readouterr()
    assert out == ""
    assert message in err


def test_nothing_to_hold_out_and_tables_known_before_are_refused(line):
    machine, (one,) = line
    with pytest.raises(UsageError, match="6 positions or more"):
        compare_interpolations([one.take(np.arange(5))], bare())
    with pytest.raises(UsageError, match="leave --interpolation out"):
        calibrate([one], machine, interpolation="table")


def test_names_are_found_however_they_are_written():
    assert [interpolation_of(w) for w in ("GP", "gaussian-process", "net", "Splines")] == [
        "gaussian process", "gaussian process", "i-(2i+1)-o", "spline",
    ]  # fmt: skip


def test_readings_without_noise_are_not_taken_for_endlessly_good(line):
    """A noise that nobody stated collapses where a curve runs through every reading; a thousandth of the readings is left of it."""
    (one,) = line[1]
    exact = replace(one, noise=None, value=1e-3 * np.sin(one.run.q("X")[one.row] / 200.0))
    found = calibrate([exact], bare(), only=("EXX",))
    (noise,) = found.posterior.noise
    (part,) = found.readings
    assert noise.scale * part.u[0] == pytest.approx(1e-3 * rms(part.value))
    assert np.isfinite(found.covariance).all()
