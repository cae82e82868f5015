"""The audit's score interval, by hand."""

from __future__ import annotations

import math
from pathlib import Path

import pytest

from tests.answer.inference.test_between_points import MACHINE, RING
from vcmm.answer.inference.audit import fixed_form_in_words, wilson
from vcmm.answer.inference.audit_by_points import AUDITED_FORMS, count_by_points, why_not_by_points
from vcmm.files.own.scenario import load_scenario


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
