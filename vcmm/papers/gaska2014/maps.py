"""Fig. 7: the simulated reproduction error over the volume, for each coordinate and interpolation."""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.core.run import Array
from vcmm.papers.gaska2014.nodes import COLUMNS, NODES
from vcmm.papers.gaska2014.readings import PLANES
from vcmm.physics.structure.residual import field_weights

PANELS: Sequence[tuple[str, int, str]] = (
    ("a", 0, "linear"), ("b", 0, "nearest"), ("c", 1, "linear"), ("d", 1, "nearest"), ("e", 2, "nearest"),
)  # fmt: skip
STEP = 25.0  # mm


def grid() -> tuple[Array, Array]:
    """x (n,), y (m,) mm over the nodes."""
    ends = np.array(COLUMNS, dtype=float)
    x, y = (np.arange(ends[:, i].min(), ends[:, i].max() + 1e-6, STEP) for i in (0, 1))
    return x, y


def field_map(deviations: Array, axis: int, plane: str, height: float, curve: str) -> Array:
    """(m, n) um: standard deviation of one coordinate at a height, of independent nodes with d (52, 3) um.

    The root of the sum of squares of weight times d: what the simulation of section 4 scatters by, without drawing it.
    """
    x, y = grid()
    tip = np.array([(a, b, height) for b in y for a in x])
    lateral, vertical = field_weights(NODES, PLANES[plane], tip, curve=curve)
    weights = vertical if axis == 2 else lateral
    return np.asarray(np.sqrt((weights**2) @ deviations[:, axis] ** 2).reshape(len(y), len(x)))
