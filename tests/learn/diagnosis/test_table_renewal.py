"""A stale calibration: tables anew with their covariance, against arithmetic by hand; where they do not predict, none is written."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from types import SimpleNamespace

import numpy as np
import pytest

from vcmm.answer.evaluation.gaussian import Posterior, posterior, whitener
from vcmm.core.run import Run
from vcmm.files.learned.renewed_tables import name_tables, renewed_files
from vcmm.files.own.machine import load_machine
from vcmm.learn.diagnosis.assembly import _renew_tables
from vcmm.learn.diagnosis.candidates import Family, Option
from vcmm.learn.diagnosis.cross_checks import second_opinion
from vcmm.learn.diagnosis.estimates import Estimate
from vcmm.learn.diagnosis.evidence import dictionary
from vcmm.learn.diagnosis.mistakes import is_stale
from vcmm.learn.diagnosis.problem import make_problem
from vcmm.learn.diagnosis.result import STATUS_NOT_MODELLED, VERDICTS, Answer
from vcmm.learn.diagnosis.rivals import Standing
from vcmm.learn.diagnosis.select import SelectedTerm, Selection
from vcmm.learn.diagnosis.table_renewal import RenewedTables, renew_tables, with_tables
from vcmm.task.response.recording import Recording

MACHINE = """vcmm = "machine/1"
structure = "w b X t"
[axes.X]
travel = ["0 mm", "300 mm"]
[errors]
table = "errors.csv"
covariance = "covariance.csv"
[repeatability]
law = "normal"
u = "0.5 um"
"""
TABLE = "X EXX\n0 0.001\n100 0.001\n200 0.001\n300 0.001\n"
NAMES = [f"EXX@{q}" for q in (0, 100, 200, 300)]
COVARIANCE = "\n".join(
    [
        "error,position," + ",".join(NAMES),
        *(f"EXX,{100 * i}," + ",".join("1e-6" if i == j else "0" for j in range(4)) for i in range(4)),
    ]
)  # 1 um at every node, independent


def machine_in(folder: Path) -> Path:
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "errors.csv").write_text(TABLE)
    (folder / "covariance.csv").write_text(COVARIANCE + "\n")
    return folder / "machine.toml"


def found_in(
    folder: Path, departures: tuple[float, float, float], scatter: float = 0.5e-3
) -> RenewedTables | None:
    """40 readings at each of the nodes 0, 100 and 200, none at 300: the table's 1 um plus a departure, +- scatter in turn."""
    machine = load_machine(machine_in(folder))
    x = np.repeat([0.0, 100.0, 200.0], 40)
    sign = np.tile([1.0, 1.0, -1.0, -1.0], 30)  # even and odd rows alike
    value = 1e-3 + np.repeat(departures, 40) + scatter * sign
    n = len(x)
    recording = Recording(
        "one",
        "displacement",
        Run({"X": x}, np.zeros((n, 3))),
        value=value,
        measuring=False,
        row=np.arange(n),
        direction=np.tile([1.0, 0, 0], (n, 1)),
        other=np.full(n, -1),
    )
    problem = make_problem(recording, machine)
    noise = SimpleNamespace(rho=0.0, noise=SimpleNamespace(clip=3.0))
    stage = SimpleNamespace(u=problem.u, noise=noise)
    columns = np.zeros((n, 1))
    term = SelectedTerm(
        Family("stale", {}, ()), Option(None, columns, np.ones(1), ("calibration[0]",), 0.0), columns
    )
    selection = SimpleNamespace(terms=(term,), fit=Posterior, span=lambda i: slice(0, 1))
    return renew_tables(problem, stage, selection, 0)


def test_a_node_moves_by_what_was_seen_there_and_its_uncertainty_shrinks(tmp_path):
    new = found_in(tmp_path, (4e-3, -3e-3, 5e-3))
    # posterior of a node: a s^2 / (s^2 + sigma^2 / n), sigma^2 / n = 0.25 / 40 = 0.00625 um^2; s of some um: 4.00, -3.00, 5.00
    assert new is not None
    assert new.errors == ("EXX",) * 4
    assert new.change[:3] * 1e3 == pytest.approx([4.0, -3.0, 5.0], rel=0.005)
    assert np.diag(new.covariance)[:3] * 1e6 == pytest.approx([0.00625] * 3, rel=0.1)
    # nobody looked at 300 mm: it stays, known s times worse than was stated (1 um); s^2 near the mean square (16 + 9 + 25) / 3 = 16.7
    assert new.change[3] == pytest.approx(0.0, abs=1e-9)
    assert np.sqrt(new.covariance[3, 3]) * 1e3 == pytest.approx(new.wider, rel=0.05)
    assert 2.8 <= new.wider <= 5.7
    # rows held out: rms sqrt(16.7 + 0.25) = 4.1 um before, the scatter of 0.5 um after
    assert [h.fold for h in new.held_out] == ["even rows", "odd rows"]
    for half in new.held_out:
        assert half.rms_before * 1e3 == pytest.approx(4.11, rel=0.01)
        assert half.rms_after * 1e3 == pytest.approx(0.5, rel=0.02)
    assert new.holds


def test_tables_that_do_not_predict_are_not_handed_over(tmp_path):
    """Nothing departs from what is stored: rows held out gain nothing by it."""
    new = found_in(tmp_path, (0.0, 0.0, 0.0))
    assert new is not None
    assert not new.holds


def test_the_machine_anew_has_the_tables_and_reads_back_from_its_files(tmp_path):
    new = found_in(tmp_path, (4e-3, -3e-3, 5e-3))
    original = tmp_path / "machine.toml"
    machine = load_machine(original)
    in_memory = with_tables(machine, new)
    (table,) = [e for e in in_memory.effects if e.about.table_parameter]
    assert table.values * 1e3 == pytest.approx([5.0, -2.0, 6.0, 1.0], rel=0.01)  # 1 um was stored

    texts = renewed_files(original, machine, new, "recording.toml")
    texts["machine.toml"] = name_tables(original.read_text(), "recording.toml")
    out = tmp_path / "out"
    out.mkdir()
    for name, text in texts.items():
        (out / name).write_text(text)
    read = load_machine(out / "machine.toml")
    (again,) = [e for e in read.effects if e.about.table_parameter]
    assert again.values == pytest.approx(table.values, abs=1e-12)
    modes = [e for e in read.effects if e.name == "calibration_modes"]
    assert modes[0].loadings @ modes[0].loadings.T == pytest.approx(new.covariance, rel=1e-5, abs=1e-13)


def test_what_cannot_be_handed_over_is_named_and_not_modelled():
    """No term of the refit says it, so nothing is written, and the reason says what to do."""
    stale = Answer("geometric_change", {"component": "all"}, {}, 0.99, 0.9, (), 50.0, alias_probability=0.99)
    given = SimpleNamespace(selection=SimpleNamespace(terms=()), problem=None)
    every, held, said = _renew_tables((stale,), given, None)
    assert every == (stale,)
    assert held == ()
    assert "calibrate anew" in said[0]
    assert STATUS_NOT_MODELLED in VERDICTS
    assert STATUS_NOT_MODELLED == "named, not modelled"


def test_a_criterion_that_counts_columns_is_not_asked_of_a_covariance():
    """30 columns of 31 would have to pay 30 (ln 200 + 2 ln 31) = 365, though none of them is free; a scale beside them is asked."""
    rng = np.random.default_rng(4)
    wide, straight = rng.standard_normal((200, 30)), np.linspace(-1.0, 1.0, 200)[:, None]
    y = wide @ rng.standard_normal(30) + 20.0 * straight[:, 0] + rng.standard_normal(200)
    white = whitener(np.ones(200), np.zeros((200, 0)), np.zeros((200, 0)))
    stale = Option(None, wide, np.ones(30), tuple(f"calibration[{i}]" for i in range(30)), 0.0)
    families = (
        Family("geometric_change", {"component": "all"}, (stale,)),
        Family("scale", {"axis": "X"}, (Option(None, straight, np.ones(1), ("k",), 0.0),)),
    )
    found = dictionary(families, white)
    terms = tuple(SelectedTerm(f, f.options[0], f.options[0].columns, 1.0) for f in families)
    x = np.concatenate([wide, straight], axis=1)
    fit = posterior(x, y, 200, np.full(31, 10.0))
    said = second_opinion(
        found, Selection(terms, fit, y, y - x @ fit.mean), (Standing(9.0, 0.9, (), ()),) * 2, 200
    )
    assert said.names == ("scale[X]",)
    assert said.agrees
    assert said.lacks == (False, False)
    # without the scale among the terms it is what the criterion has and the names have not
    alone = posterior(wide, y, 200, np.full(30, 10.0))
    other = second_opinion(
        found, Selection(terms[:1], alone, y, y - wide @ alone.mean), (Standing(9.0, 0.9, (), ()),), 200
    )
    assert other.names == ("scale[X]",)
    assert not other.agrees
    assert other.lacks == (False,)


def test_the_size_of_a_covariance_is_judged_by_rows_held_out():
    assert is_stale("geometric_change", "all")
    assert not is_stale("geometric_change", "EXX")
    a = Answer(
        "geometric_change",
        {"component": "all"},
        {"rms": Estimate(2.2, 1.6, (1.2, 7.3), "um")},  # u is more than half of it
        0.975,
        0.4,
        (),
        12.6,
    )
    assert not a.is_undetermined  # rows held out judge its tables
    assert replace(a, where={"component": "EXX"}).is_undetermined
