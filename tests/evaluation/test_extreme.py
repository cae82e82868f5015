"""True values of form, orientation and location: against Rice's law, by counting, and where nothing may be claimed."""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import pytest
from scipy.stats import rice

from tests.build import BORE, FORM, scenario
from vcmm.core.inputs import Input
from vcmm.core.laws import Normal
from vcmm.effects.squareness import Squareness
from vcmm.evaluation.extreme import Extreme
from vcmm.evaluation.indication import at_indication
from vcmm.evaluation.inverse import Inverted, inverted
from vcmm.evaluation.linear import build
from vcmm.evaluation.uncertainty import evaluate
from vcmm.measuring.plan import Plan, Step
from vcmm.measuring.settings import Settings
from vcmm.measuring.strategies import Around, Grid, Levels, plan_points
from vcmm.part.part import Characteristic, Feature, Part

QUICK = Settings(trials=5000, certify=20)
RING = Feature("ring", "circle", np.zeros(3), np.array([0.0, 0, 1]), np.array([15.0]), inside=True)
TOP = Feature("top", "plane", np.zeros(3), np.array([0.0, 0, 1]), np.zeros(0), extent=(80.0, 80.0))
ROUND = Characteristic("round", "roundness", of=("ring",), zone=0.01)
SQUARE = Characteristic("square", "perpendicularity", of=("bore",), datums=("top",), zone=0.02)


def job(features, patterns, characteristics, *effects, inputs=()):
    base = scenario(*effects, inputs=inputs)
    steps = tuple(Step(f.name, "down", *plan_points(f, p)) for f, p in zip(features, patterns))
    part = Part({f.name: f for f in features}, tuple(characteristics))
    return replace(base, part=part, plan=Plan(steps, base.plan.styli))


def square(*effects, inputs=()):
    return job((BORE, TOP), (Levels((5.0, 15.0), 8), Grid((9, 9), 2.0)), (SQUARE,), *effects, inputs=inputs)


# centres of 8 points at 1 um: sqrt(2 / 8) um; 10 mm apart: 0.0707 um/mm; over 20 mm 1.4142 um, in x and in y;
# the plane of 81 points adds 0.09 um: 1.4171 um
TILT = 1.4171e-3


def test_perpendicularity_follows_rice():
    """|t + e| with e isotropic: quantiles of what is indicated, interval and U from scipy's Rice law."""
    found = evaluate(square().task(), QUICK).characteristics[0]
    table = found.truth
    assert isinstance(table, Inverted)
    for ratio in (0.0, 1.0, 3.0, 8.0):
        true = ratio * TILT
        for got, level in zip(table.ends(true, 0.95), (0.025, 0.975)):
            assert got == pytest.approx(rice.ppf(level, ratio, scale=TILT), abs=0.05 * TILT), (ratio, level)
    # far from zero the tilt across does not matter: U = 1.95996 x 1.4171 um, not that of a perfect part
    assert found.expanded == pytest.approx(1.95996 * TILT, rel=0.03)
    assert found.u == pytest.approx(TILT, rel=0.03)
    perfect = found.summary.interval(0.95)
    assert (perfect[1] - perfect[0]) / 2 == pytest.approx(
        1.244 * TILT, rel=0.03
    )  # Rayleigh: (2.716 - 0.225) / 2


def test_the_interval_begins_at_zero_where_a_perfect_part_indicates_as_much():
    found = evaluate(square().task(), QUICK).characteristics[0]
    near = at_indication(found, 2.0 * TILT, QUICK.rule)
    assert near.true_value.interval[0] == 0.0
    assert near.true_value.estimate < 2.0 * TILT  # the share of the noise is taken off
    far = at_indication(found, 8.0 * TILT, QUICK.rule)
    assert far.true_value.interval == pytest.approx((6.0 * TILT, 9.94 * TILT), rel=0.02)
    assert far.value == 8.0 * TILT  # what was indicated stays beside it
    assert (found.coverage_shown, far.true_value.claimed) == (True, True)


def test_the_decision_holds_its_risk():
    """A part at the limit of 20 um is called good in 5 % of measurements: y is at most the 5 % quantile of Rice's law there."""
    found = evaluate(square().task(), QUICK).characteristics[0]
    edge = rice.ppf(0.05, 20e-3 / TILT, scale=TILT)
    assert at_indication(found, edge - 0.1e-3, QUICK.rule).decision.text == "conforms"
    assert at_indication(found, edge + 0.1e-3, QUICK.rule).decision.text == "undecided"
    assert at_indication(found, 20e-3 + 3 * TILT, QUICK.rule).decision.text == "does not conform"


def test_the_guard_band_is_that_of_the_interval():
    found = evaluate(square().task(), QUICK).characteristics[0]
    high = at_indication(found, 8 * TILT, QUICK.rule).interval[1]
    for share, text in ((0.99, "undecided"), (1.01, "conforms")):
        tight = replace(found, tolerance=(0.0, share * high))
        assert at_indication(tight, 8 * TILT, "guard band U").decision.text == text


def test_a_known_tilt_of_the_machine_is_taken_off():
    # B0Z of 100 urad tilts the bore by 2 um over 20 mm: a perfect part indicates 2 um, and so does one that is tilted by
    # up to 4 um the other way; 6 um are indicated of 4 um (the same way) to 8 um; noise of 0.07 um
    quiet = (Input("scatter", "", "value", Normal(0.05e-3), "touch"),)
    found = evaluate(square(Squareness("B0Z", 100e-6), inputs=quiet).task(), QUICK).characteristics[0]
    assert found.value == pytest.approx(2e-3, rel=0.01)
    assert (found.true_value.interval[0], found.true_value.estimate) == pytest.approx((0.0, 0.0), abs=0.2e-3)
    assert found.true_value.interval[1] < 4.1e-3
    low, high = at_indication(found, 6e-3, QUICK.rule).true_value.interval
    assert 3.8e-3 < low < 4.2e-3
    assert 7.8e-3 < high < 8.2e-3


def counted(characteristic, features, patterns, shape, ratios, count=400):
    """Share of intervals that hold the true value; parts and noise are made here, fits by the least squares of numpy."""
    model = build(job(features, patterns, (characteristic,)).task())
    found = evaluate(model.task, QUICK).characteristics[0]
    rng, points = np.random.default_rng(11), model.task.touches.points
    angle = np.arctan2(points[:, 1], points[:, 0])
    design = np.stack([np.ones_like(angle), np.cos(angle), np.sin(angle)], axis=1)
    out = []
    for ratio in ratios:
        held = 0
        for _ in range(count):
            height = 0.5e-3 * ratio * shape(angle, rng) + 1e-3 * rng.standard_normal(len(angle))
            rest = height - design @ np.linalg.lstsq(design, height, rcond=None)[0]
            low, high = at_indication(found, np.ptp(rest), QUICK.rule).true_value.interval
            held += low <= 1e-3 * ratio <= high
        out.append(held / count)
    return found, out


def test_roundness_by_counting():
    """3 lobes of any phase with peak to valley 0, 2, 6, 20 times the noise: the classic recipe held 0, 0, 1, 42 %."""

    def lobes(angle, rng):
        return np.cos(3 * (angle - rng.uniform(0, 2 * np.pi)))

    found, shares = counted(ROUND, (RING,), (Around(25),), lobes, (0.0, 2.0, 6.0, 20.0))
    assert found.true_value.claimed
    assert all(share >= 0.92 for share in shares), shares  # 400 parts: standard error 1.1 %
    assert np.mean(shares) < 0.985


def test_too_few_points_claim_nothing():
    # 8 angles do not tell 4 lobes from none: the interval is not shown, so nothing is decided
    found = evaluate(job((BORE,), (Levels((5.0, 15.0), 8),), (FORM,)).task(), QUICK).characteristics[0]
    assert not found.coverage_shown
    assert "points hardly meet some forms" in found.decision.reason
    assert (found.decision.text, found.decision.p_conform) == ("undecided", None)
    between = next(b for b in found.budget if b.input.startswith("form[bore]"))
    assert between.redraw == "part"


def test_inverse_of_a_table_by_hand():
    """Indicated values T .. T + 1 evenly: the interval for y is (y - 0.975, y - 0.025), the median y - 0.5."""
    true = np.linspace(0.0, 10.0, 11)
    table = inverted(true, [true[:, None] + (np.arange(2000) + 0.5) / 2000])
    said = table.given(5.0, 0.95, "symmetric", (-np.inf, 4.7))
    assert said.estimate == pytest.approx(4.5, abs=1e-3)
    assert said.interval == pytest.approx((4.025, 4.975), abs=1e-3)
    assert said.p_conform == pytest.approx(0.7, abs=2e-3)  # at T = 4.7 more than 5.0 is indicated in 70 %
    assert table.given(0.5, 0.95, "symmetric").interval == pytest.approx((0.0, 0.475), abs=1e-3)
    assert table.given(20.0, 0.95, "symmetric").interval == pytest.approx(
        (19.025, 19.975), abs=1e-3
    )  # beyond


def test_contact_criteria_are_inverted_too():
    square_x = replace(SQUARE, criterion="X", datum_criterion="T")
    one = job((BORE, TOP), (Levels((5.0, 15.0), 8), Grid((3, 3), 2.0)), (square_x,))
    model = build(one.task())
    extreme = Extreme(model.only(0), model.terms(), QUICK, 0.02)
    assert extreme.trials == 600
    assert extreme.inverse.given(8e-3, 0.95, "symmetric").estimate == pytest.approx(8e-3, abs=1.5e-3)
