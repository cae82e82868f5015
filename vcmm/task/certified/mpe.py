"""Maximum permissible errors as certificates and data sheets write them: ISO 10360-2 has A + L/K, makers also write a slope.

1.9 um + L/300     1.9 + L/300      L in mm gives um
1.9 um + 3.3L/1000 1.9 + 3.3 L/1000 3.3 um per 1000 mm
1.9 um + 3.3 um/m  1.9 um           a slope with its unit; a limit that does not grow
"""

from __future__ import annotations

import re

from vcmm.core.errors import UsageError
from vcmm.core.units import quantity

NUMBER = r"\d+(?:\.\d+)?"
_GROWS = re.compile(rf"(?:(?P<slope>{NUMBER})\s*[*x×·]?\s*)?L\s*/\s*(?P<per>{NUMBER})\s*(?P<unit>[uµμ]m)?")
_SLOPE = re.compile(rf"(?P<slope>{NUMBER})\s*(?P<unit>[uµμ]m/m|ppm|[uµμ]m\s*/\s*1000\s*mm)")
STEEPEST = 10.0  # mm per um: 100 um per metre, more than any machine that is certified by lengths
WAYS = '"1.9 um + L/300", "1.9 + 3.3L/1000" or "1.9 um + 3.3 um/m" (L in mm gives um)'


def parts_of(text: str, name: str, example: str) -> tuple[float, float]:
    """(fixed mm, length in mm per um of growth, infinite where it does not grow). UsageError: what is not understood."""
    plain = text.strip().lstrip("±").strip()
    bracket = re.fullmatch(r"\((?P<inside>.*)\)\s*(?P<unit>[uµμ]m)", plain)
    plain = bracket["inside"] if bracket else plain
    first, plus, rest = (p.strip() for p in plain.partition("+"))
    if not plus and (_GROWS.fullmatch(first) or _SLOPE.fullmatch(first)):
        return 0.0, _per(first, text, name)
    if plus:
        per = _per(rest, text, name)
        bare = re.fullmatch(NUMBER, first)  # "1.9 + L/300": the equation is one of numbers in um
        return quantity(f"{first} um" if bare else first, "length", name, example), per
    return quantity(f"{first} um" if bracket else first, "length", name, example), float("inf")


def _per(text: str, whole: str, name: str) -> float:
    grows, slope = _GROWS.fullmatch(text), _SLOPE.fullmatch(text)
    if not grows and not slope:
        raise UsageError(f'{name} = "{whole}" cannot be read: write {WAYS}')
    if grows:
        over, by = float(grows["slope"] or "1"), float(grows["per"])
    else:
        assert slope is not None
        over, by = float(slope["slope"]), 1000.0
    if not (over > 0 and by > 0):
        raise UsageError(f'{name} = "{whole}": a limit grows by more than nothing; write {WAYS}')
    if by / over < STEEPEST:
        hint = f"L/{1000 * by:g}, or {by:g} um/m" if by < 1 else f"L/{300:g}"
        raise UsageError(
            f'{name} = "{whole}" grows by {1000 * over / by:.4g} um per metre; usual are L/50 to L/1500 (0.7 to 20 um/m): is {hint} meant?'
        )
    return by / over
