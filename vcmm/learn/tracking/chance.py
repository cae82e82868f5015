"""The chance that a sum of squares of independent standard normal numbers is larger: chi-square of whole degrees of freedom, in closed form.

    even k:  e^(-h) sum_(j < k/2) h^j / j!                                            h = x / 2
    odd k:   erfc(sqrt h) + e^(-h) sum_(j < (k-1)/2) h^(j + 1/2) / Gamma(j + 3/2)

(M. Abramowitz & I. Stegun, Handbook of Mathematical Functions (1964), 26.4.4 and 26.4.5.) So that a new recording does not wait for scipy.special.
"""

from __future__ import annotations

import math
from functools import lru_cache


def chance_beyond(count: int, square: float) -> float:
    """Return P(chi-square of `count` degrees of freedom > square)."""
    half, odd = square / 2.0, count % 2
    if half <= 0.0:
        return 1.0
    shift = 0.5 if odd else 0.0
    terms = ((j + shift) * math.log(half) - math.lgamma(j + shift + 1.0) - half for j in range(count // 2))
    whole = math.fsum(math.exp(t) for t in terms)
    return min(1.0, whole + (math.erfc(math.sqrt(half)) if odd else 0.0))


@lru_cache(maxsize=256)
def square_at(count: int, chance: float) -> float:
    """Return the square that is exceeded with this chance: the smallest number of floating point with chance_beyond(count, square) <= chance."""
    low, high = 0.0, 1.0
    while chance_beyond(count, high) > chance:
        low, high = high, 2.0 * high
    while low < (middle := 0.5 * (low + high)) < high:
        low, high = (middle, high) if chance_beyond(count, middle) > chance else (low, middle)
    return high
