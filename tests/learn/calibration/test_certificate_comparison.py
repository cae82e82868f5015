"""vcmm certificate: U by prior and by fact, machines at the limit counted, machine files held to a stated certificate."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from tests.plate import edited
from vcmm.answer.evaluation.at_limit import covered_at_limit
from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.face.cli import run
from vcmm.files.own.certificate import stated_certificate
from vcmm.files.own.library import example
from vcmm.files.own.machine import load_machine
from vcmm.files.own.scenario import load_scenario
from vcmm.show.tables.calibration import COVERAGE_COLUMNS
from vcmm.show.tables.table import ResultTable, text
from vcmm.task.certification import machines as family
from vcmm.task.certification.certificate import LengthLimit, MachineCertificate
from vcmm.task.certification.lines import length_run, seven_lines
from vcmm.task.certification.machines import drawn_machines, geometry_at_limit

STATED = 'E0_MPE = "1.8 um + L/350"                     # L'


def sizes_only(folder: Path, more: str = "") -> Path:
    """The shipped scenario with its two lengths, and further facts on its certificate."""
    whole = example("certificate").read_text(encoding="utf-8")
    head, rest = whole.split('[[part.characteristics]]\nname = "bore square to top"')
    whole = head + rest[rest.index("[pose]") :]
    assert STATED in whole
    found = folder / "certificate.toml"
    found.write_text(whole.replace(STATED, more + STATED), encoding="utf-8")
    return found


def worth(capsys: pytest.CaptureFixture[str], scenario: Path) -> dict:
    assert run(["certificate", str(scenario), "--trials", "2000", "--json"]) == 0
    found: dict = json.loads(capsys.readouterr().out)
    return found


def u_of(rows: list[dict], name: str) -> dict[str, float]:
    return {r["known"]: r["U_mm"] * 1e3 for r in rows if r["characteristic"] == name}


@pytest.mark.count
def test_priors_facts_and_machines_at_the_limit(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """A tight ISO 230-2 limit takes U of a distance down; machines that use all of their limit stay covered."""
    monkeypatch.setattr(family, "DRAWN", 1500)
    found = worth(capsys, sizes_only(tmp_path, 'iso230_2 = { A = "1.2 um", R = "0.6 um" }\n'))
    prior, fact = (u_of(found[k], "bore to front") for k in ("by_prior", "by_fact"))
    assert list(prior) == ["limit", "uniform", "typical"]
    assert prior["limit"] > max(prior["uniform"], prior["typical"]) > 0
    assert list(fact) == ["E0_MPE", "+ P_Form_Sph_1x25", "+ R0_MPL", "+ iso230_2"]
    assert fact["+ iso230_2"] < fact["+ R0_MPL"]
    assert fact["+ iso230_2"] == pytest.approx(prior["limit"], rel=1e-9)
    shares = {(r["characteristic"], r["machines"]): r["covered"] for r in found["at_limit"]}
    assert len(shares) == 4
    # 1500 drawn machines and their mirror images: 95 % +- 0.6. No bound above: a limit says what machines may add, and an interval
    # that holds for all of them, the worst allowed, holds for more than 95 % of most
    assert all(0.93 < s <= 1.0 for s in shares.values())
    figures = {f["name"]: f for f in found["figures"]}
    assert 0.2 < figures["E0"]["p_pass"] < 0.8
    assert figures["A X"]["limit_um"] == pytest.approx(1.2)


@pytest.mark.thorough
def test_a_known_bias_that_is_left_in_is_held_by_the_interval(
    tmp_path: Path, capsys: pytest.CaptureFixture[str], monkeypatch: pytest.MonkeyPatch
) -> None:
    """Part at 22 degC: 11.5e-6 * 2 * 30 mm = 0.69 um too large; U holds |bias| (JCGM 100, F.2.4.5), so the counts do not fall."""
    monkeypatch.setattr(family, "DRAWN", 300)
    warm = sizes_only(tmp_path)
    warm.write_text(warm.read_text(encoding="utf-8").replace('room = "20 degC"', 'room = "22 degC"'))
    assert run(["certificate", str(warm), "--trials", "1000", "--json"]) == 0
    left_in = json.loads(capsys.readouterr().out)
    assert any(
        "bore diameter: the known bias of +0.69 um is not corrected" in w for w in left_in["warning_texts"]
    )
    warm.write_text(
        warm.read_text(encoding="utf-8").replace("seed = 1", 'seed = 1\nknown_bias = "corrected"')
    )
    assert run(["certificate", str(warm), "--trials", "1000", "--json"]) == 0
    right = json.loads(capsys.readouterr().out)
    assert not any("known bias" in w for w in right["warning_texts"])
    assert all(r["covered"] >= 0.95 for document in (left_in, right) for r in document["at_limit"])


@pytest.mark.thorough
def test_the_page_shows_how_machines_at_the_limit_are_covered(tmp_path: Path) -> None:
    """docs/certificate.md, of the scenario that comes with vcmm."""
    scenario = load_scenario(sizes_only(tmp_path))
    result = evaluate(scenario.task(), replace(scenario.settings, trials=20_000, certify=20))
    certificate = stated_certificate(example("certificate"))
    assert certificate is not None
    table = ResultTable("", COVERAGE_COLUMNS, covered_at_limit(scenario.machine, certificate, result))
    shown = (Path(__file__).parents[3] / "docs" / "certificate.md").read_text(encoding="utf-8")
    assert text(table) in shown


def test_both_limits_are_kept(tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    """E0 and A together: positions of every axis stay within A, and the worst length still meets E0."""
    from vcmm.core.machine import Machine
    from vcmm.task.certification.machines import along_axis, error_tables, per_mode
    from vcmm.task.certification.positioning import axis_run

    monkeypatch.setattr(family, "DRAWN", 1000)
    axes = edited(tmp_path).read_text().split("[machine]\n")[1].split("[machine.repeatability]")[0]
    file = tmp_path / "m.toml"
    file.write_text('vcmm = "machine/1"\n' + axes.replace("machine.", ""))
    machine = load_machine(file)
    c = MachineCertificate(E0=LengthLimit(1.8e-3, 350), R0=0.5e-3, positioning={("A", ""): 1.5e-3})
    drawn = drawn_machines(machine, c)
    bare = Machine(machine.name, machine.kind, machine.chain, machine.axes, tuple(error_tables(machine)[0]))
    for i, axis in enumerate("XYZ"):
        along = along_axis(bare, axis_run(bare, axis), i)
        assert np.ptp(drawn.modes @ along.T, axis=1).max() <= 1.5e-3
    lengths_run, lengths = length_run(bare, seven_lines(bare))
    used = (np.abs(drawn.modes @ per_mode(bare, lengths_run).T) / c.E0.at(lengths)).max(axis=1)  # type: ignore[union-attr]
    assert 0.6 < np.median(used) < 1.05  # scatter and tip use the rest
    alone = geometry_at_limit(machine, c, drawn)
    again = (np.abs(alone.modes @ per_mode(bare, lengths_run).T) / c.E0.at(lengths)).max(axis=1)  # type: ignore[union-attr]
    assert again == pytest.approx(np.ones(len(again)))
    assert len(drawn.mirror.scatter) == 2 * len(drawn.scatter)
    assert drawn.mirror.modes.sum(axis=0) == pytest.approx(np.zeros(drawn.modes.shape[1]), abs=1e-12)


def test_a_scenario_is_held_to_the_certificate_it_states(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    """Errors of its own and a certificate: check counts how often such a machine keeps it, lobing of the probe included."""
    lobing = '[[machine.effects]]\neffect = "probe_lobing"\nstylus = "down"\namplitude = "{} um"\n'
    for amplitude, told in (("0.1", False), ("9", True)):
        file = edited(
            tmp_path,
            ("[machine.repeatability]", '[machine.certificate]\nE0_MPE = "9 um + L/350"\nP_Form_Sph_1x25 = "9 um"\n[machine.repeatability]'),
            ("[[machine.inputs]]", lobing.format(amplitude) + "[[machine.inputs]]"),
        )  # fmt: skip
        assert run(["check", str(file)]) == 0
        (form,) = [line for line in capsys.readouterr().out.splitlines() if "certificate P_Form" in line]
        assert ("errors or certificate are wrong" in form) == told
    assert run(["certificate", str(file)]) == 2
    assert "states errors of its own beside its certificate" in capsys.readouterr().err
    assert run(["certificate", str(example("plate"))]) == 2
    assert "the machine states no certificate; add [machine.certificate]" in capsys.readouterr().err
