"""The objective: goals that suit the part, coverage factors, risk and cost."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest

from tests.answer.placing.cases import plate, with_field
from tests.build import DIAMETER, FORM, LENGTH
from tests.build import scenario as build_scenario
from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.answer.placing.confirmation import _batches
from vcmm.answer.placing.objective import Uncertain, complete, exact_terms, process, width
from vcmm.core.errors import UsageError
from vcmm.files.own.library import example
from vcmm.files.own.scenario import load_scenario
from vcmm.task.measuring.fixture import Goal, six_of


def test_risk_and_cost_objectives(tmp_path):
    """What the closed form integrates is what the confirmation counts; a cost is prices times probabilities."""
    scenario, weights = with_field(plate(tmp_path), 3), {"bore diameter": 1.0}
    six = six_of(scenario.pose)
    risk = Uncertain.of(scenario, Goal({"risk": 1.0}, weights))
    judged = risk.wrong_decisions(0, risk.spread(six[None]))
    assert risk.values(six[None])[0] == pytest.approx(judged.total[0])
    counted = _batches(risk, six, 7, 30)  # 150 000 trials of a probability of 0.4 %: 4 % by chance
    assert counted.mean() == pytest.approx(judged.total[0], rel=0.12)
    cost = Uncertain.of(scenario, Goal({"cost": 1.0}, weights, {"accept_bad": 100.0, "undecided": 2.0}))
    assert cost.values(six[None])[0] == pytest.approx(100 * judged.accept_bad[0] + 2 * judged.no_decision[0])


def test_goals_that_do_not_suit_the_part(tmp_path):
    scenario = plate(tmp_path)
    with pytest.raises(UsageError, match='"bore to front" has no two-sided tolerance'):
        complete(scenario, Goal({"U/T": 1.0}, {"bore to front": 1.0}))
    assert complete(scenario, Goal()).mixture == {"U/T": 1.0}
    assert complete(scenario, Goal()).weights == {"bore diameter": 0.5, "bore square to top": 0.5}
    with pytest.raises(UsageError, match="cannot be mixed"):
        complete(scenario, Goal({"U": 0.5, "risk": 0.5}, {"bore diameter": 1.0}))


def test_scenario_without_characteristics_or_inputs(tmp_path):
    from dataclasses import replace

    scenario = plate(tmp_path)
    bare = replace(scenario, part=replace(scenario.part, characteristics=()))
    with pytest.raises(UsageError, match="has no characteristics"):
        Uncertain.of(bare)


@pytest.mark.thorough
def test_factor_k_and_u_at_the_present_pose_are_those_of_the_evaluation():
    scenario = load_scenario(example("plate"))
    objective = Uncertain.of(scenario)
    found = objective.spread(six_of(scenario.pose)[None])
    result = evaluate(scenario.task(), replace(scenario.settings, trials=50_000))
    for i, c in enumerate(result.characteristics):
        share = 1e-3 if i in objective.smooth else 0.02  # an extreme value: 128 common draws
        spread = (
            c.summary.u if c.extreme else c.u
        )  # the search compares spreads of what a perfect part indicates
        assert found.u[0, i] == pytest.approx(spread, rel=share)
    terms = exact_terms(objective.closed, objective.gradient_rows[0], six_of(scenario.pose))
    first, second = objective.closed.variances(six_of(scenario.pose)[None], objective.gradient_rows)
    assert sum(float((t.gain**2).sum()) * t.law.u**2 for t in terms) == pytest.approx(
        first[0, 0].sum(), rel=1e-9
    )
    assert first[0, 0].sum() + second[0, 0] == pytest.approx(found.u[0, 0] ** 2, rel=1e-12)
    assert objective.factors[0] == pytest.approx(result.characteristics[0].k, rel=1e-3)


def test_widths_and_processes_by_hand():
    """A size of -10 to +10 um: T = 20 um, parts about the middle with T/6; a form of 10 um: 0 to 10 um."""
    assert width(DIAMETER) == pytest.approx(0.02)
    assert width(FORM) == pytest.approx(0.01)
    assert process(DIAMETER, Goal(), 30.0) == pytest.approx((0.0, 0.02 / 6))
    assert process(FORM, Goal(), 0.0) == pytest.approx((0.005, 0.01 / 6))
    stated = Goal(process={"diameter": (0.001, 0.004)})
    assert process(replace(DIAMETER, limits=(0.0, 0.02)), stated, 30.0) == pytest.approx((0.011, 0.004))


def test_a_mixture_by_hand():
    """u = 1 um, k = 1.96 (normal scatter): U/T = 1.96 x 2 um x sqrt(1/16) / 20 um for a diameter of 16 touches."""
    job = build_scenario(characteristics=(DIAMETER, LENGTH))
    share = Uncertain.of(job, Goal({"U/T": 1.0}, {"diameter": 1.0})).values(six_of(job.pose)[None])[0]
    assert share == pytest.approx(1.96 * 2e-3 / 4 / 0.02, rel=1e-3)
    # the mean of four touches on each of two faces: u = 1 um x sqrt(1/4 + 1/4)
    both = Uncertain.of(job, Goal({"U": 1.0}, {"diameter": 0.25, "length": 0.75})).values(
        six_of(job.pose)[None]
    )[0]
    assert both == pytest.approx(1.96 * (0.25 * 0.5e-3 + 0.75 * 1e-3 * np.sqrt(0.5)), rel=1e-3)


def test_units_of_the_value():
    job = build_scenario(characteristics=(DIAMETER, LENGTH))
    assert Uncertain.of(job, Goal({"U": 1.0}, {"length": 1.0})).unit == "mm"
    assert Uncertain.of(job, Goal({"U/T": 1.0}, {"diameter": 1.0})).unit == "1"
    assert Uncertain.of(job, Goal({"cost": 1.0}, {"diameter": 1.0}, {"undecided": 2.0})).unit == "cost"
