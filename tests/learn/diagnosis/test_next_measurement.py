"""What to measure next. Coming from the other side: every axis for an instrument, only the axes at rest for a touch, which goes inwards."""

from __future__ import annotations

from types import SimpleNamespace
from typing import cast

import numpy as np

from tests.learn.diagnosis import generator as make
from vcmm.core.run import Run
from vcmm.learn.diagnosis.addons import _other_side, _other_side_of_touches, _turn_artefact
from vcmm.learn.diagnosis.candidates import Family, Option
from vcmm.learn.diagnosis.next_measurement import next_steps, steps_for_unknown
from vcmm.learn.diagnosis.problem import Problem, make_problem
from vcmm.learn.diagnosis.result import Unknown
from vcmm.learn.diagnosis.rivals import Standing
from vcmm.learn.diagnosis.select import SelectedTerm, Selection, Setting
from vcmm.physics import BY_NAME


def run_of(normals: list[list[float]]) -> Run:
    n = len(normals)
    nx, ny, nz = np.array(normals, dtype=float).T
    columns = {"nx": nx, "ny": ny, "nz": nz, "sense_X": -np.ones(n), "sense_Y": np.ones(n)}
    return Run({a: np.zeros(n) for a in "XYZ"}, np.zeros((n, 3)), columns)


def test_an_instrument_along_x_sees_both_approaches():
    turned = _other_side(run_of([[1, 0, 0], [1, 0, 0]]))
    assert turned is not None
    assert turned.columns["sense_X"].tolist() == [1, 1]
    assert turned.columns["sense_Y"].tolist() == [-1, -1]


def test_a_touch_along_x_keeps_the_sense_of_x():
    turned = _other_side_of_touches(run_of([[1, 0, 0], [0, 1, 0]]))
    assert turned is not None
    assert turned.columns["sense_X"].tolist() == [
        -1,
        1,
    ]  # X moves in the first touch and stands in the second
    assert turned.columns["sense_Y"].tolist() == [-1, 1]


def test_touches_in_which_all_axes_move_cannot_come_from_the_other_side():
    assert _other_side_of_touches(run_of([[0.6, 0.64, 0.48], [0.6, -0.64, 0.48]])) is None


def test_a_quarter_turn_of_the_artefact_about_its_middle():
    """Tips (10, 5) and (14, 11), middle (12, 8), offset 1 mm in x: arms (-2, -3) and (2, 3) turn to (3, -2) and (-3, 2), so tips (15, 6) and
    (9, 10), readings 1 less in x; the normal (1, 0, 0) turns to (0, 1, 0), (0, 1, 0) to (-1, 0, 0); 30 deg of the probe becomes 120."""
    position = {"X": np.array([9.0, 13.0]), "Y": np.array([5.0, 11.0]), "Z": np.array([7.0, 8.0])}
    columns = {"nx": np.array([1.0, 0.0]), "ny": np.array([0.0, 1.0]), "nz": np.zeros(2)}
    angle = {"probe_angle_rad": np.radians([30.0, 0.0])}
    labels = {"pose": np.array(["a", "a"])}
    turned = _turn_artefact(Run(position, np.array([[1.0, 0, 0]] * 2), columns | angle, labels))
    assert turned is not None
    assert [turned.position[a].tolist() for a in "XYZ"] == [[14.0, 8.0], [6.0, 10.0], [7.0, 8.0]]
    assert [turned.columns[n].tolist() for n in ("nx", "ny", "nz")] == [[0.0, -1.0], [1.0, 0.0], [0.0, 0.0]]
    assert np.degrees(turned.columns["probe_angle_rad"]).round(9).tolist() == [120.0, 90.0]
    assert turned.labels["pose"].tolist() == ["a turned", "a turned"]


def test_what_has_no_name_is_looked_at_closely():
    """60 places both ways at 10 s a touch: 20 minutes."""
    case = make.make((), 0.0, 11)
    problem = make_problem(case.recording, make.machine())
    (step,) = steps_for_unknown(problem, Unknown(("X",), "a dependence on X", 0.0))
    assert step.separates == ("unknown", "X")
    assert step.minutes == 20.0
    x = problem.run.position["X"]
    assert f"measure X from {x.min():.4g} to {x.max():.4g} in steps of" in step.do
    assert steps_for_unknown(problem, None) == ()
    assert "three values" in steps_for_unknown(problem, Unknown(("temp_air",), "", 0.0))[0].do


def test_a_rival_that_the_rows_do_not_resolve_has_a_next_step_too():
    """Lobes that were touched from too few directions are no candidate; the catalogue says what confirms the answer."""
    option = Option(BY_NAME["tip_form"](), np.ones((3, 1)), np.ones(1), ("a",), 0.0)
    term = SelectedTerm(Family("tip_form", {}, (option,)), option, option.columns)
    alone = Selection((term,), None, np.zeros(3), np.zeros(3))
    place = Standing(9.0, 0.98, ("probe_lobing",), ())
    problem = cast(
        Problem, SimpleNamespace(run=Run({"X": np.zeros(3)}, np.zeros((3, 3))))
    )  # its axes alone are asked
    (step,) = next_steps(problem, cast(Setting, None), alone, [place])
    assert step.separates == ("tip_form", "probe_lobing")
    assert step.do == "turn the stylus by 90 degrees and touch a sphere again"
    assert next_steps(cast(Problem, None), cast(Setting, None), alone, [Standing(9.0, 0.98, (), ())]) == ()
