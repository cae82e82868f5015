"""The verdict: when names, and when noise, are the whole story."""

from __future__ import annotations

from vcmm.diagnosis.result import Answer


def answer(probability: float, rivals: float = 0.0) -> Answer:
    return Answer("backlash", {"axis": "X"}, {}, probability, 1.0, (), 10.0, rival_probability=rivals)


def test_a_name_is_doubtful_where_it_and_its_rivals_are_less_probable_than_not() -> None:
    """0.3 + 0.1 < 0.5 <= 0.3 + 0.6; a rival set that holds the rest is an open choice and no doubt."""
    assert answer(0.3, 0.1).doubtful
    assert not answer(0.3, 0.6).doubtful
    assert not answer(0.5).doubtful
