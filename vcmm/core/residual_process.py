"""A residual field as a Gaussian process: predict the field between nodes from readings at the nodes.

The field has two separate shares:

    systematic   what the machine errs by at a place every time: a Gaussian process of zero mean, amplitude a_i in direction i and
                 correlation k(r) = (1 + q + q^2/3) exp(-q), q = sqrt(5) r, r^2 = sum (dx_j / length_j)^2 (Matern, order 5/2; Rasmussen &
                 Williams, Gaussian Processes, 2006, eq. 4.17), read at the first nodes with u: eq. 2.23 and 2.24 there, at all nodes
    random       what one approach adds: s_i(x) (V sqrt(D))_ij z_j, z of unit scale, V D V^T the correlation of X, Y, Z. s_i^2 is linear
                 on the tetrahedra of the readings, so that equal s at all nodes is the same s everywhere

Between its nodes the systematic share is w(x)^T values / sqrt(w^T K w), w = K^-1 k(x): the process's own variance stays (see CorrelatedField).
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from functools import cached_property
from typing import Any

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.laws import Law, Normal, StudentT
from vcmm.core.run import Array

Booleans = npt.NDArray[np.bool_]
MARGINS = ("t", "normal")
KEYS = ("margins", "dof", "length_scales_mm", "amplitude_um", "correlation")
JITTER = 1e-10


def correlation_of(a: Array, b: Array, lengths: Array) -> Array:
    """Return the Matern 5/2 correlation (n, m) of points (n, 3) with points (m, 3) mm."""
    scaled = (a[:, None, :] - b[None, :, :]) / lengths
    q = np.sqrt(5.0 * (scaled**2).sum(axis=2))
    return np.asarray((1 + q + q**2 / 3) * np.exp(-q))


@dataclass(frozen=True, eq=False)
class FieldProcess:
    """A Gaussian process at nodes. nodes (m, 3) mm, of which the first k carry readings: reading_u, scatter (k, 3) mm.
    lengths (3,) and amplitude (3,) mm; see the docstring of the module."""

    nodes: Array
    scatter: Array
    reading_u: Array
    lengths: Array
    amplitude: Array
    correlation: Array

    @property
    def readings(self) -> int:
        return len(self.scatter)

    @cached_property
    def _inverse_correlation(self) -> Array:
        """Inverse of the correlation of the nodes (m, m)."""
        correlation = correlation_of(self.nodes, self.nodes, self.lengths)
        return np.asarray(np.linalg.inv(correlation + JITTER * np.eye(len(correlation))))

    def weights(self, tip: Array) -> Array:
        """Return the weights (n, m) of the values of the nodes; the variance of the process is the same everywhere."""
        near = correlation_of(tip, self.nodes, self.lengths)
        weights = near @ self._inverse_correlation
        return np.asarray(weights / np.sqrt((weights * near).sum(axis=1))[:, None])

    def posterior(self, read: Array | None = None) -> tuple[Array, Array]:
        """Return (mean (m, 3), covariance (3, m, m)) mm, mm^2 of the systematic share at all nodes, from deviations `read` (k, 3), zero
        unless given."""
        k, among = self.readings, correlation_of(self.nodes, self.nodes, self.lengths)
        mean, covariance = np.zeros(self.nodes.shape), np.zeros((3, len(among), len(among)))
        for i, size in enumerate(self.amplitude**2):
            prior = size * among
            noisy = prior[:k, :k] + np.diag(self.reading_u[:, i] ** 2 + JITTER * size)
            gain = np.linalg.solve(noisy, prior[:k]).T
            rest = prior - gain @ prior[:k]
            covariance[i] = (rest + rest.T) / 2
            if read is not None:
                mean[:, i] = gain @ read[:, i]
        return mean, covariance

    def covariance(self) -> Array:
        """Return the covariance (3 m, 3 m) mm^2 of the systematic share node by node, x y z; directions are independent."""
        m, blocks = len(self.nodes), self.posterior()[1]
        out = np.zeros((m, 3, m, 3))
        for i in range(3):
            out[:, i, :, i] = blocks[i]
        return out.reshape(3 * m, 3 * m)

    @cached_property
    def principal(self) -> Array:
        """Principal axes V sqrt(D) of the scatter (3, 3)."""
        values, vectors = np.linalg.eigh(self.correlation)
        vectors = vectors * np.where(vectors.sum(axis=0) < 0, -1.0, 1.0)
        return np.asarray(vectors * np.sqrt(np.maximum(values, 0.0)))

    @cached_property
    def _tetrahedra(self) -> Any:
        from scipy.spatial import Delaunay

        return Delaunay(self.nodes[: self.readings])

    def inside(self, tip: Array) -> Booleans:
        """Return whether each place lies within the hull of the readings (n,)."""
        return np.asarray(self._tetrahedra.find_simplex(tip, tol=1e-7) >= 0, dtype=bool)

    def scatter_at(self, tip: Array) -> Array:
        """Return the scatter s at the places (n, 3) mm. The places must lie inside."""
        mesh = self._tetrahedra
        cell = mesh.find_simplex(tip, tol=1e-7)
        three = np.einsum("nij,nj->ni", mesh.transform[cell, :3], tip - mesh.transform[cell, 3])
        shares = np.concatenate([three, 1 - three.sum(axis=1, keepdims=True)], axis=1)
        variance = np.einsum("nc,nci->ni", shares, self.scatter[mesh.simplices[cell]] ** 2)
        return np.asarray(np.sqrt(np.maximum(variance, 0.0)))


def process_of(table: Any, nodes: Array, scatter: Array, reading_u: Array) -> FieldProcess:
    """Return the process that a file states. Raises UsageError naming the word that is wrong."""
    if not isinstance(table, Mapping):
        raise UsageError(f"residual_field: process must be a table with {', '.join(KEYS)}")
    for key in table:
        if key not in KEYS:
            raise UsageError(f'residual_field: unknown key "{key}" of process.{choose_from(key, KEYS)}')
    if (margins := table.get("margins", "t")) not in MARGINS:
        raise UsageError(f'residual_field: process margins = "{margins}"; allowed: {", ".join(MARGINS)}')
    _check_dof(table)
    lengths, amplitude = (_numbers(table, key, (3,)) for key in ("length_scales_mm", "amplitude_um"))
    correlation = _numbers(table, "correlation", (3, 3)) if "correlation" in table else np.eye(3)
    if (lengths <= 0).any() or (amplitude <= 0).any():
        raise UsageError("residual_field: length_scales_mm and amplitude_um of process must be above zero")
    fine = np.allclose(correlation, correlation.T) and np.allclose(np.diag(correlation), 1.0)
    if not fine or np.linalg.eigvalsh(correlation)[0] < -1e-9:
        raise UsageError(
            "residual_field: correlation of process must be symmetric with ones on its diagonal and no negative eigenvalue"
        )
    for name, rows in (("scatter", scatter), ("reading_u", reading_u)):
        if rows.ndim != 2 or rows.shape[1] != 3 or not 4 <= len(rows) <= len(nodes) or (rows < 0).any():
            raise UsageError(
                f"residual_field: {name} of a process has one row of x y z, none negative, for each of the first nodes, those that were read: "
                f"4 to {len(nodes)} rows"
            )
    if len(scatter) != len(reading_u):
        raise UsageError(
            f"residual_field: {len(scatter)} rows of scatter and {len(reading_u)} of reading_u; both are those of the readings"
        )
    first = nodes[: len(scatter)]
    if np.linalg.matrix_rank(first - first[0], tol=1e-6 * max(float(np.ptp(first)), 1e-300)) < 3:
        raise UsageError(
            "residual_field: the nodes of a process lie in one plane; measure nodes at several heights"
        )
    return FieldProcess(nodes, scatter, reading_u, lengths, amplitude * 1e-3, correlation)


def margin(table: Mapping[str, Any]) -> Law:
    """Return the law of each of the three numbers of one approach, of unit scale."""
    return Normal(1.0) if table.get("margins", "t") == "normal" else StudentT(1.0, float(table["dof"]))


def _check_dof(table: Mapping[str, Any]) -> None:
    """Check the degrees of freedom: t margins need more than 2, below which there is no standard deviation; normal margins have none."""
    dof = table.get("dof")
    if table.get("margins", "t") == "normal":
        if dof is not None:
            raise UsageError("residual_field: process has normal margins, which have no dof; remove it")
    elif isinstance(dof, bool) or not isinstance(dof, int | float) or not dof > 2:
        raise UsageError(
            'residual_field: process with t margins needs dof above 2, as in dof = 13, or margins = "normal"'
        )


def _numbers(table: Mapping[str, Any], key: str, shape: tuple[int, ...]) -> Array:
    try:
        values = np.array(table[key], dtype=float)
    except (KeyError, TypeError, ValueError):
        values = np.zeros(0)
    if values.shape != shape or not np.isfinite(values).all():
        shape_text = (
            "three numbers, as in [250, 250, 200]" if shape == (3,) else "three rows of three numbers"
        )
        raise UsageError(f"residual_field: process needs {key} of {shape_text}")
    return values
