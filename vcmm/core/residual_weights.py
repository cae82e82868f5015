"""Weights of the nodes of a residual field at a place: columns and triangles after Gaska, or trilinear; places outside raise an error."""

from __future__ import annotations

from typing import Any

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.grid import multilinear
from vcmm.core.run import Array

Ints = npt.NDArray[np.intp]
METHODS = ("columns-linear", "columns-nearest", "trilinear")
CURVES = (
    "through",
    "control",
)  # the b-spline of a column passes through its nodes, or has them as control points


def field_weights(
    nodes: Array, method: str, tip: Array, triangles: Any = None, curve: str = "through"
) -> tuple[Array, Array]:
    """Return (lateral, vertical) weights (n, nodes): field x, y = lateral @ values, z = vertical @ values.

    curve: of CURVES, along the columns. `triangles`: the Delaunay triangulation of the columns, if it was made before.
    Raises ModelLimit for a point outside the hull of the nodes.
    """
    if method == "trilinear":
        weights = _trilinear(nodes, tip)
        return weights, weights
    _refuse_outside(nodes, tip)
    columns = columns_of(nodes)
    plane = np.array([nodes[c[0], :2] for c in columns])
    triangles = triangulate(plane) if triangles is None else triangles
    in_plane = _triangle_weights(plane, tip[:, :2], triangles)  # refuses what lies outside, for both methods
    if method == "columns-nearest":
        in_plane = _nearest_weights(plane, tip[:, :2])
    lateral = np.zeros((len(tip), len(nodes)))
    curves: dict[bytes, Array] = {}  # columns with the same heights share one
    for j, column in enumerate(columns):
        _refuse_beyond(nodes[column], tip, in_plane[:, j] > 1e-12)
        levels = nodes[column, 2]
        if (key := levels.tobytes()) not in curves:
            curves[key] = _curve_weights(levels, tip[:, 2], curve)
        lateral[:, column] += in_plane[:, j, None] * curves[key]
    return lateral, _nearest_weights(nodes, tip)


def columns_of(nodes: Array) -> list[Ints]:
    """Return the node numbers of every vertical column, from low to high z."""
    keys = {tuple(xy) for xy in nodes[:, :2]}
    out = []
    for x, y in sorted(keys):
        members = np.flatnonzero((nodes[:, 0] == x) & (nodes[:, 1] == y))
        out.append(members[np.argsort(nodes[members, 2])])
    return out


def _curve_weights(levels: Array, z: Array, curve: str = "through") -> Array:
    """Return the weights (n, levels) of the b-spline of one column at heights z.

    Degree 3 where there are four levels or more. "through": the curve through the nodes, of four nodes their cubic. "control": the nodes
    are its control points, so that its height runs by the same b-spline and is solved for; of four nodes a Bezier curve.
    """
    from scipy.interpolate import BSpline, make_interp_spline

    count = len(levels)
    degree = min(3, count - 1)
    if degree < 1:
        return np.ones((len(z), 1))
    if curve == "through":
        return np.asarray(make_interp_spline(levels, np.eye(count), k=degree)(z))
    knots = np.concatenate([np.zeros(degree), np.linspace(0.0, 1.0, count - degree + 1), np.ones(degree)])
    height, shares = BSpline(knots, levels, degree), BSpline(knots, np.eye(count), degree)
    low, high = np.zeros(len(z)), np.ones(len(z))
    for _ in range(50):  # the height rises with the parameter, since the levels do
        middle = (low + high) / 2
        above = height(middle) > z
        low, high = np.where(above, low, middle), np.where(above, middle, high)
    return np.asarray(shares((low + high) / 2))


def triangulate(plane: Array) -> Any:
    """Return the Delaunay triangulation of the columns (m, 2). Raises UsageError where they span no area."""
    from scipy.spatial import Delaunay

    spread = plane - plane[0]
    if np.linalg.matrix_rank(spread, tol=1e-9 * max(float(np.abs(spread).max()), 1e-300)) < 2:
        raise UsageError(
            f"residual_field: {len(plane)} columns of nodes lie on one line; between columns the field needs three that do not"
        )
    return Delaunay(plane)


def _triangle_weights(plane: Array, xy: Array, triangulation: Any) -> Array:
    """Return the barycentric weights (n, columns) on the triangles of the columns. Raises ModelLimit outside their hull."""
    simplex = triangulation.find_simplex(xy, tol=1e-9)
    if (simplex < 0).any():
        raise outside(
            xy[np.flatnonzero(simplex < 0)[0]],
            "the columns of nodes in the plane",
            int(np.flatnonzero(simplex < 0)[0]),
        )
    transform = triangulation.transform[simplex]
    two = np.einsum("nij,nj->ni", transform[:, :2], xy - transform[:, 2])
    weights = np.zeros((len(xy), len(plane)))
    corners = np.concatenate([two, 1 - two.sum(axis=1, keepdims=True)], axis=1)
    np.put_along_axis(weights, triangulation.simplices[simplex], corners, axis=1)
    return weights


def _nearest_weights(nodes: Array, points: Array) -> Array:
    distance = ((points[:, None, :] - nodes) ** 2).sum(axis=2)
    weights = np.zeros(distance.shape)
    weights[np.arange(len(points)), distance.argmin(axis=1)] = 1.0
    return weights


def _trilinear(nodes: Array, tip: Array) -> Array:
    grids = tuple(np.unique(nodes[:, i]) for i in range(3))
    if int(np.prod([len(g) for g in grids])) != len(nodes):
        raise UsageError(
            f"residual_field: {len(nodes)} nodes do not fill a rectangular grid of "
            f'{" x ".join(str(len(g)) for g in grids)}; use interpolation = "columns-linear" for staggered columns'
        )
    for i, grid in enumerate(grids):
        bad = np.flatnonzero((tip[:, i] < grid[0] - 1e-6) | (tip[:, i] > grid[-1] + 1e-6))
        if len(bad):
            raise outside(tip[bad[0]], "the grid of nodes", int(bad[0]))
    weights, cells = multilinear([tip[:, i] for i in range(3)], grids)
    flat = [np.searchsorted(grids[i], nodes[:, i]) for i in range(3)]
    number = np.empty(len(nodes), dtype=np.intp)
    number[(flat[0] * len(grids[1]) + flat[1]) * len(grids[2]) + flat[2]] = np.arange(len(nodes))
    out = np.zeros((len(tip), len(nodes)))
    for corner in range(weights.shape[1]):
        out[np.arange(len(tip)), number[cells[:, corner]]] += weights[:, corner]
    return out


def _refuse_outside(nodes: Array, tip: Array) -> None:
    low, high = nodes[:, 2].min(), nodes[:, 2].max()
    bad = np.flatnonzero((tip[:, 2] < low - 1e-6) | (tip[:, 2] > high + 1e-6))
    if len(bad):
        raise outside(tip[bad[0]], f"the nodes' heights {low:g} to {high:g} mm", int(bad[0]))


def _refuse_beyond(column: Array, tip: Array, used: npt.NDArray[np.bool_]) -> None:
    """Raise an error for a place above or below its column: a curve through a column of nodes is not continued there."""
    low, high = column[:, 2].min(), column[:, 2].max()
    bad = np.flatnonzero(used & ((tip[:, 2] < low - 1e-6) | (tip[:, 2] > high + 1e-6)))
    if len(bad):
        x, y = column[0, :2]
        raise outside(
            tip[bad[0]], f"the column of nodes at ({x:g} {y:g}) mm, {low:g} to {high:g} mm high", int(bad[0])
        )


def outside(point: Array, what: str, row: int) -> ModelLimit:
    at = " ".join(f"{v:.6g}" for v in point)
    return ModelLimit(
        f"row {row + 1}: the tip at ({at}) mm lies outside the hull of {what}; the residual field is not known there: "
        "move the part or measure more nodes",
        row=row,
    )


def known_row_by_row(weights: Any, tip: Array) -> npt.NDArray[np.bool_]:
    """Return at which places (n,) a field is known: `weights` raises ModelLimit elsewhere."""
    out = np.ones(len(tip), dtype=bool)
    for i in range(len(tip)):
        try:
            weights(tip[i : i + 1])
        except ModelLimit:
            out[i] = False
    return out
