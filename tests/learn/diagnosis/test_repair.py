"""What is written for other jobs: corrected tables, and effects beside the machine's own."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from tests.learn.diagnosis.test_engine import tables
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.face.cli import run
from vcmm.files.foreign.isg import ErrorFile, ErrorTable, isg_text, read_isg
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording_writer import save_recording
from vcmm.learn.diagnosis.candidates import build_catalogue
from vcmm.learn.diagnosis.engine import diagnose_recording
from vcmm.learn.diagnosis.improve import improve_machine, repair_machine, separate_effect
from vcmm.learn.diagnosis.log_mistakes import LOG
from vcmm.learn.diagnosis.mistakes import hypotheses
from vcmm.learn.diagnosis.problem import make_problem
from vcmm.physics.catalogue.pitch import ScrewPitch
from vcmm.physics.structure.component import ComponentTable
from vcmm.task.response.observe import baseline
from vcmm.task.response.recording import Recording


@pytest.mark.thorough
def test_every_repair_predicts_the_departure_that_was_found():
    plain = make.machine(*tables(np.random.default_rng(5)))
    axis = replace(plain.axes["X"], measured_at=(0.0, 300.0, -400.0))
    machine = replace(plain, axes={**plain.axes, "X": axis})
    problem = make_problem(make.make((), 0.0, 3, replace(make.RICH, n=60)).recording, machine)
    before, seen = baseline(problem.recording, machine), set()
    for h in hypotheses(problem):
        if h.effect == LOG:  # what is mended in the log leaves the machine as it is
            continue
        new = repair_machine(machine, h)
        if new.chosen_motion(problem.run)[1]:  # um taken for mm leave the range in which errors add up
            assert h.factor > 100
            continue
        after = baseline(problem.recording, new)
        assert np.abs(after - before - h.departure).max() < 1e-9, (h.component, h.what)
        seen.add(h.what.split(" with ")[0])
    assert seen == {
        "sign",
        "missing",
        "counted twice",
        "unit",
        "swapped",
        "Abbe error counted twice",
        "Abbe error left out",
    }


def test_tables_are_written_and_read_back(tmp_path):
    rng = np.random.default_rng(1)
    grid, other = np.array([0.0, 100.0, 250.0]), np.array([-50.0, 0.0])
    one = ErrorTable(("X",), (grid,), {"EXX": rng.normal(size=3), "EBX": rng.normal(size=3)}, 1)
    two = ErrorTable(("Z", "X"), (other, grid), {"EYX": rng.normal(size=(2, 3))}, 1)
    (tmp_path / "e.csv").write_text(isg_text(ErrorFile((one, two), {"C0Y": 3e-6}), "by hand"))
    back = read_isg(tmp_path / "e.csv")
    assert back.constants == {"C0Y": 3e-6}
    for a, b in zip((one, two), back.tables):
        assert a.arguments == b.arguments
        for name in a.values:
            assert np.allclose(a.values[name], b.values[name], rtol=1e-9)


MACHINE = """vcmm = "machine/1"
structure = "w b Y X Z t"
[axes]
X = { travel = ["-1000 mm", "1000 mm"] }
Y = { travel = ["-1000 mm", "1000 mm"] }
Z = { travel = ["-1000 mm", "1000 mm"] }
[errors]
table = "errors.csv"
[repeatability]
law = "t"
scale = "0.7 um"
dof = 6
"""


@pytest.mark.thorough
def test_the_corrected_table_is_written(tmp_path, capsys):
    stored = [t for t in tables(np.random.default_rng(5)) if t.component in ("EXX", "EYX", "EZX")]
    grid = stored[0].grids[0]
    (tmp_path / "errors.csv").write_text(
        isg_text(ErrorFile((ErrorTable(("X",), (grid,), {t.component: t.values for t in stored}, 1),), {}))
    )
    (tmp_path / "machine.toml").write_text(MACHINE)
    machine = load_machine(tmp_path / "machine.toml")
    true = make.machine(*(replace(t, values=-t.values) if t.component == "EXX" else t for t in stored))
    recording = make.make((), 0.0, 301).recording
    error = (true.indication_error(true.prepare(recording.run)) * recording.run.normal).sum(axis=1)
    save_recording(replace(recording, value=recording.value + error, noise=None), tmp_path / "recording.toml")
    out = tmp_path / "out"
    assert run(["diagnose", str(tmp_path / "recording.toml"), "--json", "--out", str(out)]) == 0
    found = json.loads(capsys.readouterr().out)
    assert (found["mistake"]["component"], found["mistake"]["what"]) == ("EXX", "sign")
    better = load_machine(out / "machine.toml")
    table = {e.where: e for e in better.effects if isinstance(e, ComponentTable)}
    assert np.allclose(table["EXX"].values, -stored[0].values, rtol=1e-8)
    assert np.allclose(table["EYX"].values, stored[1].values, rtol=1e-8)
    assert machine.chain == better.chain
    again = ["diagnose", str(tmp_path / "recording.toml"), "--machine", str(out / "machine.toml"), "--json"]
    assert run(again) == 0
    assert json.loads(capsys.readouterr().out)["verdict"] == "nothing missing"


@pytest.mark.thorough
def test_a_second_period_stands_beside_the_first_with_an_input_of_its_own():
    known = ScrewPitch("X", 2e-3, 0.0, 20.0)
    machine = make.machine(known)
    case = make.make((), 0.0, 5).recording
    q = case.run.position["X"]
    wave = 1.2e-3 * np.sin(2 * np.pi * q / 7.3 + 1.0)
    signal = -(wave + 2e-3 * np.sin(2 * np.pi * q / 20.0)) * case.direction[:, 0]
    found = diagnose_recording(replace(case, value=case.value + signal), machine, 1, 500)
    assert [a.effect for a in found.answer] == ["screw_pitch"]
    better = improve_machine(machine, tuple((a.fitted, a.inputs) for a in found.answer))
    assert known in better.effects  # untouched
    new = better.effects[-1]
    assert new.id != known.id
    assert new.period / new.harmonic == pytest.approx(7.3, rel=2e-3)
    assert np.hypot(new.sine, new.cosine) == pytest.approx(1.2e-3, rel=0.25)
    assert {i.where for i in better.inputs} == {new.where}
    assert (
        separate_effect(replace(known, sine=1.0), machine).id == known.id
    )  # the same period is the same effect


def saw(turns=2.0):
    """An index table whose reading gains 0.3 mrad per turn and falls back at its mark."""
    n = 240
    c = np.linspace(0, 2 * np.pi * 0.999, n)
    rng = np.random.default_rng(2)
    columns = {"nx": np.zeros(n), "ny": np.zeros(n), "nz": np.ones(n)}
    made = Run({"C": c}, np.zeros((n, 3)), columns)
    value = 0.3e-3 * (c / (2 * np.pi) - 0.5) + 10e-6 * rng.standard_normal(n)
    from vcmm.core.laws import Normal

    axis = np.tile([0.0, 0.0, 1.0], (n, 1))
    rows = np.arange(n)
    return Recording(
        "table", "angle", made, value, True, rows, axis, np.full(n, -1), None, {"zero": ""}, Normal(10e-6)
    )


def test_a_saw_over_a_full_turn_is_no_geometry():
    machine = Machine(
        "table", "machine-tool", parse_structure("w b C t"), {"C": Axis("C", (-0.1, 7.0))}, (), ()
    )
    names = {f.name for f in build_catalogue(make_problem(saw(), machine)).families}
    assert "geometric_change" not in names
    found = diagnose_recording(saw(), machine, 1, 500)
    assert found.answer[0].effect == "scale_factor"
    assert "wrap" in found.answer[0].remark
