"""Residual error fields: what a compensated machine still does, given at nodes of its volume.

ResidualField: node vectors interpolated as in Gaska et al. 2014 ("columns": a b-spline along z through the nodes of
each vertical column, or with the nodes as its control points, then linear on Delaunay triangles of the columns or the nearest
column; the z error from the nearest node) or trilinear on a rectangular grid. Interpolating independent draws shrinks the variance between the
nodes; CorrelatedField keeps it: a Gaussian process whose standard deviation follows the nodes'. So does a ResidualField that states a
`process`, as `vcmm calibrate --nodes` writes it: see `residual_process`.
All vectors are tip errors (actual - nominal) in workpiece axes. Outside the nodes' hull the field is refused.
"""

from __future__ import annotations

from dataclasses import dataclass, field
from functools import cached_property
from typing import Any, ClassVar

import numpy as np

from vcmm.core.declaration import UM, About, ForDiagnosis, KnownRange, Tabulated, Trade, Typical, WithResponse
from vcmm.core.effect import POINTS, Effect, param, points
from vcmm.core.errors import UsageError
from vcmm.core.laws import Law, MultivariateNormal
from vcmm.core.residual_process import Booleans, FieldProcess, margin, process_of
from vcmm.core.residual_weights import (
    CURVES,
    METHODS,
    columns_of,
    field_weights,
    known_row_by_row,
    outside,
    triangulate,
)
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class ResidualField(Effect, WithResponse, Tabulated):
    """Tip errors at nodes, interpolated; with `process` a Gaussian process of two shares, as `vcmm calibrate --nodes` writes it.

    With process = { margins, dof, length_scales_mm, amplitude_um, correlation }:

        systematic   what the machine errs by at the nodes every time; redraw = "machine". Law: normal, of the readings at the first nodes
                     (their u: reading_u) and a process of Matern 5/2 with these length scales and amplitudes; the effect gives the law itself
        random       what one approach adds, three numbers of unit scale; redraw = "touch". Law: t of `dof` degrees of freedom, or normal
                     (`margins`), given by the effect itself. Times s(x): the rows of `scatter`, linear in s^2 between the nodes, and the correlation
                     of X, Y, Z (`correlation`; the margins hold along its principal directions)

    Equal s at all nodes is the same s everywhere. Without process, `values` (and `systematic`) are interpolated: interpolation =
    "columns-linear", "columns-nearest" or "trilinear", curve = "through" or "control"; independent draws of them lose variance between the nodes,
    which every result then says, and `place` gives no advice.
    """

    name = "residual_field"
    about = About(
        cites="Gaska et al., Int. J. Adv. Manuf. Technol. 73 (2014) 497, section 4",
        trade=Trade("what the calibration leaves in the volume", "calibrate with more positions"),
    )
    per = "machine"
    diagnosis = ForDiagnosis(
        is_named=False,
    )
    independent_draws: ClassVar[str] = (
        "residual_field interpolates independent draws of its nodes, whose variance shrinks between them: U is too small there, and a "
        "pose may gain from that and not from the machine; write the field anew with `vcmm calibrate --nodes`, or give "
        "correlated_field its covariance, as `vcmm place gaska2014` does"
    )
    counted_twice: ClassVar[str] = (
        "[repeatability] and the random share of residual_field both add to every touch: the scatter of the approaches of which the field was "
        "found holds that of the machine, and may be counted twice; take [repeatability] out, or keep in it what the probe alone adds"
    )
    nodes: Any = field(
        default_factory=lambda: _unit_cube(),
        metadata={"kind": POINTS, "doc": "(nodes, 3) mm: places, those that were read first"},
    )
    interpolation: str = field(
        default="trilinear", metadata={"doc": f"without process: {', '.join(METHODS)}"}
    )
    values: Any = param(
        lambda: np.zeros((0, 3)),
        "um",
        "tip error at the nodes; zero when left out",
        shape="(nodes, 3)",
        typical=Typical(1 * UM, "what compensation leaves: 0.5-3 um"),
    )
    curve: str = field(default="through", metadata={"doc": f"of columns: {', '.join(CURVES)}"})
    systematic: Any = param(
        lambda: np.zeros((0, 3)),
        "um",
        "tip error at the nodes that comes back every time; zero when left out",
        shape="(nodes, 3)",
        typical=Typical(1 * UM, "what compensation leaves: 0.5-3 um"),
    )
    random: Any = param(
        lambda: np.zeros(3),
        "1",
        "of one approach, in units of its scatter at that place; of a process only",
        shape="(3)",
        typical=Typical(1.0, "standardised by the scatter"),
    )
    scatter: Any = field(
        default_factory=lambda: np.zeros((0, 3)),
        metadata={
            "kind": POINTS,
            "doc": "(readings, 3) um, of a process: scale of the law of one approach at each node that was read",
        },
    )
    reading_u: Any = field(
        default_factory=lambda: np.zeros((0, 3)),
        metadata={
            "kind": POINTS,
            "doc": "(readings, 3) um, of a process: standard uncertainty of the mean deviation of these nodes",
        },
    )
    process: Any = field(
        default=None,
        metadata={
            "kind": "process",
            "doc": '{ margins = "t" | "normal", dof, length_scales_mm (3), amplitude_um (3), correlation (3, 3) }',
        },
    )

    def __post_init__(self) -> None:
        for name in ("values", "systematic"):
            if np.size(getattr(self, name)) == 0:
                object.__setattr__(self, name, np.zeros(np.shape(self.nodes)))
        _check_rows(self)
        if self.process is not None:
            _ = self.gaussian  # refuses what does not fit
        elif np.size(self.scatter) or np.size(self.reading_u):
            raise UsageError(
                "residual_field: scatter and reading_u belong to a process; add process = { margins, ... } (vcmm explain residual_field)"
            )
        if self.interpolation not in METHODS:
            raise UsageError(
                f'residual_field: interpolation = "{self.interpolation}"; allowed: {", ".join(METHODS)}'
            )
        if self.curve not in CURVES:
            raise UsageError(f'residual_field: curve = "{self.curve}"; allowed: {", ".join(CURVES)}')

    @cached_property
    def gaussian(self) -> FieldProcess | None:
        """The process of the field, None where the nodes are interpolated. Raises UsageError for a table that states none."""
        if self.process is None:
            return None
        numbers = (np.asarray(v, dtype=float) for v in (self.nodes, self.scatter, self.reading_u))
        return process_of(self.process, *numbers)

    def own_law(self, name: str) -> Law | MultivariateNormal | None:
        if self.gaussian is None or name == "values":
            return None
        return (
            MultivariateNormal(self.gaussian.covariance()) if name == "systematic" else margin(self.process)
        )

    def covers(self, tip: Array) -> Booleans:
        """Return whether the field is known at each tip (n,)."""
        if self.gaussian is not None:
            return self.gaussian.inside(tip)
        return known_row_by_row(self._weights, tip)

    @property
    def link(self) -> str:
        return "tip"

    def known_range(self) -> tuple[KnownRange, ...]:
        return _box(self.name, self.nodes)

    def error_motion(self, run: Run) -> Array:
        lateral, vertical = self._weights(run.tip)
        values = np.asarray(self.values, dtype=float) + np.asarray(self.systematic, dtype=float)
        out = np.zeros((run.n, 6))
        out[:, :2] = lateral @ values[:, :2]
        out[:, 2] = vertical @ values[:, 2]
        if self.gaussian is not None and np.any(self.random):
            out[:, :3] += self._random(run) @ np.asarray(self.random, dtype=float)
        return out

    def response(self, name: str, run: Run) -> Array:
        lateral, vertical = self._weights(run.tip)
        if name == "random":
            out = np.zeros((run.n, 6, 3))
            out[:, :3] = self._random(run)
            return out
        out = np.zeros((run.n, 6, len(self.nodes), 3))
        out[:, 0, :, 0] = out[:, 1, :, 1] = lateral
        out[:, 2, :, 2] = vertical
        return out.reshape(run.n, 6, -1)

    def projection(self, name: str, run: Run, weights: Array) -> Array:
        if name == "random":
            return np.asarray(np.einsum("ni,nik->nk", weights[:, :3], self._random(run)))
        lateral, vertical = self._weights(run.tip)
        out = np.empty((run.n, len(self.nodes), 3))
        for i, share in enumerate((lateral, lateral, vertical)):
            out[:, :, i] = weights[:, i, None] * share
        return out.reshape(run.n, -1)

    def _random(self, run: Run) -> Array:
        """Return the tip error by each of the three numbers of one approach, (n, 3, 3) mm."""
        process = self.gaussian
        if process is None:
            return np.zeros((run.n, 3, 3))
        refuse_outside(process, run.tip)
        return np.asarray(process.scatter_at(run.tip)[:, :, None] * process.principal)

    @cached_property
    def _triangles(self) -> Any:
        nodes = np.asarray(self.nodes, dtype=float)
        return triangulate(np.array([nodes[c[0], :2] for c in columns_of(nodes)]))

    def _weights(self, tip: Array) -> tuple[Array, Array]:
        process = self.gaussian
        if process is not None:
            refuse_outside(process, tip)
            shares = process.weights(tip)
            return shares, shares
        triangles = None if self.interpolation == "trilinear" else self._triangles
        nodes = np.asarray(self.nodes, dtype=float)
        return field_weights(nodes, self.interpolation, tip, triangles, self.curve)


def _check_rows(field: ResidualField) -> None:
    for name in ("values", "systematic"):
        if np.shape(getattr(field, name)) != np.shape(field.nodes):
            raise UsageError(
                f"residual_field: {len(getattr(field, name))} {name} for {len(field.nodes)} nodes; give one row of x y z per node"
            )
    if np.size(field.random) != 3:
        raise UsageError(f"residual_field: random has three numbers, x y z, not {np.size(field.random)}")


def refuse_outside(process: FieldProcess, tip: Array) -> None:
    """Raises ModelLimit for a place outside the hull of the nodes that were read."""
    bad = np.flatnonzero(~process.inside(tip))
    if len(bad):
        raise outside(tip[bad[0]], "the nodes", int(bad[0]))


@dataclass(frozen=True, eq=False)
class CorrelatedField(Effect, WithResponse, Tabulated):
    """A Gaussian process over the volume: unit-variance kriging of correlated node draws, times a local deviation.

    tip error at x = s(x) w(x)^T values / sqrt(w^T K w), K_ij = exp(-|x_i - x_j|^2 / (2 length^2)),
    w = K^-1 k(x); s(x) = kernel-weighted mean of the nodes' standard deviations. `values` are sampled with covariance K
    per direction (see `covariance`), so the variance between nodes is that of the nodes, not less.
    """

    name = "correlated_field"
    about = About(
        cites="Rasmussen & Williams, Gaussian Processes (2006), eq. 2.25, normalised to unit variance",
        trade=Trade(
            "errors of the machine within its certificate",
            "calibrate the machine: a certificate alone is wide",
        ),
    )
    per = "machine"
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

    def projection(self, name: str, run: Run, weights: Array) -> Array:
        shares, deviation = self._weights(run.tip)
        out = shares[:, :, None] * (weights[:, :3] * deviation)[:, None, :]
        return np.asarray(out.reshape(run.n, -1))

    def covers(self, tip: Array) -> Booleans:
        """Return whether the field is known at each tip (n,)."""
        nodes = np.asarray(self.nodes, dtype=float)
        inside = (tip >= nodes.min(axis=0) - 1e-6) & (tip <= nodes.max(axis=0) + 1e-6)
        return np.asarray(inside.all(axis=1), dtype=bool)

    def covariance(self) -> Array:
        """Return the covariance (3 nodes, 3 nodes) of `values` flattened: K for each direction, directions independent."""
        return np.asarray(np.kron(self._kernel(np.asarray(self.nodes, dtype=float)), np.eye(3)))

    @cached_property
    def _regularised_covariance(self) -> Array:
        """Covariance K with a jitter that keeps the factor stable."""
        return self._kernel(np.asarray(self.nodes, dtype=float)) + 1e-10 * np.eye(len(self.nodes))

    def _kernel(self, points: Array, nearest: bool = False) -> Array:
        """Return the correlation with the nodes; nearest: in units of the correlation with the nearest node, which underflows far away."""
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
            raise outside(tip[bad[0]], "the nodes", int(bad[0]))
        near = self._kernel(tip, nearest=True)  # a factor per row falls out of both
        weights = np.linalg.solve(self._regularised_covariance, near.T).T
        size = np.sqrt((weights * near).sum(axis=1))  # w^T K w = w . k, since K w = k
        share = near / near.sum(axis=1, keepdims=True)
        return weights / size[:, None], share @ np.asarray(self.deviation, dtype=float)


def _box(name: str, nodes: Any) -> tuple[KnownRange, ...]:
    """Return the box of the nodes, within which a field is known."""
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
