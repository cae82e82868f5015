"""All tolerances of a part together, where a known bias is left in or taken off: no whole is surer than its least sure member."""

from __future__ import annotations

import re
from pathlib import Path

import numpy as np
import pytest
from scipy.stats import norm

from vcmm.answer.evaluation import inversion
from vcmm.answer.evaluation.jointly import TRIALS, _common
from vcmm.answer.evaluation.truth import Additive
from vcmm.answer.inference.given_points import GivenPoints, GivenValue
from vcmm.answer.inference.job import EvaluatedPart, evaluate_points, evaluate_values
from vcmm.files.own.scenario import load_scenario
from vcmm.task.measuring.scenario import Scenario

TEXT = """
vcmm = "scenario/1"
name = "warm bar"
[machine]
name = "m"
structure = "w b Y X Z t"
axes.X = { travel = ["0 mm", "600 mm"] }
axes.Y = { travel = ["0 mm", "500 mm"] }
axes.Z = { travel = ["-400 mm", "0 mm"] }
repeatability = { law = "normal", u = "0.9 um" }
[part]
expansion = "11.5 um/(m K)"
[part.features]
left = { type = "plane", point = "0 0 0 mm", normal = [-1, 0, 0], size = "40 40 mm" }
right = { type = "plane", point = "200 0 0 mm", normal = [1, 0, 0], size = "40 40 mm" }
bore = { type = "circle", point = "60 0 10 mm", axis = [0, 0, 1], diameter = "30 mm", inside = true }
CHARACTERISTICS
[pose]
shift = "100 250 -300 mm"
[plan]
styli.down = { offset = "0 0 -80 mm", tip_diameter = "4 mm" }
[[plan.steps]]
feature = "left"
stylus = "down"
points = { strategy = "grid", n = [3, 3], margin = "5 mm" }
[[plan.steps]]
feature = "right"
stylus = "down"
points = { strategy = "grid", n = [3, 3], margin = "5 mm" }
[[plan.steps]]
feature = "bore"
stylus = "down"
points = { strategy = "even", n = 24 }
[environment]
temperature = { part = "22 degC" }
[job]
trials = 2000
known_bias = "BIAS"
rule = "RULE"
"""
LENGTH = 'name = "len"\ntype = "distance"\nbetween = ["left", "right"]\nlimits = ["-0.004 mm", "0.004 mm"]'
BORE = 'name = "dia"\ntype = "size"\nof = "bore"\nlimits = ["0 mm", "0.021 mm"]'
ROUND = 'name = "round"\ntype = "roundness"\nof = "bore"\nzone = "0.006 mm"'


def bar(folder: Path, bias: str, *wanted: str, rule: str = "probability 95 %") -> Scenario:
    tables = "\n".join(f"[[part.characteristics]]\n{one}" for one in wanted)
    text = TEXT.replace("CHARACTERISTICS", tables).replace("BIAS", bias).replace("RULE", rule)
    (folder / "bar.toml").write_text(text, encoding="utf-8")
    return load_scenario(folder / "bar.toml")


def read(scenario: Scenario, **values: float) -> EvaluatedPart:
    (part,) = evaluate_values(
        scenario, [[GivenValue("", n, v, False, False, "v.csv:2") for n, v in values.items()]]
    )
    return part


def touched(scenario: Scenario, seed: int) -> EvaluatedPart:
    """Points of a bar 3.5 um too long, of a bore 8 um too large, with scatter of 0.9 um."""
    task = scenario.task()
    points, normals = task.touches.points.copy(), task.touches.normals
    names = np.array([n for n in scenario.part.features for _ in range(9 if n != "bore" else 24)])
    points[names == "right", 0] += 0.0035
    out = np.random.default_rng(seed).normal(0.0, 0.9e-3, len(points)) + np.where(names == "bore", -0.004, 0)
    given = GivenPoints(
        "", points + out[:, None] * normals, tuple(f"p.csv:{i}" for i in range(len(points))), tuple(names)
    )
    (part,) = evaluate_points(scenario, [given])
    return part


def test_the_bias_of_a_warm_bar_is_in_the_whole_as_in_its_members(tmp_path: Path) -> None:
    """2 K warmer: 200 mm x 11.5 um/m/K x 2 K = 4.6 um too long. Read as 200 mm it is 4.6 um too short; u of the difference of two means
    of nine touches = 0.9 sqrt(2 / 9) = 0.424 um, so it lies above -4 um with Phi((-4.6 + 4) / 0.424) = 7.9 %. The bore is in the
    middle of its limits: the whole is as sure as the length.
    """
    part = read(bar(tmp_path, "reported", LENGTH, BORE), len=200.0, dia=30.0105)
    by_hand = norm.cdf((-4.6 + 4.0) / (0.9 * np.sqrt(2 / 9)))
    assert part["len"].result.decision.p_conform == pytest.approx(by_hand, abs=0.002)
    joint = part.joint
    assert joint.least == pytest.approx(by_hand, abs=5 * np.sqrt(by_hand / TRIALS))
    assert joint.most == pytest.approx(joint.least, abs=1e-12)
    assert joint.decision == "undecided"


def test_a_true_value_within_and_a_reading_without(tmp_path: Path) -> None:
    """Read 4.6 um too long the bar is right: kept with Phi(4 / 0.424) - Phi(-4 / 0.424) = 1. Nothing is decided all the same: values off by
    4.6 um the other way would lie 9.2 um out (JCGM 100, F.2.4.5). Taken off, the bias decides nothing.
    """
    left = read(bar(tmp_path, "reported", LENGTH, BORE), len=200.0046, dia=30.0105)
    assert left.joint.least == pytest.approx(1.0, abs=1e-4)
    assert (left["len"].result.decision.text, left.joint.decision) == ("undecided", "undecided")
    off = read(bar(tmp_path, "corrected", LENGTH, BORE), len=200.0046, dia=30.0105)
    assert (off["len"].result.decision.text, off.joint.decision) == ("conforms", "conforms")


def test_the_guard_band_of_a_member_holds_for_the_whole(tmp_path: Path) -> None:
    """By U: the length reads 2 um off with U = 0.83 + 4.6 um, beyond the limit of 4 um: neither it nor the whole is decided."""
    part = read(bar(tmp_path, "reported", LENGTH, BORE, rule="guard band U"), len=200.002, dia=30.0105)
    assert (part["len"].result.decision.text, part.joint.decision) == ("undecided", "undecided")


@pytest.mark.parametrize("bias", ["reported", "corrected"])
@pytest.mark.parametrize("by_points", [False, True])
@pytest.mark.parametrize("wanted", [(LENGTH, BORE), (LENGTH, BORE, ROUND)])
def test_no_whole_is_surer_than_its_members(
    tmp_path: Path, monkeypatch: pytest.MonkeyPatch, bias: str, by_points: bool, wanted: tuple[str, ...]
) -> None:
    """The draws of one member alone give its own probability again, and the whole lies between the bounds of Frechet; each to five
    standard deviations of the draws and the error of a law as a table (0.2 %).
    """
    monkeypatch.setattr(inversion, "PARTS", (3000, 3000))
    monkeypatch.setattr(inversion, "COUNT_TRIALS", (300, 300))
    scenario = bar(tmp_path, bias, *wanted)
    readings = {"len": 200.0003, "dia": 30.0075, "round": 0.003}
    names = [re.findall('name = "(.*)"', one)[0] for one in wanted]
    part = touched(scenario, 5) if by_points else read(scenario, **{n: readings[n] for n in names})
    kept = [e for e in part.characteristics if e.result.decision.p_conform is not None]
    assert len(kept) >= 2 or by_points
    for e in kept:
        p = e.result.decision.p_conform
        if isinstance(e.result.truth, Additive):
            alone = _common(part.uncertainty.model, [(e.result, e.measured)], part.uncertainty.seed)
            assert alone.true == pytest.approx(p, abs=5 * np.sqrt(p * (1 - p) / TRIALS) + 2e-3), e.name
            reach = e.result.truth.state(
                e.measured, 0.95, "symmetric", tuple(e.result.tolerance)
            ).p_reach or (p, p)
            assert alone.least <= reach[0] + 5e-3
            assert alone.beyond >= reach[1] - 5e-3
    joint = part.joint
    if not joint.reason:
        p = [e.result.decision.p_conform for e in kept]
        assert joint.most <= min(p) + 1e-12
        assert joint.least >= 1 - sum(1 - x for x in p) - 5e-3
        assert joint.least <= joint.most
