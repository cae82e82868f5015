"""Settings: what is allowed, and what else is refused with the cure."""

from __future__ import annotations

import pytest

from vcmm.core.errors import UsageError
from vcmm.task.measuring.settings import Settings


@pytest.mark.parametrize(
    ("wrong", "said"),
    [
        ({"engine": "magic"}, "allowed: auto, montecarlo, exact"),
        ({"trials": 999}, "at least 1000"),
        ({"known_bias": "hidden"}, "allowed: reported, corrected"),
        ({"digits": 4}, "use 1, 2 or 3"),
        ({"p": 0.4}, "between 0.5 and 0.999999"),
        ({"p": 1.0}, "between 0.5 and 0.999999"),
    ],
)
def test_wrong_settings(wrong, said):
    with pytest.raises(UsageError, match=said):
        Settings(**wrong)


def test_the_ends_are_allowed():
    assert Settings(trials=1000, p=0.5, digits=3).certify == 200
