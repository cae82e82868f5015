"""Families: certain that it is a play where its shape is open; the simplest open member is written and the others are said."""

from __future__ import annotations

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest

from vcmm.face.cli import run
from vcmm.learn.diagnosis.estimates import Estimate
from vcmm.learn.diagnosis.families import Kin, Member, kin_of, open_members_text, simplest_member
from vcmm.learn.diagnosis.result import Answer
from vcmm.learn.diagnosis.written_machine import writing_remarks
from vcmm.physics.catalogue.scale import ScaleFactor

MACHINE = """vcmm = "machine/1"
structure = "w b Y t"
[axes.Y]
travel = ["0 mm", "100 mm"]
[repeatability]
law = "normal"
u = "0.1 um"
"""
RECORDING = """vcmm = "recording/1"
data = "data.csv"
machine = "machine.toml"
kind = "displacement"
observed = "actual - commanded"
history = "none"
[nuisance]
zero = ""
"""


def play(backlash: float, lost_motion: float) -> Kin:
    """A play with the probabilities of its two members; backlash is family 0 with one number, lost_motion family 1 with two."""
    members = [
        Member("backlash", {"axis": "Y"}, backlash, 0, 1),
        Member("lost_motion", {"axis": "Y"}, lost_motion, 1, 2),
    ]
    return Kin("play", backlash + lost_motion, tuple(sorted(members, key=lambda m: -m.probability)))


def answer(**changes: object) -> Answer:
    one = Answer("backlash", {"axis": "Y"}, {}, 0.17, 0.9, ("lost_motion",), 170.0)
    return replace(one, **changes)  # type: ignore[arg-type]


def test_the_simplest_member_within_three_nats_is_taken():
    assert simplest_member(play(0.17, 0.83), 1) == 0  # ln(0.83 / 0.17) = 1.6 nats
    assert simplest_member(play(0.04, 0.95), 1) == 1  # ln(0.95 / 0.04) = 3.2 nats: refused
    assert simplest_member(play(0.17, 0.70), 1) == 1  # 0.87 of the family: it is not secure
    assert simplest_member(play(0.83, 0.17), 0) == 0


def test_a_secure_family_is_a_finding_whatever_its_shape():
    assert answer().doubtful
    assert not answer(kin=play(0.17, 0.83)).doubtful
    assert answer(kin=play(0.17, 0.70)).doubtful
    assert answer(kin=play(0.17, 0.83).times(0.5)).doubtful  # half of it is the instrument's
    assert kin_of("backlash") == kin_of("lost_motion") == kin_of("hysteresis") == "play"
    assert kin_of("servo_lag") == "servo_lag"
    assert "lost_motion p 0.83, backlash p 0.17" in open_members_text(play(0.17, 0.83))


def test_a_size_that_may_be_anything_is_no_finding():
    def size(value: float, u: float) -> Estimate:
        return Estimate(value, u, (value - 2 * u, value + 2 * u), "um/K")

    one = answer(probability=0.99, scanned_parameters=("tau",))
    lag = {"tau": size(900.0, 800.0)}
    assert replace(one, parameters={"k": size(25, 24), **lag}).doubtful
    assert not replace(
        one, parameters={"k": size(25, 12), **lag}
    ).doubtful  # its lag may be: the size is known
    two = {"k": size(89, 46), "k_slow": size(-57, 46)}
    assert replace(one, parameters={**two, **lag}).doubtful
    assert not replace(one, parameters={**two, "k": size(89, 40)}).doubtful
    known = replace(one, parameters={"k": size(25, 24)}, fitted=ScaleFactor("Y"))
    assert "its size is not known" in writing_remarks([known])[0]


def test_what_may_as_well_be_the_instruments_is_not_written():
    scale = answer(probability=0.5, fitted=ScaleFactor("Y"), of_instrument=("air_index",))
    assert "air_index" in writing_remarks([scale])[0]
    assert "not written" in writing_remarks([scale])[0]


@pytest.fixture
def axis(tmp_path: Path) -> Path:
    """14 targets, both ways, three times: Y stops 1.3 um too far, by 1.1 um/m more along the axis, which 0.06 um of scatter hide."""
    rng = np.random.default_rng(21)
    target = np.tile(np.repeat(np.linspace(5, 70, 14), 2), 3)
    sense = np.tile([1.0, -1.0], 42)
    gap = -1.3 - 1.1e-3 * (target - 37.5)
    value = -0.5 * gap * sense + 11e-3 * target + rng.normal(0, 0.06, 84)
    rows = [f"{y:g},{s:g},0,1,0,{d:.4f}" for y, s, d in zip(target, sense, value)]
    (tmp_path / "data.csv").write_text("\n".join(["Y_mm,sense_Y,nx,ny,nz,d_um", *rows]) + "\n")
    (tmp_path / "machine.toml").write_text(MACHINE)
    (tmp_path / "recording.toml").write_text(RECORDING)
    return tmp_path / "recording.toml"


def test_the_document_says_family_and_members(axis, tmp_path, capsys):
    assert run(["diagnose", str(axis), "--json", "--out", str(tmp_path / "out")]) == 0
    found = json.loads(capsys.readouterr().out)
    own = next(a for a in found["answer"] if a["family"] == "play")
    assert own["family_probability"] > 0.95
    assert not own["doubtful"]
    assert own["effect"] == "backlash"
    # half of the difference of the two senses: gap = -1.3 um, u = 2 x 0.06 / sqrt(84) = 0.013 um
    assert own["parameters"]["gap"]["value"] == pytest.approx(-1.3, abs=0.04)
    assert {m["effect"] for m in own["members"]} <= {"backlash", "lost_motion", "hysteresis"}
    assert sum(m["probability"] for m in own["members"]) <= own["family_probability"] + 1e-9
    assert 'effect = "backlash"' in (tmp_path / "out" / "machine.toml").read_text()
    assert found["fit"]["rms_after_um"] < 0.075
