"""The audit's score interval, by hand."""

from __future__ import annotations

import math
from pathlib import Path

import numpy as np
import pytest

from tests.answer.inference.test_between_points import MACHINE, RING
from vcmm.answer.evaluation.belts import inverse_of
from vcmm.answer.evaluation.pairs import Pairs
from vcmm.answer.inference.audit import IntervalLengths, fixed_form_in_words, lengths, oracle, wilson
from vcmm.answer.inference.audit_by_points import AUDITED_FORMS, count_by_points, why_not_by_points
from vcmm.files.own.scenario import load_scenario
from vcmm.part.part import Characteristic


def test_the_score_interval_of_a_share():
    """8 of 10 with z = 2: middle (0.8 + 4/20) / (1 + 4/10) = 1 / 1.4; half 2 / 1.4 x sqrt(0.8 x 0.2 / 10 + 4 / 400) = sqrt(0.026) / 0.7."""
    low, high = wilson(0.8, 10, 2.0)
    assert (low, high) == pytest.approx((0.483935, 0.944636), abs=1e-6)
    assert (high - low) / 2 == pytest.approx(math.sqrt(0.026) / 0.7, rel=1e-12)
    # 10 of 10: middle 1.2 / 1.4 = 6/7, half sqrt(0.01) / 0.7 = 1/7
    assert wilson(1.0, 10, 2.0) == pytest.approx((5 / 7, 1.0), rel=1e-12)
    assert wilson(0.0, 10, 2.0) == pytest.approx((0.0, 2 / 7), abs=1e-12)


def ring(folder: Path, form: str = ""):
    path = folder / "s.toml"
    arc = '"even", n = 30, start = "0 deg", sweep = "120 deg"'
    path.write_text(MACHINE + RING.format(n=30, form=form).replace('"even", n = 30', arc))
    return load_scenario(path)


@pytest.mark.thorough
def test_a_size_is_counted_by_the_door_of_users(tmp_path: Path) -> None:
    """On 120 deg scatter moves D by 1.5 um from end to end: parts with form need more, and get it."""
    scenario = ring(tmp_path)
    found = count_by_points(scenario, scenario.settings, 150)
    assert len(found) == len(AUDITED_FORMS)
    assert all(one.parts == 15 and one.claimed >= 13 for one in found)
    assert sum(one.covering for one in found) >= 0.93 * sum(one.claimed for one in found)
    assert min(one.width for one in found) > 3e-3
    assert "steps and edges" in found[-1].kind


def test_forms_that_are_stated_are_not_drawn_over(tmp_path: Path) -> None:
    stated = ring(tmp_path, ', form = { lobes = 3, amplitude = "2 um" }')
    assert "states forms" in why_not_by_points(stated)
    assert not why_not_by_points(ring(tmp_path))


def test_sizes_of_forms_in_words() -> None:
    """Where a limit is all that is known of the machine, the unit of forms is 0.1 um."""
    assert fixed_form_in_words(False, 6.0) == "forms 6 times the noise of the machine"
    assert fixed_form_in_words(True, 6.0) == "forms of 0.6 um"
    assert fixed_form_in_words(True, 0.0) == "parts without form"


FLATNESS = Characteristic("f", "flatness", of=("top",), zone=0.01)
MATING = Characteristic("d", "size", of=("bore",), criterion="GX", limits=(0.0, 0.1))
Z = 1.959964


def drawn(seed: int, count: int = 20_000, spread: float = 2e-3) -> Pairs:
    """True values of N(20 um, spread), indicated with N(0, 1 um), residuals of 1 um."""
    rng = np.random.default_rng(seed)
    true = 0.020 + spread * rng.normal(size=(count, 1))
    return Pairs(true, true + 1e-3 * rng.normal(size=(count, 1)), np.full((count, 1), 1e-3))


def test_the_oracle_is_the_conditional_law_of_two_normal_ones() -> None:
    """Of N(20, 2) seen with N(0, 1): mean 20 + 0.8 (y - 20), standard deviation 2 x 1 / sqrt 5 = 0.894 um."""
    known = drawn(1)
    y = np.array([0.019, 0.020, 0.021])
    low, high = oracle(
        FLATNESS, (known.true[:, 0], known.indicated[:, 0], known.rest[:, 0]), (y, np.full(3, 1e-3)), 0.95
    )
    assert (low + high) / 2 == pytest.approx(0.020 + 0.8 * (y - 0.020), abs=0.25e-3)  # 300 parts: 0.1 um
    assert high - low == pytest.approx(2 * Z * 0.894e-3, rel=0.15)


def test_of_a_size_parts_as_rough_are_alike() -> None:
    """The error is five residuals of the part, whatever it indicates: 5 +- 1 of them."""
    rng = np.random.default_rng(2)
    rest = 10 ** rng.uniform(-4, -2, 20_000)
    true = rng.normal(size=20_000)
    low, high = oracle(
        MATING,
        (true, true - rest * (5 + rng.normal(size=20_000)), rest),
        (np.zeros(2), np.array([1e-3, 5e-3])),
        0.95,
    )
    assert low / [1e-3, 5e-3] == pytest.approx(5 - Z, abs=0.5)
    assert high / [1e-3, 5e-3] == pytest.approx(5 + Z, abs=0.5)


def test_lengths_beside_the_oracle_of_each_family() -> None:
    """Both families alike, the prior wide beside the noise: belts and oracle have 2 x 1.96 um, in the mean of both."""
    known, fresh = (
        [drawn(3, spread=5e-3), drawn(4, spread=5e-3)],
        [drawn(5, 2000, 5e-3), drawn(6, 2000, 5e-3)],
    )
    found = lengths(FLATNESS, 0, inverse_of(FLATNESS, 0, known), known, fresh, 0.95)
    assert found.oracle == pytest.approx(2 * Z * 1e-3 * 5 / np.sqrt(26), rel=0.05)
    assert found.own == pytest.approx(2 * Z * 1e-3, rel=0.08)
    assert found.own <= found.belts
    assert found.oracle_held == pytest.approx(0.95, abs=0.015)
    assert found.belts_held >= found.own_held
    assert found.ratio == pytest.approx(found.belts / found.oracle)
    assert np.isnan(IntervalLengths(1, 1, 0, 1, 1, 1).ratio)
