"""Every family has words for the operator, with its numbers in them."""

from __future__ import annotations

from vcmm.diagnosis.candidates import NEVER
from vcmm.diagnosis.estimates import Estimate
from vcmm.diagnosis.plain_words import WORDS, plain_words
from vcmm.effects import ALL


def test_every_family_has_words():
    due = {getattr(kind, "family", "") or kind.name for kind in ALL if kind.name not in NEVER}
    assert not due - set(WORDS)


def test_words_hold_the_numbers():
    gap = Estimate(1.21, 0.08, (1.05, 1.37), "um")
    said = plain_words("backlash", {"axis": "Y"}, {"gap": gap})
    assert said.startswith("Y stops 1.21 um short after reversing; usually wear of the Y nut or belt")
    assert "confirm by" in said
    other = plain_words("backlash", {"axis": "Y"}, {"gap": Estimate(-1.21, 0.08, (-1.37, -1.05), "um")})
    assert "too far" in other  # a compensation that overdoes it
    assert plain_words("my_own", {}, {}) == ""
    bare = plain_words("thermal_drift", {"direction": "z", "sensor": "air"}, {})
    assert "{" not in bare
    assert "()" not in bare
