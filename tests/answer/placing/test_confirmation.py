"""The gain as counted from trials, by hand on a few of them."""

from __future__ import annotations

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from tests.build import DIAMETER, scenario
from vcmm.answer.placing.confirmation import Confirmation, _count_risk, _value, fresh_seed
from vcmm.task.measuring.fixture import Goal


def test_a_gain_must_exceed_twice_its_standard_error():
    one = Confirmation(seed=1, trials=10, present=3.0, best=2.0, gain=1.0, u_gain=0.49)
    assert one.is_confirmed
    assert not replace(one, u_gain=0.51).is_confirmed
    assert fresh_seed(1) != fresh_seed(2)


def objective(mixture, **more):
    job = scenario(characteristics=(DIAMETER,))
    job = replace(job, settings=replace(job.settings, p=0.9, rule="guard band U"))
    goal = Goal(mixture, {"diameter": 1.0}, more.pop("costs", {}), {"diameter": (0.0, 0.005)})
    return SimpleNamespace(
        scenario=job, characteristics=(DIAMETER,), weights={"diameter": 0.5}, goal=goal, needs_bias=more.get("bias", True)
    )  # fmt: skip


def test_u_is_half_the_interval():
    """Of 0 to 100 in steps of 1, 90 % lie between 5 and 95: U = 45, weighted by half; over T = 0.02 it is fifty times that."""
    y, rng = np.arange(101.0)[:, None], np.random.default_rng(0)
    assert _value(objective({"U": 1.0}), y, np.zeros(1), rng) == pytest.approx(0.5 * 45.0)
    assert _value(objective({"U/T": 1.0}), y, np.zeros(1), rng) == pytest.approx(0.5 * 45.0 / 0.02)


def test_decisions_by_hand():
    """Limits +-10 um, guard band 2 um, parts at 0, 5 and 15 um, indicated at 0, 13 and 11 um: right, good rejected, undecided."""
    error, standard = np.array([0.0, 0.008, -0.004]), np.array([0.0, 1.0, 3.0])
    known = {"error": error, "u": 0.001, "expanded": 0.002, "standard": standard}
    assert _count_risk(objective({"risk": 1.0}), 0, "risk", **known) == pytest.approx(2 / 3)
    costs = objective({"cost": 1.0}, costs={"accept_bad": 100.0, "reject_good": 30.0, "undecided": 6.0})
    assert _count_risk(costs, 0, "cost", **known) == pytest.approx((30.0 + 6.0) / 3)


def test_a_corrected_bias_does_not_count():
    """All errors alike: once they are taken off, every part is judged by its true value."""
    known = {"error": np.full(3, 0.009), "u": 0.001, "expanded": 0.002, "standard": np.array([0.0, 1.0, 3.0])}
    assert _count_risk(objective({"risk": 1.0}, bias=False), 0, "risk", **known) == 0.0
    assert _count_risk(objective({"risk": 1.0}), 0, "risk", **known) > 0.0
