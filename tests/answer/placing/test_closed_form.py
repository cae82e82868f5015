"""The closed form at many poses against the evaluation of one pose, and the shortcuts it rests on."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.answer.placing.cases import plate, with_field
from vcmm.answer.evaluation.linear import build
from vcmm.answer.placing.closed_form import ClosedForm
from vcmm.answer.placing.fixture_boxes import boxes, default_fixture
from vcmm.answer.placing.objective import Uncertain
from vcmm.answer.placing.rows import Rows
from vcmm.answer.placing.travels import Travels
from vcmm.core.effect import basis, projected_basis
from vcmm.core.inputs import Input
from vcmm.core.kinematics import Axis, Motion, link_frames, parse_structure, sensitivity, tip_motion
from vcmm.core.laws import Normal
from vcmm.core.run import Run
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario
from vcmm.physics.catalogue.backlash import Backlash
from vcmm.task.measuring.fixture import Goal, pose_of, six_of


def drawn(scenario, count, seed=0):
    """Feasible poses (count, 6)."""
    box = boxes(default_fixture(), six_of(scenario.pose), Travels(Rows.of(scenario)))[0]
    return box.poses(np.random.default_rng(seed).random((count, box.d)))[0]


def cases(tmp_path):
    shipped = load_scenario(example("plate"))
    axis = replace(shipped.machine, effects=(*shipped.machine.effects, Backlash("X", gap=1e-3)))
    backlash = Input("backlash", "X", "gap", Normal(2e-4), "stylus")
    return {
        "shipped": shipped,
        "gaska": load_scenario(example("gaska2014")),
        "field": with_field(plate(tmp_path), 1),
        "touch": with_field(plate(tmp_path), 1, "touch"),
        "backlash": replace(shipped, machine=replace(axis, inputs=(*axis.inputs, backlash))),
    }


@pytest.mark.parametrize("name", ["shipped", "gaska", "field", "touch", "backlash"])
def test_variances_are_those_of_the_task_at_each_pose(tmp_path, name):
    """u of every influence and of the products at a few poses, against G of the task placed there.

    The fit operator is that of the perfect part: errors of some um on tens of mm change it by 1e-4 at most.
    """
    scenario = cases(tmp_path)[name]
    closed = ClosedForm.of(Rows.of(scenario))
    objective = Uncertain(closed, Goal())
    smooth = list(objective.smooth)
    six = drawn(scenario, 4)
    first, second = closed.variances(six, objective.gradient_rows)
    for j, row in enumerate(six):
        model = build(scenario.at(pose_of(row)).task())
        gradient = model.gradient()[smooth]
        wanted = np.array(
            [[((g @ t.gain) ** 2).sum() * np.max(t.law.u) ** 2 for t in model.terms()] for g in gradient]
        )
        scale = np.sqrt(wanted.sum(axis=1, keepdims=True))
        assert np.abs(np.sqrt(first[j, smooth]) - np.sqrt(wanted)).max() < 1e-4 * scale.max()
        product = np.zeros(len(smooth))
        for p in model.products:
            u = [
                float(
                    np.max(model.influences[i].input.law.u)
                    * np.abs(model.influences[i].input.spread(1)[1]).max()
                )
                for i in (p.first, p.second)
            ]
            for _, _, gain in model.product_gains(p):
                product += (gradient @ gain * u[0] * u[1]) ** 2
        assert np.abs(np.sqrt(second[j, smooth]) - np.sqrt(product)).max() < 1e-4 * scale.max()


def test_rows_are_those_of_the_plan(tmp_path):
    """Every column, sense and speed of the plan placed at a pose, bit for bit up to rounding."""
    scenario = cases(tmp_path)["backlash"]
    rows = Rows.of(scenario)
    six = drawn(scenario, 3)
    run = rows.run(six)
    for j, row in enumerate(six):
        wanted = scenario.at(pose_of(row)).task().touches.run
        part = run.take(slice(j * rows.n, (j + 1) * rows.n))
        for axis, q in wanted.position.items():
            assert np.allclose(part.position[axis], q, atol=1e-9)
        for column in {*rows.needed_columns, "nx", "ny", "nz", "tip_x_mm", "part_y_mm", "time_s"}:
            assert np.allclose(part.column(column), wanted.column(column), atol=1e-9), column
        assert all((part.labels[k] == v).all() for k, v in wanted.labels.items())


@pytest.mark.parametrize("structure", ["w b Y X Z t", "w Y' b X Z t", "w C' X' b Y Z B t"])
def test_sensed_is_the_transpose_of_tip_motion(structure):
    rng = np.random.default_rng(1)
    chain = parse_structure(structure)
    axes = {a: Axis(a, (-1e3, 1e3), measured_at=(10.0, -20.0, 30.0)) for a in chain.letters}
    run = Run(
        {a: rng.uniform(-1, 1, 5) * (300 if a in "XYZ" else 1) for a in chain.letters},
        rng.normal(size=(5, 3)) * 100,
    )
    direction = rng.normal(size=(5, 3))
    links = [(a, p) for a in chain.letters for p in ("motion", "travel", "location")] + [
        ("tip", "motion"),
        ("tool", "motion"),
    ]
    for link, place in links:
        if (place == "travel") != (link in "XYZ" and place == "travel") or (
            place == "location" and link in "XYZ"
        ):
            continue
        six = rng.normal(size=(5, 6))
        if place == "travel" or link in ("tip", "tool"):
            six[:, :3] *= link in ("tip", "tool")
            six[:, 3:] *= place == "travel"
        moved = tip_motion(chain, axes, run, [Motion(link, place, six)])[:, :3]
        seen = sensitivity(link_frames(chain, axes, run), axes, run, (link, place), direction)
        assert np.allclose((moved * direction).sum(axis=1), (seen * six).sum(axis=1), rtol=1e-12), (
            link,
            place,
        )


def test_projected_responses_are_weights_times_responses(tmp_path):
    """The shortcut of effects with many nodes against the full response."""
    for scenario in (cases(tmp_path)["gaska"], cases(tmp_path)["field"]):
        run = Rows.of(scenario).run(drawn(scenario, 2))
        weights = np.random.default_rng(0).normal(size=(run.n, 6))
        weights[:, 3:] = 0.0
        for effect in scenario.machine.effects:
            if effect.name in ("residual_field", "correlated_field"):
                wanted = np.einsum("ni,nik->nk", weights, basis(effect, "values", run))
                assert np.allclose(projected_basis(effect, "values", run, weights), wanted, atol=1e-12)
