"""The cutting force at each contact: that of its move, turned with the direction of feed along an arc.

The force of a move is a mean over the move, stated for the direction in its middle. On an arc the direction of feed turns
while the tool runs along it, and the force with it: round a full circle a boss is cut larger all round, not shifted.
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vcmm.core.run import Array
from vcmm.cutting.force import to_workpiece
from vcmm.cutting.sweeps import LINE, Sweep, position

STEP = 1e-3  # of a move, to either side, for its direction


def forces_at(forces: Array, sweep: Sweep, row: npt.NDArray[np.intp], share: Array) -> Array:
    """Force (k, 3) N at fractions share (k,) of the rows (k,); forces (rows, 3): for the middle of each, workpiece axes."""
    out = np.array(forces[row])
    arcs = np.flatnonzero(sweep.kind[row] != LINE)
    if len(arcs):
        mine = sweep.take(row[arcs])
        middle = _feed(mine, np.full(len(arcs), 0.5))
        here = _feed(mine, np.clip(share[arcs], STEP, 1.0 - STEP))
        x, y = (to_workpiece(np.tile(e, (len(arcs), 1)), middle, mine.axis) for e in np.eye(3)[:2])
        along = [np.einsum("ki,ki->k", out[arcs], v) for v in (x, y, mine.axis)]
        out[arcs] = to_workpiece(np.stack(along, axis=1), here, mine.axis)
    return out


def _feed(sweep: Sweep, share: Array) -> Array:
    """Direction of feed (k, 3) at fractions (k,) of the rows."""
    way = position(sweep, share + STEP) - position(sweep, share - STEP)
    length = np.linalg.norm(way, axis=1)
    return np.asarray(way / np.where(length > 0.0, length, 1.0)[:, None])
