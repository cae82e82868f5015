"""Words that people write as units and that are none, with the correct unit. A table beside `vcmm.core.units`."""

from __future__ import annotations

from collections.abc import Sequence

from vcmm.core.errors import choose_from

# in small letters
INSTEAD: dict[str, str] = {
    "l": "L is the measured length in a limit of ISO 10360, such as 1.9 um + 3.3 L/1000; 3.3 L/1000 with L in mm, in um, is 3.3 um/m",
    "degf": "temperatures are written in degC, their differences in K: 68 degF is (68 - 32) / 1.8 = 20 degC, a difference of 1.8 degF is 1 K",
    "inch": "write in",
    "inches": "write in",
    "mil": "a thousandth of an inch is 25.4 um; write um or in",
    "thou": "a thousandth of an inch is 25.4 um; write um or in",
    "micron": "write um",
    "microns": "write um",
    "sec": "write s, or arcsec for an angle",
    "hr": "write h",
}  # fmt: skip


def instead_of(word: str) -> str:
    """Return what to write instead of a word or number within a unit; "" where the table has no advice."""
    if word.isdigit():
        return "a unit contains no number; write for example 3.3 um/m"
    return INSTEAD.get(word.lower(), "")


def closest_of(word: str, fitting: Sequence[str]) -> str:
    """Return ' Did you mean "mm"? Allowed: ...'; mi is read as the beginning of min, and mn as a slip for mm and not for m."""
    begun = [u for u in fitting if len(word) > 1 and u.startswith(word)]
    slip = begun or [u for u in fitting if len(u) == len(word) and u[0] == word[0]]
    if slip:
        return f' Did you mean "{slip[0]}"? Allowed: {", ".join(fitting)}.'
    return choose_from(word, fitting)
