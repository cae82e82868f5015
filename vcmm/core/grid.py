"""Interpolate between nodes by weights, so that the result stays linear in the values at the nodes."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]


def multilinear(positions: list[Array], grids: tuple[Array, ...]) -> tuple[Array, np.ndarray[Any, Any]]:
    """Return weights (n, 2^d) and flat node numbers (n, 2^d) of linear interpolation on a rectilinear grid."""
    n = len(positions[0])
    weights, nodes = np.ones((n, 1)), np.zeros((n, 1), dtype=np.intp)
    for q, grid in zip(positions, grids):
        if len(grid) == 1:
            nodes = nodes * 1
            continue
        cell = np.clip(np.searchsorted(grid, q, side="right") - 1, 0, len(grid) - 2)
        share = ((q - grid[cell]) / (grid[cell + 1] - grid[cell]))[:, None]
        weights = np.concatenate([weights * (1 - share), weights * share], axis=1)
        nodes = nodes * len(grid)
        nodes = np.concatenate([nodes + cell[:, None], nodes + cell[:, None] + 1], axis=1)
    return weights, nodes


def node_weights(nodes: Array, q: Array, interpolation: str) -> Array:
    """Return weights (n, nodes) such that the value at q (n,) is weights @ values; "cubic" (natural spline, 3 nodes or more), "periodic" or "linear".

    periodic: a cubic spline over one turn, for any q; the first and the last node are one place, which has the mean of both values.
    """
    if interpolation == "periodic" and len(nodes) > 3:
        from scipy.interpolate import CubicSpline

        values = np.eye(len(nodes))
        values[0] = values[-1] = (values[0] + values[-1]) / 2
        return np.asarray(CubicSpline(nodes, values, bc_type="periodic")(q))
    if interpolation == "cubic" and len(nodes) > 2:
        from scipy.interpolate import CubicSpline

        return np.asarray(CubicSpline(nodes, np.eye(len(nodes)), bc_type="natural")(q))
    shares, number = multilinear([q], (nodes,))
    out = np.zeros((len(q), len(nodes)))
    for corner in range(shares.shape[1]):
        out[np.arange(len(q)), number[:, corner]] += shares[:, corner]
    return out
