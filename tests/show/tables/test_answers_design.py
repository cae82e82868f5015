"""The first lines of `vcmm calibrate design`."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from vcmm.show.tables.answers_runs import design_answers


def proposal(names: str, minutes: float, *left: str) -> Any:
    combinations = [SimpleNamespace(text=text) for text in left]
    return SimpleNamespace(
        names=tuple(names), minutes=minutes, identifiability=SimpleNamespace(combinations=combinations)
    )


def test_the_cheapest_complete_choice_comes_first() -> None:
    whole, few = proposal("abc", 90.0), proposal("ab", 45.0)
    first, second = design_answers(whole, proposal("a", 20.0, "EXX and EYY"), few)
    assert (first.result, first.verdict, first.because) == ("2 of 3, 45 min", "complete", "a, b")
    assert (second.result, second.coverage) == ("1 of 3, 20 min", "1 open")


def test_what_stays_open_by_all_is_named() -> None:
    (only,) = design_answers(proposal("ab", 45.0, "EAX with EBX"), None, None)
    assert (only.verdict, only.change) == ("not complete", "EAX with EBX")
    assert only.numbers == {"setups": 2, "minutes": 45.0, "open": 1}
