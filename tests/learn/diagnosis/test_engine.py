"""The whole diagnosis on concealed effects made by other code: names, numbers, silence where nothing is concealed."""

from __future__ import annotations

import json
from dataclasses import replace

import numpy as np
import pytest

from tests.learn.diagnosis import generator as make
from vcmm.learn.diagnosis.engine import diagnose_recording
from vcmm.learn.diagnosis.improve import improve_machine
from vcmm.learn.diagnosis.result import VERDICTS, diagnosis_json
from vcmm.physics.structure.component import ComponentTable

NULLS = 500


def diagnose(case, machine=None, seed=1):
    return diagnose_recording(case.recording, machine or make.machine(), seed, NULLS)


@pytest.fixture(scope="module")
def backlash():
    """A case of backlash, and what is found in it."""
    case = make.make(("backlash",), 12.0, 23)
    return case, diagnose(case)


@pytest.mark.thorough
@pytest.mark.parametrize("name", ["thermal_drift", "probe_lobing", "screw_pitch", "stylus_bending"])
def test_one_effect_is_named(name):
    case = make.make((name,), 12.0, 17)
    found = diagnose(case)
    assert found.verdict == "explained"
    assert found.answer[0].effect == name
    assert found.fit.after < found.fit.before
    assert sum(h.gain for h in found.fit.held_out) > 10


def test_parameters_are_found_with_their_uncertainty(backlash):
    case, found = backlash[0], backlash[1].answer[0]
    gap = found.parameters["gap"]
    true = case.amplitude[0]  # the generator's unit is a gap of 1 um
    assert gap.unit == "um"
    assert abs(gap.value - true) < 4 * gap.u
    assert gap.interval95[0] < gap.value < gap.interval95[1]
    assert found.where == {"axis": case.where[0]}


@pytest.mark.thorough
def test_the_improved_machine_explains_the_recording(backlash):
    case, found = backlash
    assert (found.verdict, found.answer[0].effect) == ("explained", "backlash")
    assert found.fit.after < found.fit.before
    assert sum(h.gain for h in found.fit.held_out) > 10
    better = improve_machine(make.machine(), tuple((a.fitted, a.inputs) for a in found.answer))
    assert [e.id for e in better.effects] == [f"backlash[{case.where[0]}]"]
    assert [i.id for i in better.inputs] == [f"backlash[{case.where[0]}].gap"]
    again = diagnose(case, better)
    assert again.verdict == "nothing missing"


@pytest.mark.thorough
def test_two_effects_are_both_named():
    found = diagnose(make.make(("backlash", "squareness"), 12.0, 31))
    assert {a.effect for a in found.answer} == {"backlash", "squareness"}
    assert sum(a.share for a in found.answer) == pytest.approx(1.0, abs=0.3)


@pytest.mark.parametrize(
    "noise",
    [
        pytest.param("t6", marks=pytest.mark.thorough),
        "outliers",
        pytest.param("ar0.6", marks=pytest.mark.thorough),
    ],
)  # test_verdict.py has the same laws at the door
def test_nothing_concealed_nothing_named(noise):
    found = diagnose(make.make((), 0.0, 41, noise=noise))
    assert found.verdict == "nothing missing"
    assert found.answer == ()
    assert found.unknown is None


@pytest.mark.thorough
def test_physics_outside_the_catalogue_is_not_given_a_name():
    found = diagnose(make.make(("unknown_rhythm",), 18.0, 102))
    assert found.unknown is not None
    assert "time" in found.unknown.covariates
    assert found.verdict in ("unexplained", "partly explained")


@pytest.mark.thorough
def test_a_poor_recording_gives_a_set_and_the_measurement_that_splits_it():
    found = diagnose(make.make(("tip_radius",), 14.0, 6, make.POOR))
    names = {found.answer[0].effect, *found.answer[0].cannot_be_told_from}
    assert {"tip_radius", "trigger_delay"} <= names
    assert any("speed" in step.do for step in found.next_measurement)


def tables(rng):
    """Tables with 2 um and 4 urad from node to node."""
    grid = np.linspace(-700, 1000, 13)
    return [
        ComponentTable(f"E{d}{a}", (a,), (grid,), rng.standard_normal(13) * (2e-3 if d in "XYZ" else 4e-6))
        for a in "XYZ"
        for d in "XYZABC"
    ]


@pytest.mark.parametrize(
    ("component", "factor", "what"),
    [
        ("EXX", -1.0, "sign"),
        pytest.param("EYX", 0.0, "missing", marks=pytest.mark.thorough),
        pytest.param("EXX", 2.0, "counted twice", marks=pytest.mark.thorough),
    ],
)
def test_mistakes_of_the_table_are_named(component, factor, what):
    stored = tables(np.random.default_rng(5))
    machine = make.machine(*stored)
    true = make.machine(
        *(replace(t, values=factor * t.values) if t.component == component else t for t in stored)
    )
    recording = make.make((), 0.0, 301).recording
    run = true.prepare(recording.run)
    error = (true.indication_error(run) * run.normal).sum(axis=1)
    found = diagnose_recording(replace(recording, value=recording.value + error), machine, 1, NULLS)
    assert found.mistake is not None
    assert (found.mistake.component, found.mistake.what) == (component, what)
    assert diagnosis_json(found)["answer"][0]["effect"] == "map_mistake"


@pytest.mark.thorough
def test_an_abbe_error_counted_twice_is_named():
    stored = tables(np.random.default_rng(5))
    plain = make.machine(*stored)
    axis = replace(plain.axes["X"], measured_at=(0.0, 300.0, -400.0))
    machine = replace(plain, axes={**plain.axes, "X": axis})  # believes that the tables were observed there
    recording = make.make((), 0.0, 77).recording
    run = plain.prepare(recording.run)
    twice = 2 * plain.tip_error(run) - machine.tip_error(run)  # an arm once too often, with either sign
    value = recording.value - (twice * run.normal).sum(axis=1)
    found = diagnose_recording(replace(recording, value=value), plain, 1, NULLS)
    assert found.verdict != "nothing missing"
    value = recording.value - (plain.tip_error(run) * run.normal).sum(axis=1)
    found = diagnose_recording(replace(recording, value=value), machine, 1, NULLS)
    assert found.answer[0].effect == "abbe_counted_twice"
    assert found.answer[0].where == {"axis": "X"}


@pytest.mark.thorough
def test_same_seed_same_report_and_the_document_is_complete():
    case = make.make(("linear_drift",), 10.0, 51)
    one, two = (json.dumps(diagnosis_json(diagnose(case))) for _ in range(2))
    assert one == two
    document = json.loads(one)
    assert document["verdict"] in VERDICTS
    assert set(document) == {
        "schema", "verdict", "answer", "unknown", "location", "mistake", "noise", "fit", "not_testable", "invisible",
        "detectable", "next_measurement", "improved_machine", "verdict_reasons", "calibration_pulls", "searched", "failed",
        "stable", "second_opinion", "transfer",
    }  # fmt: skip
    assert set(document["answer"][0]) >= {
        "effect", "where", "parameters", "probability", "share", "cannot_be_told_from", "evidence_nats",
    }  # fmt: skip
    assert set(document["fit"]["held_out"][0]) == {
        "fold", "rms_before_um", "rms_after_um", "effect_energy_left", "log_score_gain_nats",
    }  # fmt: skip
