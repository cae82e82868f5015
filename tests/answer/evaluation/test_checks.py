"""Remarks on a scenario."""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from tests.build import scenario
from vcmm.answer.evaluation.checks import remarks
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.physics.structure.expansion import ScaleExpansion
from vcmm.task.measuring.qualification import Qualification

QUALIFIED = {"down": Qualification()}


def test_nothing_to_say():
    assert remarks(replace(scenario(), qualifications=QUALIFIED)) == ()


def test_a_stylus_that_was_not_qualified():
    (text,) = remarks(scenario())
    assert text.startswith("stylus down: tip radius and offset are taken as exactly known")


def test_a_temperature_without_effect():
    one = replace(scenario(constants={"temp_part_C": 22.0, "temp_gradient_C": 0.0}), qualifications=QUALIFIED)
    assert remarks(one) == (
        "the temperature part = 22 has no effect: nothing in the machine or part depends on it; add [part] expansion",
    )


def test_a_temperature_taken_as_known():
    constants = {"temp_scale_x_C": 22.0, "reading_scale_x_C": 22.0}
    one = replace(scenario(ScaleExpansion("X", 1e-5), constants=constants), qualifications=QUALIFIED)
    assert any("scale_x is taken as exactly known" in text for text in remarks(one))
    known = replace(one, inputs=(Input("channel", "", "temp_scale_x_C", Normal(0.1)),))
    assert remarks(known) == ()


def test_a_stylus_shorter_than_the_bore_is_deep():
    job = replace(scenario(), qualifications=QUALIFIED)
    short = replace(job.plan.styli["down"], offset=np.array([0.0, 0.0, -5.0]), length=5.0)
    (text,) = remarks(replace(job, plan=replace(job.plan, styli={"down": short})))
    # the bore is 20 mm long from z = 0; levels at 5 and 15 mm, the deeper one 15 mm below the mouth
    assert text.startswith("bore: touches 15 mm deep with stylus down, which is 5 mm long")


def test_a_short_stylus_in_a_bore_whose_axis_points_down_or_that_is_entered_from_below():
    """The same bore from z = 0 to 20, 100 mm higher, its axis down: the mouth under the head is at 120, the level at 105 lies 15 mm below
    it. From below (head under the part, axis down) the mouth is at 100, and the level at 115 lies 15 mm above it."""
    job = replace(scenario(), qualifications=QUALIFIED)
    down = replace(
        job.part.features["bore"], point=np.array([0.0, 0.0, 120.0]), axis=np.array([0.0, 0.0, -1.0])
    )
    step = replace(job.plan.steps[0], points=job.plan.steps[0].points + np.array([0.0, 0.0, 100.0]))
    for offset in (-5.0, 5.0):
        short = replace(job.plan.styli["down"], offset=np.array([0.0, 0.0, offset]), length=5.0)
        plan = replace(job.plan, steps=(step,), styli={"down": short})
        part = replace(job.part, features=dict(job.part.features) | {"bore": down})
        (text,) = [t for t in remarks(replace(job, part=part, plan=plan)) if "deep with stylus" in t]
        assert text.startswith("bore: touches 15 mm deep with stylus down, which is 5 mm long")


def test_the_mouth_is_the_end_where_the_head_stands():
    """Only the level 15 mm below the upper mouth of the bore, 5 mm above the lower one; a stylus of 6 mm reaches it from below alone."""
    job = replace(scenario(), qualifications=QUALIFIED)
    step = job.plan.steps[0]
    deep = np.isclose(step.points[:, 2], 5.0)  # of a bore from z = 0 to 20
    step = replace(step, points=step.points[deep], normals=step.normals[deep])
    texts = {}
    for offset in (-6.0, 6.0):
        short = replace(job.plan.styli["down"], offset=np.array([0.0, 0.0, offset]), length=6.0)
        plan = replace(job.plan, steps=(step,), styli={"down": short})
        texts[offset] = [t for t in remarks(replace(job, plan=plan)) if "deep with stylus" in t]
    assert [t[:26] for t in texts[-6.0]] == ["bore: touches 15 mm deep w"]
    assert texts[6.0] == []


def test_a_normal_into_the_material():
    job = replace(scenario(), qualifications=QUALIFIED)
    step = job.plan.steps[1]
    inward = replace(step, normals=np.tile([0.0, 0.0, -1.0], (len(step.points), 1)))
    (text,) = remarks(replace(job, plan=replace(job.plan, steps=(inward,))))
    assert "left: its normal points away from the head of stylus down" in text


def test_nodes_that_are_drawn_independently_are_said():
    """A field written in the old way, also with one u for all nodes: every result says that U is too small between them."""
    one = replace(scenario(), qualifications=QUALIFIED)
    for scale in (None, np.full(24, 2.0)):
        known = Input("residual_field", "", "values", Normal(1e-3), "touch", scale=scale)
        (text,) = remarks(replace(one, machine=replace(one.machine, inputs=(known,))))
        assert "variance shrinks between them: U is too small there" in text
        assert "calibrate --nodes" in text
