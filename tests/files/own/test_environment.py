"""The room that temperatures have in common, and Inputs that are known together: by hand, in every engine, and refused."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.plate import edited
from vcmm.answer.evaluation.exact import draw_inputs, exact_values, linear_quantities
from vcmm.answer.evaluation.linear import build
from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.answer.placing.closed_form import ClosedForm
from vcmm.answer.placing.rows import Rows
from vcmm.core.errors import DataError
from vcmm.files.own.scenario import load_scenario
from vcmm.task.measuring.settings import Settings

GIVEN = """temperature = { part = "21.2 degC", scale_x = "20.4 degC" }
u_temperature = { part = "0.1 K" }"""
RAW = ("compensated = true", "compensated = false")
QUICK = Settings(trials=2000, certify=20)
MEMBERS = 'names = ["squareness[C0Y].angle", "channel.temp_part_C"]'


def job(tmp_path, environment, *edits):
    return load_scenario(edited(tmp_path, (GIVEN, environment), *edits))


def lines(scenario, name="bore diameter"):
    found = next(c for c in evaluate(scenario.task(), QUICK).characteristics if c.name == name)
    return {b.input: b for b in found.budget}


@pytest.mark.thorough
def test_a_room_moves_part_and_scales_together(tmp_path):
    """Steel part 30 mm, tip of 4 mm, glass-like scales: (11.5 x 30 - 8.0 x 26) nm/K, and 1.5 K / sqrt(3) of the room.

    Drawn apart they would be sqrt(345^2 + 208^2) = 403 nm/K instead of 137.
    """
    line = lines(job(tmp_path, 'room = "20 degC"\nhalf_width = "1.5 K"', RAW))["environment.room"]
    assert line.u == pytest.approx(137e-6 * 1.5 / np.sqrt(3), rel=2e-3)
    assert line.distribution == "uniform"
    # normal law of 0.5 K, beside it the part's own difference of 0.1 K, which the scales do not share
    both = lines(job(tmp_path, 'room = "20 degC"\nu_room = "0.5 K"\nu_temperature = { part = "0.1 K" }', RAW))
    assert both["environment.room"].u == pytest.approx(137e-6 * 0.5, rel=2e-3)
    assert both["channel.temp_part_C"].u == pytest.approx(345e-6 * 0.1, rel=2e-3)


@pytest.mark.thorough
def test_sensors_stand_in_the_room_too(tmp_path):
    # scales compensated by their sensors: only the part is left, 345 nm/K; with the part compensated nothing is
    with_scales = lines(job(tmp_path, 'room = "20 degC"\nu_room = "0.5 K"'))["environment.room"]
    assert with_scales.u == pytest.approx(345e-6 * 0.5, rel=2e-3)
    all_of_it = 'room = "20 degC"\nu_room = "0.5 K"\npart = { compensated = true }'
    assert lines(job(tmp_path, all_of_it))["environment.room"].u == pytest.approx(0.0, abs=1e-9)


def test_temperatures_are_differences_to_the_room(tmp_path):
    room = job(tmp_path, 'room = "22 degC"\ntemperature = { part = "0.5 K", scale_x = "-0.25 K" }')
    found = {n: room.constants[f"temp_{n}_C"] for n in ("part", "scale_x", "scale_y", "air")}
    assert found == {"part": 22.5, "scale_x": 21.75, "scale_y": 22.0, "air": 22.0}
    assert room.constants["reading_part_C"] == 22.5


def test_exact_engine_and_placement_draw_the_same_room(tmp_path):
    inputs = f"\n[[inputs]]\n{MEMBERS}\ncovariance = [[1.0, 0.05], [0.05, 0.01]]\n[job]\ntrials = 20000"
    known = '[[machine.inputs]]\neffect = "squareness"\npair = "C0Y"\nparameter = "angle"\nu = "1 urad"\nredraw = "machine"\n'
    scenario = job(
        tmp_path, 'room = "21 degC"\nu_room = "0.8 K"', RAW, (known, ""), ("\n[job]\ntrials = 20000", inputs)
    )
    model = build(scenario.task())
    names = [f.input.id for f in model.influences]
    assert "environment.room" in names
    assert "squareness[C0Y].angle & channel.temp_part_C" in names
    drawn = draw_inputs(model, 3, 0, 40)
    difference = exact_values(model, drawn) - model.values(linear_quantities(model, drawn))
    # 1 urad on 30 mm is 30 nm: the part's temperature known with another quantity is not multiplied with its expansion,
    # which at three times both u's (0.3 K, 3 um/(m K)) leaves 27 nm; the room is multiplied
    assert np.abs(difference[:, [0, 2]]).max() < 27e-6
    closed = ClosedForm.of(Rows.of(scenario))
    weights = closed.model.gradient() @ closed.operator
    first, _ = closed.variances(closed.reference[None], weights)
    terms = dict(zip(names, model.terms()))
    for i, name in enumerate(closed.names):
        gain = terms[name].gain * np.ravel(terms[name].law.u)[0]
        expected = ((closed.model.gradient() @ gain) ** 2).sum(axis=1)
        assert first[0, [0, 2], i] == pytest.approx(expected[[0, 2]], rel=1e-2, abs=1e-16), name


def test_room_and_expansion_are_multiplied(tmp_path):
    model = build(job(tmp_path, 'room = "21 degC"\nu_room = "0.8 K"', RAW).task())
    drawn = draw_inputs(model, 3, 0, 40)
    difference = exact_values(model, drawn) - model.values(linear_quantities(model, drawn))
    assert (
        np.abs(difference[:, [0, 2]]).max() < 2e-6
    )  # touches: s^2 / (2 R); 3 x 0.8 K x 3 um/(m K) x 30 mm would be 0.2 um


@pytest.mark.thorough
def test_correlated_inputs_by_hand(tmp_path):
    """Part 11.5 um/(m K) x 30 mm = 0.345 um/K, uncertain by 0.1 K; scale coefficient and part temperature correlated by r.

    The scales: 26 mm x 1 K above 20 degC = 0.026 um per um/(m K), taken off what is read; u = 0.5 um/(m K).
    u^2 = 34.5^2 + 13^2 - 2 r 34.5 x 13 nm^2.
    """
    stated = 'temperature = { part = "20 degC", scale_x = "21 degC", scale_y = "21 degC" }'
    for r in (0.0, 0.9):
        table = (
            '\n[[inputs]]\nnames = ["channel.temp_part_C", "scale_expansion[X].alpha", "scale_expansion[Y].alpha"]\n'
            f"covariance = [[0.01, {r * 0.05}, {r * 0.05}], [{r * 0.05}, 0.25, 0.25], [{r * 0.05}, 0.25, 0.25]]\n"
            "[job]\ntrials = 20000"
        )
        scenario = job(
            tmp_path, stated, RAW, ('u_expansion = "0.5 um/(m K)", ', ""), ("\n[job]\ntrials = 20000", table)
        )
        line = next(b for name, b in lines(scenario).items() if " & " in name)
        expected = np.sqrt(34.5**2 + 13**2 - 2 * r * 34.5 * 13)
        assert line.u * 1e6 == pytest.approx(expected, rel=2e-3), r


@pytest.mark.parametrize(
    ("environment", "said"),
    [
        ('u_room = "0.5 K"', "u_room belongs to a room"),
        ('room = "20 degC"\nu_room = "0.5 K"\nhalf_width = "1 K"', "say the same thing"),
        ('room = "20 degC"\ntemperature = { part = "21 degC" }', "differences to it in K"),
        ('temperature = { part = "0.4 K" }', "no room to differ from"),
        ('room = "-400 degC"', "below absolute zero"),
        ('temperature = { part = "-400 degC" }', "below absolute zero"),
        ('room = "20 degC"\ntemperature = { part = "-400 K" }', "below absolute zero"),
        ('room = "20 K"', "is a temperature and takes degC"),
    ],
)
def test_what_no_environment_is(tmp_path, environment, said):
    with pytest.raises(DataError, match=said):
        job(tmp_path, environment)


@pytest.mark.parametrize(
    ("table", "said"),
    [
        ('names = ["channel.temp_part_C"]\ncovariance = [[1.0]]', "two or more quantities"),
        (
            f"{MEMBERS}\ncovariance = [[1.0, 0.0], [0.0, 1.0]]",
            r"squareness\[C0Y\].angle has an input already",
        ),
        (
            'names = ["channel.temp_part_C", "squareness[B0Z].angle"]\ncovariance = [[1, 0], [0, 1]]',
            "is no quantity",
        ),
        (
            'names = ["channel.temp_part_C", "channel.temp_air_C"]\ncovariance = [[1, 0]]',
            "2 rows of 2 plain numbers",
        ),
        (
            'names = ["channel.temp_part_C", "channel.temp_air_C"]\ncovariance = [[1, 2], [2, 1]]',
            "not positive",
        ),
        ('names = ["channel.temp_part_C", "channel.temp_air_C"]\nu = "1 K"', "unknown key"),
    ],
)
def test_what_no_correlated_inputs_are(tmp_path, table, said):
    with pytest.raises(DataError, match=said):
        job(tmp_path, "", ("\n[job]\ntrials = 20000", f"\n[[inputs]]\n{table}\n[job]\ntrials = 20000"))


def test_a_gradient_may_be_uncertain(tmp_path):
    one = job(tmp_path, 'temperature = { gradient = "0.5 K" }\nu_temperature = { gradient = "0.1 K" }')
    (known,) = [i for i in one.inputs if i.parameter == "temp_gradient_C"]
    assert known.law.u == pytest.approx(0.1)


def test_unused_and_exact_temperatures_are_said_of_a_room_too(tmp_path):
    from vcmm.answer.evaluation.checks import remarks

    said = remarks(job(tmp_path, 'room = "22 degC"', RAW))
    assert any("temperature part is taken as exactly known" in text for text in said)
    assert not any("air" in text for text in said)
    said = remarks(replace(job(tmp_path, 'room = "22 degC"\nu_room = "0.5 K"', RAW)))
    assert not any("temperature" in text for text in said)
