"""Residual error fields: what a compensated machine still does, given at nodes of its volume.

ResidualField: node vectors interpolated as in Gaska et al. 2014 ("columns": a b-spline along z through the nodes of
each vertical column, or with the nodes as its control points, then linear on Delaunay triangles of the columns or the nearest
column; the z error from the nearest node) or trilinear on a rectangular grid. Interpolating independent draws shrinks the variance between the
nodes; CorrelatedField keeps it: a Gaussian process whose standard deviation follows the nodes'.
All vectors are tip errors (actual - nominal) in workpiece axes. Outside the nodes' hull the field is refused.
"""

from __future__ import annotations

from dataclasses import dataclass
from functools import cached_property
from typing import Any, ClassVar

import numpy as np
import numpy.typing as npt

from vcmm.core.declaration import UM, ForDiagnosis, KnownRange, Typical
from vcmm.core.effect import Effect, param, points
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.grid import multilinear
from vcmm.core.run import Array, Run

Ints = npt.NDArray[np.intp]
METHODS = ("columns-linear", "columns-nearest", "trilinear")
CURVES = (
    "through",
    "control",
)  # the b-spline of a column passes through its nodes, or has them as control points


@dataclass(frozen=True, eq=False)
class ResidualField(Effect):
    """Tip errors at nodes, interpolated."""

    name = "residual_field"
    per = "machine"
    cites = "Gaska et al., Int. J. Adv. Manuf. Technol. 73 (2014) 497, section 4"
    diagnosis = ForDiagnosis(
        is_named=False,
    )
    independent_draws: ClassVar[str] = (
        "residual_field interpolates independent draws, whose variance shrinks between the nodes: the pose found may gain from "
        "that and not from the machine; give correlated_field its covariance, as `vcmm place gaska2014` does"
    )
    nodes: Any = points(lambda: _unit_cube())
    interpolation: str = "trilinear"
    values: Any = param(
        lambda: np.zeros((0, 3)),
        "um",
        "tip error at the nodes; zero when left out",
        shape="(nodes, 3)",
        typical=Typical(1 * UM, "what compensation leaves: 0.5-3 um"),
    )
    curve: str = "through"

    def __post_init__(self) -> None:
        if np.size(self.values) == 0:
            object.__setattr__(self, "values", np.zeros(np.shape(self.nodes)))
        if self.interpolation not in METHODS:
            raise UsageError(
                f'residual_field: interpolation = "{self.interpolation}"; allowed: {", ".join(METHODS)}'
            )
        if self.curve not in CURVES:
            raise UsageError(f'residual_field: curve = "{self.curve}"; allowed: {", ".join(CURVES)}')
        if np.shape(self.values) != np.shape(self.nodes):
            raise UsageError(
                f"residual_field: {len(self.values)} values for {len(self.nodes)} nodes; give one row of x y z per node"
            )

    @property
    def link(self) -> str:
        return "tip"

    def known_range(self) -> tuple[KnownRange, ...]:
        return _box(self.name, self.nodes)

    def error_motion(self, run: Run) -> Array:
        lateral, vertical = self._weights(run.tip)
        values = np.asarray(self.values, dtype=float)
        out = np.zeros((run.n, 6))
        out[:, :2] = lateral @ values[:, :2]
        out[:, 2] = vertical @ values[:, 2]
        return out

    def response(self, name: str, run: Run) -> Array:
        lateral, vertical = self._weights(run.tip)
        out = np.zeros((run.n, 6, len(self.nodes), 3))
        out[:, 0, :, 0] = out[:, 1, :, 1] = lateral
        out[:, 2, :, 2] = vertical
        return out.reshape(run.n, 6, -1)

    def projected(self, name: str, run: Run, weights: Array) -> Array:
        lateral, vertical = self._weights(run.tip)
        out = np.empty((run.n, len(self.nodes), 3))
        for i, share in enumerate((lateral, lateral, vertical)):
            out[:, :, i] = weights[:, i, None] * share
        return out.reshape(run.n, -1)

    @cached_property
    def _triangles(self) -> Any:
        nodes = np.asarray(self.nodes, dtype=float)
        return _triangulated(np.array([nodes[c[0], :2] for c in _columns(nodes)]))

    def _weights(self, tip: Array) -> tuple[Array, Array]:
        triangles = None if self.interpolation == "trilinear" else self._triangles
        nodes = np.asarray(self.nodes, dtype=float)
        return field_weights(nodes, self.interpolation, tip, triangles, self.curve)


def field_weights(
    nodes: Array, method: str, tip: Array, triangles: Any = None, curve: str = "through"
) -> tuple[Array, Array]:
    """(lateral, vertical) weights (n, nodes): field x, y = lateral @ values, z = vertical @ values.

    curve: of CURVES, along the columns. `triangles`: the Delaunay triangulation of the columns, if it was made before.
    Raises ModelLimit for a point outside the hull of the nodes.
    """
    if method == "trilinear":
        weights = _trilinear(nodes, tip)
        return weights, weights
    _refuse_outside(nodes, tip)
    columns = _columns(nodes)
    plane = np.array([nodes[c[0], :2] for c in columns])
    triangles = _triangulated(plane) if triangles is None else triangles
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


def _columns(nodes: Array) -> list[Ints]:
    """Node numbers of every vertical column, from low to high z."""
    keys = {tuple(xy) for xy in nodes[:, :2]}
    out = []
    for x, y in sorted(keys):
        members = np.flatnonzero((nodes[:, 0] == x) & (nodes[:, 1] == y))
        out.append(members[np.argsort(nodes[members, 2])])
    return out


def _curve_weights(levels: Array, z: Array, curve: str = "through") -> Array:
    """Weights (n, levels) of the b-spline of one column at heights z.

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


def _triangulated(plane: Array) -> Any:
    """Delaunay triangulation of the columns (m, 2). Raises UsageError where they span no area."""
    from scipy.spatial import Delaunay

    spread = plane - plane[0]
    if np.linalg.matrix_rank(spread, tol=1e-9 * max(float(np.abs(spread).max()), 1e-300)) < 2:
        raise UsageError(
            f"residual_field: {len(plane)} columns of nodes lie on one line; between columns the field needs three that do not"
        )
    return Delaunay(plane)


def _triangle_weights(plane: Array, xy: Array, triangulation: Any) -> Array:
    """Barycentric weights (n, columns) on the triangles of the columns. Raises ModelLimit outside their hull."""
    simplex = triangulation.find_simplex(xy, tol=1e-9)
    if (simplex < 0).any():
        raise _outside(
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
            raise _outside(tip[bad[0]], "the grid of nodes", int(bad[0]))
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
        raise _outside(tip[bad[0]], f"the nodes' heights {low:g} to {high:g} mm", int(bad[0]))


def _refuse_beyond(column: Array, tip: Array, used: npt.NDArray[np.bool_]) -> None:
    """A curve through a column of nodes is not continued above or below it."""
    low, high = column[:, 2].min(), column[:, 2].max()
    bad = np.flatnonzero(used & ((tip[:, 2] < low - 1e-6) | (tip[:, 2] > high + 1e-6)))
    if len(bad):
        x, y = column[0, :2]
        raise _outside(
            tip[bad[0]], f"the column of nodes at ({x:g} {y:g}) mm, {low:g} to {high:g} mm high", int(bad[0])
        )


def _outside(point: Array, what: str, row: int) -> ModelLimit:
    at = " ".join(f"{v:.6g}" for v in point)
    return ModelLimit(
        f"row {row + 1}: the tip at ({at}) mm lies outside the hull of {what}; the residual field is not known there: "
        "move the part or measure more nodes",
        row=row,
    )


@dataclass(frozen=True, eq=False)
class CorrelatedField(Effect):
    """A Gaussian process over the volume: unit-variance kriging of correlated node draws, times a local deviation.

    tip error at x = s(x) w(x)^T values / sqrt(w^T K w), K_ij = exp(-|x_i - x_j|^2 / (2 length^2)),
    w = K^-1 k(x); s(x) = kernel-weighted mean of the nodes' standard deviations. `values` are drawn with covariance K
    per direction (see `covariance`), so the variance between nodes is that of the nodes, not less.
    """

    name = "correlated_field"
    per = "machine"
    cites = "Rasmussen & Williams, Gaussian Processes (2006), eq. 2.25, normalised to unit variance"
    diagnosis = ForDiagnosis(
        is_named=False,
    )
    nodes: Any = points(lambda: _unit_cube())
    deviation: Any = points(lambda: np.full((8, 3), 1e-3))
    length: float = 150.0
    values: Any = param(
        lambda: np.zeros((0, 3)),
        "1",
        "standardised node draws; zero when left out",
        shape="(nodes, 3)",
        typical=Typical(1.0, "standardised by its own deviations"),
    )

    def __post_init__(self) -> None:
        if np.size(self.values) == 0:
            object.__setattr__(self, "values", np.zeros(np.shape(self.nodes)))
        if not self.length > 0:
            raise UsageError(
                f"correlated_field: length = {self.length:g} mm must be positive; it is the distance over which the field changes"
            )
        if np.shape(self.deviation) != np.shape(self.nodes):
            raise UsageError(
                f"correlated_field: {len(self.deviation)} deviations for {len(self.nodes)} nodes; give one row of x y z per node"
            )

    @property
    def link(self) -> str:
        return "tip"

    def known_range(self) -> tuple[KnownRange, ...]:
        return _box(self.name, self.nodes)

    def error_motion(self, run: Run) -> Array:
        out = np.zeros((run.n, 6))
        weights, deviation = self._weights(run.tip)
        out[:, :3] = deviation * (weights @ np.asarray(self.values, dtype=float))
        return out

    def response(self, name: str, run: Run) -> Array:
        weights, deviation = self._weights(run.tip)
        out = np.zeros((run.n, 6, len(self.nodes), 3))
        for i in range(3):
            out[:, i, :, i] = deviation[:, i, None] * weights
        return out.reshape(run.n, 6, -1)

    def projected(self, name: str, run: Run, weights: Array) -> Array:
        shares, deviation = self._weights(run.tip)
        out = shares[:, :, None] * (weights[:, :3] * deviation)[:, None, :]
        return np.asarray(out.reshape(run.n, -1))

    def covariance(self) -> Array:
        """Covariance (3 nodes, 3 nodes) of `values` flattened: K for each direction, directions independent."""
        return np.asarray(np.kron(self._kernel(np.asarray(self.nodes, dtype=float)), np.eye(3)))

    @cached_property
    def _jittered(self) -> Array:
        """K with a jitter that keeps the factor stable."""
        return self._kernel(np.asarray(self.nodes, dtype=float)) + 1e-10 * np.eye(len(self.nodes))

    def _kernel(self, points: Array, nearest: bool = False) -> Array:
        """Correlation with the nodes; nearest: in units of that with the nearest one, which far away is below any number."""
        nodes = np.asarray(self.nodes, dtype=float)
        squared = ((points[:, None, :] - nodes) ** 2).sum(axis=2)
        if nearest:
            squared -= squared.min(axis=1, keepdims=True)
        return np.exp(-squared / (2 * self.length**2))

    def _weights(self, tip: Array) -> tuple[Array, Array]:
        nodes = np.asarray(self.nodes, dtype=float)
        low, high = nodes.min(axis=0), nodes.max(axis=0)
        bad = np.flatnonzero(((tip < low - 1e-6) | (tip > high + 1e-6)).any(axis=1))
        if len(bad):
            raise _outside(tip[bad[0]], "the nodes", int(bad[0]))
        near = self._kernel(tip, nearest=True)  # a factor per row falls out of both
        weights = np.linalg.solve(self._jittered, near.T).T
        size = np.sqrt((weights * near).sum(axis=1))  # w^T K w = w . k, since K w = k
        share = near / near.sum(axis=1, keepdims=True)
        return weights / size[:, None], share @ np.asarray(self.deviation, dtype=float)


def _box(name: str, nodes: Any) -> tuple[KnownRange, ...]:
    """The box of the nodes, within which a field is known."""
    points = np.asarray(nodes, dtype=float)
    ends = zip(points.min(axis=0), points.max(axis=0))
    return tuple(
        KnownRange(f"range of {name}", i, float(a), float(b), "tip") for i, (a, b) in enumerate(ends)
    )


def _unit_cube() -> Array:
    return np.array([[x, y, z] for x in (0.0, 1e4) for y in (0.0, 1e4) for z in (-1e4, 1e4)])


OVER_VOLUME = (
    ResidualField,
    CorrelatedField,
)  # stated over workpiece axes, known with rotary axes at zero only
