"""Numba twins of polynomials along curves and of the deviation by smoothing. Private; imported inside the calling functions."""

from __future__ import annotations

import math
from typing import Any

import numpy as np
from numpy.typing import NDArray

from vcmm.core._compile_kernels import njit

Array = NDArray[Any]


@njit(cache=True, nogil=True)
def polynomials(coefficients: Array, factors: Array, which: Array, u: Array, order: int) -> Array:
    """Return the derivative by u of that order (k, 6) of polynomials (n, 6, 6) `which` (k,) at u (k,), by Horner."""
    out = np.zeros((len(u), 6))
    for k in range(len(u)):
        for power in range(5, order - 1, -1):
            factor = factors[order, power]
            for c in range(6):
                out[k, c] = out[k, c] * u[k] + factor * coefficients[which[k], power, c]
    return out


@njit(cache=True, nogil=True)
def largest_deviation(s: Array, off: Array, bend: Array, weight: Array, looks: Array) -> Array:
    """Return the largest distance (b-1,) at the shares `looks` between two breaks s (b,), of cubics with values off (b, 6), second
    derivatives bend."""
    out = np.zeros(len(s) - 1)
    for i in range(len(out)):
        length = s[i + 1] - s[i]
        scale = length * length / 6
        for t in looks:
            a, b = (1 - t) ** 3 - (1 - t), t**3 - t
            total = 0.0
            for c in range(off.shape[1]):
                value = (
                    (1 - t) * off[i, c] + t * off[i + 1, c] + scale * (a * bend[i, c] + b * bend[i + 1, c])
                )
                total += (value * weight[c]) ** 2
            out[i] = max(out[i], math.sqrt(total))
    return out
