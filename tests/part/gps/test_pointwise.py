"""Profile of a surface that only a mesh describes, by hand."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.build import scenario
from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.answer.inference.job import EvaluatedCharacteristic, EvaluatedPart
from vcmm.part.mesh import Mesh
from vcmm.part.part import Characteristic, Feature, Part
from vcmm.show.pages.sheet import in_words
from vcmm.show.tables.evaluation import part_table, values_csv
from vcmm.task.measuring.explicit import on_surface
from vcmm.task.measuring.plan import Plan, Step
from vcmm.task.measuring.settings import Settings
from vcmm.task.measuring.strategies import Grid, plan_points
from vcmm.task.measuring.task import evaluate_all, fit_features, measured_points

CORNERS = np.array([[-30.0, -30, 20], [30, -30, 20], [30, 30, 26], [-30, 30, 26]])  # rises by a tenth along y
SLOPE = Mesh(CORNERS, np.array([[0, 1, 2], [0, 2, 3]]))
FREE = Feature("free", "mesh", np.zeros(3), np.zeros(3), np.zeros(0))
TOUCHED = np.array([[x, y, 23 + y / 10] for x, y in ((-20, -19), (20, -19), (20, 19), (-20, 19), (0, 0.0))])


def faces() -> list[Feature]:
    at = {"low": [0, 0, -1], "side": [1, 0, 0], "front": [0, -1, 0]}
    return [
        Feature(n, "plane", 40.0 * np.array(d, float), np.array(d, float), np.zeros(0), extent=(60.0, 60.0))
        for n, d in at.items()
    ]


def sloping(**more):
    """Five touches on the slope, of which the middle one lies 3 um further out."""
    base, planes = scenario(), faces()
    steps = [Step("free", "down", *on_surface(FREE, TOUCHED, mesh=SLOPE))]
    steps += [Step(f.name, "down", *plan_points(f, Grid((2, 2), 5.0))) for f in planes]
    c = Characteristic("profile", "surface_profile", of=("free",), **more)
    part = Part({f.name: f for f in (FREE, *planes)}, (c,), mesh=SLOPE)
    task = replace(base, part=part, plan=Plan(tuple(steps), base.plan.styli)).task()
    form = np.zeros(task.touches.run.n)
    form[4] = 3e-3
    return replace(task, form=form)


@pytest.mark.parametrize(
    ("more", "expected"),
    [
        ({"datums": ("low", "side", "front")}, 6.0),  # nothing is free: 2 x 3 um
        ({}, 4.8),  # the plane of the five lies 0.6 um higher: 2 x 2.4 um
        ({"criterion": "C"}, 3.0),  # half way: 2 x 1.5 um
    ],
)
def test_profile_of_a_mesh_by_hand(more, expected):
    task = sloping(**more)
    points = measured_points(task, np.zeros((task.touches.run.n, 3)))
    assert 1e3 * evaluate_all(task, fit_features(task, points))[0] == pytest.approx(expected, rel=2e-4)


def test_no_forms_are_drawn_on_a_mesh_so_nothing_is_claimed():
    found = evaluate(sloping(datums=("low", "side", "front"), zone=0.02), Settings(trials=2000, certify=0))
    (c,) = found.characteristics
    assert c.u > 0.3e-3
    assert (c.coverage_shown, c.decision.text) == (False, "undecided")
    assert "no forms are drawn on a mesh" in c.why_not_shown
    # and the words say so: how the indicated value scatters is no interval of the true one
    told = EvaluatedPart("", (EvaluatedCharacteristic(c, c.value),), found, ())
    table = part_table(told)
    assert "interval from nominal" in {str(column.head) for column in table.columns}
    assert "true value" not in table.title
    assert values_csv([told]).splitlines()[1].split(",")[4:6] == ["", ""]
    assert "nothing is claimed of the true value" in in_words(told.characteristics[0])
