"""Estimate from a measured part the scatter of a machine tool from move to move, from pass to pass and along a pass.

    rest = F b + u f (M m sqrt(a) + P p sqrt(b) + S s sqrt(c)) + e        m, p, s ~ N(0, 1), a + b + c = 1, cov(e) = the other uncertainties

A machine file states one scatter u, and how it goes on along a pass (S, `vcmm.shop.machining.passes`). An axis that stops anew at every
block, or a pass that is shifted as a whole, has fewer independent draws, and a few draws over many points look like physics.
So a draw along X, Y and Z per move (M) and per pass (P) is added: how the variance is shared between the three (a, b, c, no
share before another) and how large it is (f, about 1: odds fall as 1 + (ln f / ln 2)^2 grows) is learnt from the restricted likelihood
beside the columns F of everything that is tested on the part (position, direction, speed, time, feed, wear, force), so that an error of
the machine of these shapes is not taken for scatter. Of the posterior the mean shares and the median of f are taken.
Source: Patterson, Thompson, Biometrika 58 (1971) 545 (restricted likelihood).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt

from vcmm.core.inputs import Input
from vcmm.core.laws import Law
from vcmm.core.run import Array
from vcmm.physics.structure.scatter import Scatter
from vcmm.shop.machining.mismatch import ObservedPoints, locate_mismatch, machine_shapes
from vcmm.shop.machining.passes import MOVE, PASS

KnownOf = tuple[tuple[str, Array], ...]
SCATTER = f"{Scatter.name}."
Ints = npt.NDArray[np.intp]
TOTALS = np.array([0.25, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 2.8, 4.0, 8.0, 16.0])  # times the stated scatter
DOUBT = np.log(2.0)  # of the logarithm of the total: a statement is believed to a factor of two
STEPS = 4  # of a share on the grid
LEAST_FREEDOM = 3  # numbers left beside the shapes; with fewer nothing is learnt
MORE = 0.975  # probability that the scatter is larger than stated, from which on it is reported
TWICE = 2.0  # times the stated variance, from which on it is larger


@dataclass(frozen=True, eq=False)
class ScatterSizes:
    """per_move, per_pass: standard deviation along each direction, mm; along: factor on the scatter that is stated; columns (n, r): of all three,
    mm per draw of unit variance along the normals; stated: mm, 0 where nothing is; is_larger: the part shows more than is stated."""

    per_move: float
    per_pass: float
    along: float
    stated: float
    columns: tuple[tuple[str, Array], ...]
    is_larger: bool

    @property
    def total(self) -> float:
        """Standard deviation of one point along one direction, mm."""
        return float(np.sqrt(self.per_move**2 + self.per_pass**2 + (self.along * self.stated) ** 2))


def found_scatter(
    points: ObservedPoints, common: KnownOf, single: Array, rigid: bool, u_point: float | None, inputs: tuple[Input, ...]
) -> ScatterSizes:  # fmt: skip
    """Estimate the sizes from a measured part. common, single: columns of what is known to be uncertain; u_point: as stated, else it is
    found beside what
    the file states; inputs: of the machine that cut."""
    stated = [i.law.u for i in inputs if i.effect == Scatter.name and isinstance(i.law, Law)]
    empty = np.zeros((len(points.rest), 0))
    scatter = np.hstack([empty, *(c for name, c in common if name.startswith(SCATTER))])
    rest = np.hstack([empty, *(c for name, c in common if not name.startswith(SCATTER))])
    alone = locate_mismatch(points, rigid=rigid).scatter if u_point is None else u_point
    other = rest @ rest.T + np.diag((single**2).sum(axis=1) + alone**2)
    groups = tuple(points.run.columns[name].astype(np.intp) for name in (MOVE, PASS))
    return scatter_sizes(
        points.rest, other, machine_shapes(points, rigid), stated=scatter, normals=points.normals, groups=(groups[0], groups[1]),
        u=float(max(stated, default=0.0)), u_point=alone,
    )  # fmt: skip


def with_scatter(common: KnownOf, sizes: ScatterSizes) -> KnownOf:
    """Return the known uncertainty with the estimated scatter."""
    return (*sizes.columns, *(c for c in common if not c[0].startswith(SCATTER)))


def scatter_notes(sizes: ScatterSizes) -> tuple[str, ...]:
    """Return the notes where the part shows more scatter than the machine file states."""
    if not sizes.is_larger:
        return ()
    return (
        f"the machine scatters by {sizes.total * 1e3:.2f} µm in this part ({sizes.per_move * 1e3:.2f} µm from move to move, {sizes.per_pass * 1e3:.2f} µm from pass to "
        f"pass), and [repeatability] of the machine file states {sizes.stated * 1e3:.2f} µm; no program takes that away: measure a second part of the same program",
    )


def scatter_sizes(
    rest: Array, other: Array, shapes: Array, stated: Array, normals: Array, groups: tuple[Ints, Ints], u: float, u_point: float
) -> ScatterSizes:  # fmt: skip
    """Return the sizes of the scatter per move and per pass.

    rest (n,) mm; other (n, n) mm^2: covariance of everything else that is uncertain, points included; shapes (n, k): F; stated (n, r): columns of
    the scatter that the machine file states, mm; normals (n, 3); groups: number of the move and of the pass of each point; u: what the
    file states, mm, 0 where it states nothing: then sizes are looked for beside `u_point`, the scatter of one point.
    """
    unit = u or u_point
    each = [_by_group(normals, group) for group in groups]
    kernels = [unit**2 * (c @ c.T) for c in each]
    shares = _shares(bool(stated.shape[1]))
    weights = np.outer(_prior(), np.full(len(shares), 1.0 / len(shares)))
    free = _complement(shapes, len(rest))
    if free.shape[1] >= LEAST_FREEDOM:
        covariances = [free.T @ k @ free for k in (other, *kernels, stated @ stated.T)]
        weights = _posterior(free.T @ rest, covariances, shares)
    total = _median(weights.sum(axis=1), TOTALS)
    move, whole, along = total * np.sqrt(weights.sum(axis=0) @ shares)
    columns = (
        *((("scatter.value", along * stated),) if stated.shape[1] else ()),
        *((f"scatter.per_{what}", size * unit * c) for what, size, c in zip(("move", "pass"), (move, whole), each)),
    )  # fmt: skip
    larger = float(weights.sum(axis=1)[np.square(TOTALS) > TWICE].sum())
    return ScatterSizes(
        float(move * unit), float(whole * unit), float(along), u, columns, is_larger=bool(u) and larger >= MORE
    )  # fmt: skip


def _by_group(normals: Array, group: Ints) -> Array:
    """Return the columns (n, 3 g): a draw along X, Y, Z for each group, as it shows along the normals."""
    number = np.unique(group, return_inverse=True)[1]
    out = np.zeros((len(normals), number.max() + 1, 3))
    out[np.arange(len(normals)), number] = normals
    flat = out.reshape(len(normals), -1)
    return np.asarray(flat[:, np.abs(flat).max(axis=0) > 0])


def _complement(shapes: Array, n: int) -> Array:
    """Return the orthonormal directions (n, m) that no combination of the shapes has."""
    if not shapes.shape[1]:
        return np.eye(n)
    scale = np.linalg.norm(shapes, axis=0)
    u, s, _ = np.linalg.svd(shapes[:, scale > 0] / scale[scale > 0], full_matrices=True)
    return np.asarray(u[:, int(np.sum(s > 1e-9 * s[0])) :])


def _shares(is_stated: bool) -> Array:
    """Return the rows (k, 3) of shares of move, pass and what is stated along a pass; without the last where nothing is stated."""
    every = [
        (i, j, STEPS - i - j)
        for i in range(STEPS + 1)
        for j in range(STEPS + 1 - i)
        if is_stated or i + j == STEPS
    ]
    return np.array(every, dtype=float) / STEPS


def _prior() -> Array:
    """Return the probability of each total: the grid is even in its logarithm but for its wide upper end."""
    weight = np.gradient(np.log(TOTALS)) / (1.0 + (np.log(TOTALS) / DOUBT) ** 2)
    return np.asarray(weight / weight.sum())


def _posterior(y: Array, covariances: list[Array], shares: Array) -> Array:
    """Return the probability (totals, shares)."""
    other, *kernels = covariances
    log = np.empty((len(TOTALS), len(shares)))
    for j, share in enumerate(shares):
        kernel = sum((s * k for s, k in zip(share, kernels)), np.zeros_like(other))
        for i, total in enumerate(TOTALS):
            log[i, j] = _log_likelihood(y, other + total**2 * kernel)
    weights = _prior()[:, None] * np.exp(log - log.max())
    return np.asarray(weights / weights.sum())


def _log_likelihood(y: Array, cov: Array) -> float:
    from scipy.linalg import LinAlgError, cho_factor, cho_solve

    try:
        factor = cho_factor(cov, lower=True, check_finite=False)
    except LinAlgError:
        return -np.inf
    return float(-np.log(np.diag(factor[0])).sum() - 0.5 * y @ cho_solve(factor, y, check_finite=False))


def _median(weight: Array, grid: Array) -> float:
    """Return the median of a probability on a grid, by its cumulated sum between the places."""
    edges = np.sqrt(grid[1:] * grid[:-1])
    edges = np.concatenate([[grid[0]], edges, [grid[-1]]])
    return float(np.exp(np.interp(0.5, np.concatenate([[0.0], np.cumsum(weight)]), np.log(edges))))
