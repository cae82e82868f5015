"""What is handed over: the refit of what is written, its rms read back, order of rows, exact aliases, stated quantities."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.core.run import Run
from vcmm.face.cli import run
from vcmm.learn.diagnosis.delivery import residual_after_terms, rms_after_terms
from vcmm.learn.diagnosis.engine import diagnose_recording
from vcmm.learn.diagnosis.row_order import sort_rows
from vcmm.physics.structure.squareness import Squareness
from vcmm.task.response.recording import Recording

UM = 1e-3


def positioning(gap: float, noise: float, slope: float = 0.0) -> Recording:
    """ISO 230-2 of X: five targets, five runs each way, actual - target; the gap is lost on reversal."""
    rng = np.random.default_rng(5)
    targets = np.array([15.0, 25.0, 35.0, 45.0, 55.0])
    q, sense = [], []
    for _ in range(5):
        q += [*targets, *targets[::-1]]
        sense += [1.0] * 5 + [-1.0] * 5
    x, d = np.array(q), np.array(sense)
    value = -0.5 * gap * d + slope * x + noise * rng.standard_normal(len(x))
    still = {"Y": np.zeros(len(x)), "Z": np.zeros(len(x))}
    table = Run({"X": x, **still}, np.zeros((len(x), 3)), {"sense_X": d}, {})
    ones = np.tile([1.0, 0.0, 0.0], (len(x), 1))
    return Recording(
        "runs", "displacement", table, value, False, np.arange(len(x)), ones, np.full(len(x), -1),
        u=np.full(len(x), noise), nuisance={"zero": ""},
    )  # fmt: skip


def shuffled(recording: Recording) -> Recording:
    order = np.random.default_rng(9).permutation(recording.run.n)
    turned = recording.take(order)
    return replace(turned, run=recording.run.take(order), row=np.arange(recording.run.n))


def test_a_reversal_is_no_correlation_of_the_noise():
    """Play of 1.9 um in a scatter of 0.02 um is a square wave over the rows: u = 2 x 0.02 / sqrt(50) = 0.006 um."""
    found = diagnose_recording(positioning(1.9 * UM, 0.02 * UM), make.machine(), 1, 400)
    (answer,) = found.answer
    assert (answer.effect, answer.where) == ("backlash", {"axis": "X"})
    gap = answer.parameters["gap"]
    assert gap.value == pytest.approx(1.9, abs=0.02)
    assert 0.004 < gap.u < 0.009
    assert found.fit.after < 0.03 * UM
    assert not any("correlated" in text for text in found.noise_findings)


def test_the_order_of_the_rows_does_not_matter_where_nothing_tells_the_time():
    recording = positioning(1.9 * UM, 0.1 * UM, slope=20e-6)
    one, two = (diagnose_recording(r, make.machine(), 1, 400) for r in (recording, shuffled(recording)))
    assert [a.id for a in one.answer] == [a.id for a in two.answer]
    assert {a.effect for a in one.answer} >= {"backlash"}
    for a, b in zip(one.answer, two.answer):
        for name, estimate in a.parameters.items():
            assert b.parameters[name].value == pytest.approx(estimate.value, rel=1e-6)
    assert one.fit.after == pytest.approx(two.fit.after, rel=1e-9)


def test_rows_stand_in_one_order_whatever_the_order_of_the_file():
    recording = positioning(1.9 * UM, 0.1 * UM)
    one, two = (sort_rows(r, make.machine()) for r in (recording, shuffled(recording)))
    assert np.array_equal(one.value, two.value)
    assert np.array_equal(one.run.position["X"], two.run.position["X"])
    assert sorted(one.value) == sorted(recording.value)


def diagonal() -> Recording:
    """A step gauge along one diagonal of X and Y, up and down six times; Y loses 3 um on reversal."""
    rng = np.random.default_rng(2)
    way = np.arange(0.0, 420.0, 20.0)
    s = np.concatenate([np.r_[way, way[::-1]] for _ in range(6)])
    d = np.tile(np.repeat([1.0, -1.0], len(way)), 6)
    n = np.array([0.6, 0.8, 0.0])
    position = {"X": 100.0 + 0.6 * s, "Y": 100.0 + 0.8 * s, "Z": np.zeros(len(s))}
    columns = {
        "sense_X": d,
        "sense_Y": d,
        "nx": np.full(len(s), 0.6),
        "ny": np.full(len(s), 0.8),
        "nz": 0.0 * s,
    }
    value = 0.8 * (0.5 * 3.0 * UM * d) + 0.3 * UM * rng.standard_normal(len(s))  # indicated - true: + 1/2 gap
    return Recording(
        "diagonal", "displacement", Run(position, np.zeros((len(s), 3)), columns, {}), value, True, np.arange(len(s)),
        np.tile(n, (len(s), 1)), np.full(len(s), -1), u=np.full(len(s), 0.3 * UM), nuisance={"zero": ""},
    )  # fmt: skip


def test_exact_aliases_share_the_probability_and_a_run_along_one_axis_tells():
    """Along (0.6, 0.8) a play of 3 um of Y is one of 3 x 0.8 / 0.6 = 4 um of X."""
    found = diagnose_recording(diagonal(), make.machine(), 1, 400)
    play = {a.where["axis"]: a for a in found.answer if a.effect == "backlash"}
    assert set(play) == {"X", "Y"}
    assert play["X"].parameters["gap"].value == pytest.approx(4.0, abs=0.3)
    assert play["Y"].parameters["gap"].value == pytest.approx(3.0, abs=0.2)
    assert play["X"].probability < 0.6
    assert play["Y"].probability < 0.6
    assert not play["X"].doubtful
    assert sum(a.fitted is not None for a in play.values()) == 1  # a file holds one of the two
    assert any(n.do == "run along Y only" for n in found.next_measurement)


@pytest.mark.thorough
def test_a_stated_squareness_that_the_rows_contradict_is_named_with_the_size_they_give():
    """Stated 0 +- 3 urad, 24 urad in the rows: a pull of 8, and the size is that of the rows alone."""
    case = make.make((), 0.0, 12, replace(make.RICH, n=150))
    known = Squareness("C0Y", 0.0)
    machine = make.machine(known, inputs=(Input("squareness", "C0Y", "angle", Normal(3e-6)),))
    shown = make.machine(replace(known, angle=24e-6)).tip_error(case.recording.run)
    moved = -np.einsum("ij,ij->i", shown[case.recording.row], case.recording.direction)
    recording = replace(case.recording, value=case.recording.value + moved)
    found = diagnose_recording(recording, machine, 1, 400)
    (pull,) = (p.pull for p in found.pulls if p.input == "squareness[C0Y].angle")
    assert 6.0 < pull < 10.0
    (answer,) = (a for a in found.answer if a.effect == "squareness")
    low, high = answer.parameters["angle"].interval95
    assert low < 24.0 < high
    assert answer.parameters["angle"].u < 2.5  # the statement would hold it at 3
    assert any("contradict" in r for r in found.reasons)


def test_terms_are_taken_off_as_they_were_fitted():
    """Hand-made: columns (1, 2, 3) times 2 leave (3, 4, 5) - (2, 4, 6) = (1, 0, -1); without nuisance rms sqrt(2/3)."""
    from types import SimpleNamespace

    problem = SimpleNamespace(
        residual=np.array([3.0, 4.0, 5.0]),
        nuisance=np.zeros((3, 0)),
        u=np.ones(3),
        own_uncertainty=np.zeros((3, 0)),
    )
    option = SimpleNamespace(columns=np.array([[1.0], [2.0], [3.0]]))
    selection = SimpleNamespace(
        terms=(SimpleNamespace(option=option),), fit=SimpleNamespace(mean=np.array([2.0]))
    )
    assert residual_after_terms(problem, selection) == pytest.approx([1.0, 0.0, -1.0])
    assert rms_after_terms(problem, selection) == pytest.approx(np.sqrt(2.0 / 3.0))


MACHINE = """vcmm = "machine/1"
name = "bench"
structure = "w b X t"
[axes.X]
travel = ["0 mm", "100 mm"]
[repeatability]
law = "normal"
u = "0.1 um"
"""
RECORDING = """vcmm = "recording/1"
data = "runs.csv"
machine = "machine.toml"
kind = "displacement"
format = "iso230"
[line]
axis = "X"
[nuisance]
zero = ""
"""


@pytest.mark.thorough
def test_the_fit_that_is_reported_is_that_of_the_file_to_the_digit(tmp_path, capsys):
    recording = positioning(1.9 * UM, 0.1 * UM, slope=40e-6)
    rows = ["target_mm,run,direction,actual_mm"]
    for i, (x, d, v) in enumerate(
        zip(recording.run.position["X"], recording.run.columns["sense_X"], recording.value)
    ):
        rows.append(f"{x},{i // 10 + 1},{'up' if d > 0 else 'down'},{x + v:.7f}")
    (tmp_path / "runs.csv").write_text("\n".join(rows) + "\n")
    (tmp_path / "machine.toml").write_text(MACHINE)
    (tmp_path / "recording.toml").write_text(RECORDING)
    file, out = str(tmp_path / "recording.toml"), tmp_path / "out"
    assert run(["diagnose", file, "--json", "--seed", "1", "--out", str(out)]) == 0
    fit = json.loads(capsys.readouterr().out)["fit"]
    assert run(["compare", file, "--machine", str(out / "machine.toml"), "--json"]) == 0
    before, after = (m["rms_um"] for m in json.loads(capsys.readouterr().out)["machines"])
    assert (fit["rms_before_um"], fit["rms_after_um"]) == (before, after)
    assert after < 0.13 < 1.0 < before
    assert fit["candidates_rms_um"] <= after * 1.05
