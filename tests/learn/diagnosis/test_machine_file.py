"""Effects written into a machine file are read again as they were."""

from __future__ import annotations

import tomllib

import numpy as np
import pytest

from tests.physics.ask import ask
from vcmm.core.effect import parameter_fields, place_fields
from vcmm.core.run import Run
from vcmm.files.learned.effect_text import effect_toml
from vcmm.files.learned.improved_machine import improved_machine
from vcmm.files.own.effects import build_effect
from vcmm.files.own.machine import load_machine
from vcmm.learn.diagnosis.result import Answer
from vcmm.learn.diagnosis.written_machine import answers_to_write, writing_remarks
from vcmm.physics import ALL
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.physics.catalogue.drift import StepChange
from vcmm.physics.catalogue.laser import AirIndex
from vcmm.physics.catalogue.map_interpolation import MapInterpolation
from vcmm.physics.structure.abbe import AbbeOffset
from vcmm.physics.structure.component import CalibrationModes, ComponentSpline, ComponentTable
from vcmm.physics.structure.geometric_change import GeometricChange
from vcmm.physics.structure.squareness import RotaryLocation

ARRAYS = ("nodes", "powers", "orders")


def plain() -> list:
    """One instance of every effect whose parameters are numbers or short vectors."""
    out = []
    for kind in ALL:
        if kind in (ComponentTable, ComponentSpline, CalibrationModes) or any(
            word in f.metadata["shape"] for f in parameter_fields(kind) for word in ARRAYS
        ):
            continue
        try:
            out.append(kind())
        except TypeError:
            continue
    return out


@pytest.mark.parametrize("effect", plain(), ids=lambda e: e.name)
def test_written_and_read_again(effect):
    table = tomllib.loads(effect_toml(effect, "a comment"))["effects"][0]
    again = build_effect(table)
    assert again.id == effect.id
    for f in parameter_fields(effect):
        assert np.allclose(getattr(again, f.name), getattr(effect, f.name)), f.name
    for f in place_fields(effect):
        assert getattr(again, f.name) == getattr(effect, f.name)


@pytest.mark.parametrize("effect", [RotaryLocation("X0C", offset=2e-3), RotaryLocation("A0C", tilt=3e-6)])
def test_rotary_locations_keep_their_one_number(effect):
    again = build_effect(tomllib.loads(effect_toml(effect))["effects"][0])
    assert (again.offset, again.tilt) == pytest.approx((effect.offset, effect.tilt))


@pytest.mark.parametrize(
    "effect",
    [
        GeometricChange("EYX", np.array([120.0, 680.0]), np.array([1e-3, 2e-3, 0.0, -1e-3])),
        GeometricChange("EZC", np.array([-1.5, 2.0]), np.array([1e-3, 2e-3])),
        MapInterpolation("EXX", np.array([0.0, 50.0, 200.0]), "cells", np.array([1e-3, -2e-3])),
        AbbeOffset("X", ("X",), (np.array([0.0, 300.0]),), np.array([[0.0, 0, 0], [2e-3, -1e-3, 5e-4]]), np.array([0.0, 40.0, 60.0])),
    ],
)  # fmt: skip
def test_travels_and_tables_of_found_effects_are_written(effect):
    again = build_effect(tomllib.loads(effect_toml(effect))["effects"][0])
    run = Run({"X": np.array([150.0]), "C": np.array([0.3])}, np.zeros((1, 3)))
    assert again.error_motion(run) == pytest.approx(effect.error_motion(run), abs=1e-12)
    assert np.any(effect.error_motion(run))


def _answer(effect, probability, **where):
    return Answer(effect.name, where, {}, probability, 0.5, (), 10.0, fitted=effect)


def test_candidates_and_errors_of_the_instrument_stay_out_of_the_machine_file(tmp_path):
    path = tmp_path / "machine.toml"
    path.write_text(
        'vcmm = "machine/1"\nkind = "cmm"\nstructure = "w b X t"\n[axes.X]\ntravel = ["0 mm", "800 mm"]\n'
    )
    answers = [
        _answer(Backlash("X", 2e-3), 0.98, axis="X"),
        _answer(StepChange("x"), 0.10, direction="x"),
        _answer(AirIndex(), 0.99),
    ]
    assert [a.effect for a in answers_to_write(answers)] == ["backlash"]
    assert [n.split(" is not written")[0] for n in writing_remarks(answers)] == ["step_change x", "air_index"]
    text = improved_machine(path, tmp_path / "out.toml", load_machine(path), answers, "r.toml")
    assert [e["effect"] for e in tomllib.loads(text)["effects"]] == ["backlash"]
    assert "# air_index is not written into the machine file: it is an error of the instrument" in text
    assert "probability 0.100" in text


def test_the_range_and_the_clock_of_what_was_found_are_remarked():
    change = GeometricChange("EZY", np.array([41.61, 517.86]), np.zeros(2))
    assert ask(change, "file_note").startswith("recorded from 41.6 to 517.9 mm")
    assert "clock of the recording" in ask(StepChange("x"), "file_note")
    assert ask(Backlash("X"), "file_note") == ""
