"""Several tolerances judged together, against quadrature by hand."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import norm

from tests.build import scenario
from vcmm.answer.evaluation.indication import at_indication
from vcmm.answer.evaluation.jointly import judged_jointly
from vcmm.answer.evaluation.linear import build
from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.core.errors import ModelLimit
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.part.part import Characteristic, Feature, Part
from vcmm.task.measuring.plan import Plan, Step
from vcmm.task.measuring.settings import Settings
from vcmm.task.measuring.strategies import Around, plan_points

QUICK = Settings(trials=5000, certify=20)
RINGS = [
    Feature(n, "circle", np.array([x, 0.0, 0]), np.array([0.0, 0, 1]), np.array([15.0]), inside=True)
    for n, x in (("a", 0.0), ("b", 50.0))
]


def rings(redraw: str, n: int = 4, extra: tuple[Characteristic, ...] = ()):
    base = scenario(inputs=(Input("scatter", "", "value", Normal(1e-3), redraw),))
    wanted = tuple(
        Characteristic(f"size {r.name}", "size", of=(r.name,), limits=(-0.01, 0.01)) for r in RINGS
    )
    steps = tuple(Step(r.name, "down", *plan_points(r, Around(n))) for r in RINGS)
    return replace(
        base, part=Part({r.name: r for r in RINGS}, (*wanted, *extra)), plan=Plan(steps, base.plan.styli)
    )


def judged(redraw: str, off: float):
    result = evaluate(rings(redraw).task(), QUICK)
    found = [at_indication(c, 30.0 + off, QUICK.rule) for c in result.characteristics]
    return judged_jointly(result.model, found, [30.0 + off] * 2, 1)


def test_what_is_shared_and_what_is_not():
    """Radius off by 1 um at all touches of a machine: both diameters have u = 2 um and err together, so both conform when one does.

    By touch: u = 2 / sqrt(4) um each, independent. Read 1 u inside the upper limit, one conforms with 84.13 %.
    """
    one = float(norm.cdf(1.0))
    shared = judged("machine", 0.01 - 2e-3)
    assert shared.least == shared.most == pytest.approx(one, abs=0.005)
    assert shared.independent == pytest.approx(one**2, abs=0.001)
    apart = judged("touch", 0.01 - 1e-3)
    assert apart.least == pytest.approx(one**2, abs=0.005)
    assert apart.decision == "undecided"
    assert judged("touch", 0.0).decision == "conforms"
    assert judged("touch", 0.02).decision == "does not conform"


def test_a_wide_uncertainty_rejects_neither_a_size_nor_the_part():
    """Limits of 30 um +-0.02 um, u = 1 um each: P(-0.02 < z < 0.02) = 0.016; read at nominal nothing is proved, 1.7 u above the limit it is.
    1.6 u above it neither size is decided, P = 0.055; the part is, 0.055^2 = 0.003.
    """
    base = rings("touch")
    wanted = tuple(replace(c, limits=(-2e-5, 2e-5)) for c in base.part.characteristics)
    result = evaluate(replace(base, part=replace(base.part, characteristics=wanted)).task(), QUICK)

    def decide_at(y: float) -> tuple[list[str], str]:
        parts = [at_indication(c, y, QUICK.rule) for c in result.characteristics]
        joint = judged_jointly(result.model, parts, [y, y], 1)
        assert joint is not None
        assert parts[0].decision.p_conform < 0.05
        return [c.decision.text for c in parts], joint.decision

    assert decide_at(30.0) == (["undecided"] * 2, "undecided")
    assert decide_at(30.0 + 2e-5 + 1.6e-3) == (["undecided"] * 2, "does not conform")
    assert decide_at(30.0 + 2e-5 + 1.7e-3) == (["does not conform"] * 2, "does not conform")


def test_values_within_their_limits_reject_no_part():
    """u = 1 um each. Limits +-0.2 um, read at nominal: P = 0.1585 for one, 0.025 for both, and yet nothing is proved. With the guard band
    U = 2 u even less is. Both read 1 u above the limit: (1 - 0.8413)^2 = 0.025, and both so by chance is too rare.
    """
    base = rings("touch")
    wanted = tuple(replace(c, limits=(-2e-4, 2e-4)) for c in base.part.characteristics)
    result = evaluate(replace(base, part=replace(base.part, characteristics=wanted)).task(), QUICK)

    def decide_at(y: float, rule: str) -> tuple[set[str], str]:
        parts = [at_indication(c, y, rule) for c in result.characteristics]
        joint = judged_jointly(result.model, parts, [y, y], 1)
        assert joint is not None
        assert joint.most < 0.05
        return {c.decision.text for c in parts}, joint.decision

    assert decide_at(30.0, QUICK.rule) == ({"undecided"}, "undecided")
    assert decide_at(30.0, "guard band U") == ({"undecided"}, "undecided")
    assert decide_at(30.0 + 2e-4 + 1e-3, QUICK.rule) == ({"undecided"}, "does not conform")


def test_an_extreme_value_gives_bounds():
    round_ = Characteristic("round", "roundness", of=("a",), zone=0.02)
    result = evaluate(rings("touch", 25, (round_,)).task(), QUICK)
    read = [30.009, 30.0, 0.012]
    found = [at_indication(c, y, QUICK.rule) for c, y in zip(result.characteristics, read)]
    joint = judged_jointly(result.model, found, read, 1)
    p = [c.decision.p_conform for c in found]
    assert joint.least == pytest.approx(1 - sum(1 - x for x in p), abs=0.005)
    assert joint.most == pytest.approx(min(p), abs=0.005)
    hidden = [replace(found[0], decision=replace(found[0].decision, p_conform=None)), *found[1:]]
    told = judged_jointly(result.model, hidden, read, 1)
    assert (told.decision, told.reason) == ("undecided", "coverage is not demonstrated of size a")
    assert math.isnan(told.least)
    assert judged_jointly(result.model, found[:1], read[:1], 1) is None


def test_a_scan_of_too_many_points_for_its_form():
    round_ = Characteristic("round", "roundness", of=("a",), zone=0.02)
    with pytest.raises(ModelLimit, match="take at most 3000 of them"):
        build(rings("machine", 3001, (round_,)).task())


def test_what_is_drawn_for_one_part_serves_all_of_a_batch(monkeypatch):
    """Two parts of one model: the machines are drawn once, and each part has the number that it has alone."""
    from vcmm.answer.evaluation import jointly

    asked, draw = [], jointly.simulate
    monkeypatch.setattr(jointly, "simulate", lambda *a, **k: asked.append(1) or draw(*a, **k))
    result = evaluate(rings("machine").task(), QUICK)
    both = []
    for off in (0.004, 0.0095):
        found = [at_indication(c, 30.0 + off, QUICK.rule) for c in result.characteristics]
        both.append(judged_jointly(result.model, found, [30.0 + off] * 2, 1).least)
    assert len(asked) == 1
    assert both == [judged("machine", 0.004).least, judged("machine", 0.0095).least]
