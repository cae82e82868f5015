"""Less the row of setting: what a machine errs by where its zero was set is in the zero, and so is taken off, draw by draw.

at (n,): for each row the row in which its zero was set, -1 where nothing is taken off. The zero is a number of the machine
axes: what was taken into it stays along them while a table turns the part. turn (n, 3, 3): from there to workpiece axes, None
while all rotary axes stand at zero.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np
import numpy.typing as npt

from vcmm.core.run import Array
from vcmm.response.trials import Draws

Ints = npt.NDArray[np.intp]


def less_errors(found: Array, at: Ints, turn: Array | None = None) -> Array:
    """Errors (..., n, 3) less those in the rows of setting."""
    taken = found[..., np.maximum(at, 0), :]
    if turn is not None:
        taken = np.einsum("nij,...nj->...ni", turn, taken)
    return np.asarray(found - np.where((at >= 0)[:, None], taken, 0.0))


def less_response(response: Array, at: Ints, *codes: Ints, turn: Array | None = None) -> Array:
    """Responses (n, 3, ...) less those in the rows of setting, where all draws (codes, n each) are the same there."""
    back = np.maximum(at, 0)
    same = at >= 0
    for one in codes:
        same = same & (one == one[back])
    shape = (-1,) + (1,) * (response.ndim - 1)
    taken = response[back] if turn is None else np.einsum("nij,nj...->ni...", turn, response[back])
    return np.asarray(response - np.where(same.reshape(shape), taken, 0.0))


def without_setting(one: Draws, at: Ints) -> Draws:
    """Draws of copies that only rows of setting have count as nothing: they belong to the uncertainty of the zero."""
    codes = one.influence.codes
    used = np.unique(codes[~np.isin(np.arange(len(codes)), at)])
    keep = np.isin(np.arange(one.departures.shape[1]), used)
    return replace(one, departures=one.departures * keep[None, :, None])
