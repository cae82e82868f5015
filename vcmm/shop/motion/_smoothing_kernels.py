"""Numba twin of the sum of spread turns in vcmm.shop.motion.smoothing. Private; imported inside the calling function."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vcmm.core._compile_kernels import njit

Array = NDArray[Any]


@njit(cache=True)
def spread_turns(
    s: Array, at: Array, width: Array, first: Array, last: Array, turn: Array, order: int
) -> Array:
    """Sum (b, 6) at breaks s (b,) of turn (k, 6) times g or its derivative, spread by width (k,) about at (k,) over breaks first..last."""
    out = np.zeros((len(s), turn.shape[1]))
    for k in range(len(at)):
        h = width[k]
        for i in range(first[k], last[k] + 1):
            x = s[i] - at[k]
            rest = max(h - abs(x), 0.0)
            if order == 0:
                value = rest * rest * rest / (6 * (h * h))
            elif order == 1:
                value = (-1.0 if x >= 0 else 1.0) * (rest * rest) / (2 * (h * h))
            else:
                value = rest / (h * h)
            for c in range(turn.shape[1]):
                out[i, c] += value * turn[k, c]
    return out
