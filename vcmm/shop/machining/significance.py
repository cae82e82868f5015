"""Significance of a gain in the sum of squares, also where p is too small for a number.

Chi-square where the scatter is stated, F where it is estimated from the residual; the tails by their leading terms (Abramowitz, Stegun,
Handbook of Mathematical Functions, 6.5.32 and 26.5.4).
"""

from __future__ import annotations

import math

LEAST_POSITIVE, LEAST_P = 1e-300, 1e-290


def log_p(gain: float, m: int, left: tuple[float, int] | None) -> float:
    """Return the logarithm of the significance of a gain in the sum of squares by m numbers. left: (sum of squares, freedom) of the
    residual, None where the scatter is stated."""
    from scipy import special, stats

    if left is None:
        p = float(stats.chi2.sf(gain, m))
        tail = float(
            (m / 2 - 1) * math.log(max(gain, LEAST_POSITIVE) / 2) - gain / 2 - special.gammaln(m / 2)
        )
    else:
        square, freedom = left
        ratio = gain / m / max(square / freedom, LEAST_POSITIVE)
        p, a, b = float(stats.f.sf(ratio, m, freedom)), freedom / 2, m / 2
        y = freedom / (freedom + m * ratio)
        beta = float(special.betaln(a, b))
        tail = a * math.log(max(y, LEAST_POSITIVE)) + b * math.log1p(-min(y, 0.5)) - math.log(a) - beta
    return math.log(p) if p > LEAST_P else tail


def p_in_words(p: float) -> str:
    return f"p = {p:.1g}" if p > 0.0 else f"p below {LEAST_P:.0g}"
