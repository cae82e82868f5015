"""Numba twin of the walk along an axis in vcmm.core.history. Private; imported inside the calling function."""

from __future__ import annotations

from typing import Any

import numpy as np
from numpy.typing import NDArray

from vcmm.core._compile_kernels import njit

Array = NDArray[Any]


@njit(cache=True, nogil=True)
def sense_and_since(q: Array, back: Array, still: float) -> tuple[Array, Array]:
    """Compute sense and distance as vcmm.core.history.sense_and_since does.

    back (n,): way back at which a reversal is noticed; still: least way at the start."""
    sense, since = np.zeros(len(q)), np.zeros(len(q))
    direction, turned = 0, q[0] if len(q) else 0.0
    furthest = turned
    for i in range(len(q)):
        x = q[i]
        ahead = (x - furthest) * direction if direction else abs(x - furthest)
        if ahead > 0 and direction:
            furthest = x
        elif (direction and ahead < -back[i]) or (not direction and ahead > still):
            turned, furthest, direction = furthest, x, 1 if x > furthest else -1
        sense[i], since[i] = direction, abs(furthest - turned)
    return sense, since
