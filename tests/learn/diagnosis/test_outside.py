"""What a mechanism outside the catalogue leaves to the names of a diagnosis."""

from __future__ import annotations

from dataclasses import dataclass

import pytest

from vcmm.learn.diagnosis.engine import discount_unknown_mechanism
from vcmm.learn.diagnosis.result import Answer

NAMED = Answer(
    "backlash", {"axis": "X"}, {}, 0.8, 1.0, (), 0.0, rival_probability=0.1, alias_probability=0.05
)


@dataclass(frozen=True)
class Verdict:
    verdict: str
    answer: tuple[Answer, ...] = (NAMED,)


@pytest.mark.parametrize(
    ("verdict", "share"),
    [
        ("explained", 1 / 1.026),
        ("partly explained", 1 / 2.42),
    ],  # odds of 0.026 and 1.42 that it is none of the names
)
def test_every_name_loses_the_odds_of_none(verdict: str, share: float):
    """0.8 / 1.026 = 0.7797 where the account closes, 0.8 / 2.42 = 0.3306 where something is left; rivals and aliases alike."""
    (after,) = discount_unknown_mechanism(Verdict(verdict)).answer  # type: ignore[arg-type]
    assert after.probability == pytest.approx(0.8 * share)
    assert after.rival_probability == pytest.approx(0.1 * share)
    assert after.alias_probability == pytest.approx(0.05 * share)
