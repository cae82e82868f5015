"""How much a machine tool scatters from move to move and from pass to pass, found in a measured part.

    rest = F b + M m + P p + f S s + e       m ~ N(0, u_m^2), p ~ N(0, u_p^2), s ~ N(0, 1), cov(e) = what else is uncertain

A machine file states one scatter, and how it goes on along a pass (S, `vcmm.shop.machining.passes`). An axis that stops anew at every
block, or a pass that lies aside as a whole, has fewer independent draws, and what a few draws make of many points looks like physics.
So a draw along X, Y and Z per move (M) and per pass (P) stands beside it. The sizes are those of restricted maximum likelihood beside
the columns F of everything that the part is asked for (position, direction, speed, time, feed, wear, force), so that an error of the
machine of these shapes is not taken for scatter, with a half-Cauchy prior at the stated scatter; of the posterior the median is taken.
Sources: Patterson, Thompson, Biometrika 58 (1971) 545; Gelman, Bayesian Analysis 1 (2006) 515 (the prior).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
import numpy.typing as npt
from scipy.linalg import LinAlgError, cho_factor, cho_solve

from vcmm.core.inputs import Input
from vcmm.core.laws import Law
from vcmm.core.run import Array
from vcmm.physics.structure.scatter import Scatter
from vcmm.shop.machining.mismatch import ObservedPoints, locate_mismatch, machine_shapes
from vcmm.shop.machining.passes import MOVE, PASS

KnownOf = tuple[tuple[str, Array], ...]
SCATTER = f"{Scatter.name}."
Ints = npt.NDArray[np.intp]
SIZES = np.array([0.0, 0.15, 0.3, 0.5, 0.7, 1.0, 1.4, 2.0, 3.0, 5.0, 10.0, 20.0])  # of the stated scatter
FACTORS = np.array([0.0, 0.35, 0.5, 0.7, 1.0, 1.4, 2.0, 4.0])  # on what is stated along a pass
SPREAD = np.log(2.0)  # of the factor, as its statement is believed
LEAST_FREEDOM = 3  # numbers left beside the shapes; with fewer nothing is learnt
MORE = 0.975  # probability that the scatter is larger than stated, from which on it is said


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
    """The sizes in a measured part. common, single: columns of what is known to be uncertain; u_point: as stated, else it is found beside what
    the file states; inputs: of the machine that cut."""
    stated = [i.law.u for i in inputs if i.effect == Scatter.name and isinstance(i.law, Law)]
    empty = np.zeros((len(points.rest), 0))
    scatter = np.hstack([empty, *(c for name, c in common if name.startswith(SCATTER))])
    rest = np.hstack([empty, *(c for name, c in common if not name.startswith(SCATTER))])
    alone = locate_mismatch(points, rigid=rigid).scatter if u_point is None else u_point
    other = rest @ rest.T + np.diag((single**2).sum(axis=1) + alone**2)
    groups = tuple(points.run.columns[name].astype(np.intp) for name in (MOVE, PASS))
    return scatter_sizes(
        points.rest, other, machine_shapes(points, rigid), scatter, points.normals, (groups[0], groups[1]), float(max(stated, default=0.0)), alone
    )  # fmt: skip


def with_scatter(common: KnownOf, sizes: ScatterSizes) -> KnownOf:
    """What is known to be uncertain with the scatter as it was found."""
    return (*sizes.columns, *(c for c in common if not c[0].startswith(SCATTER)))


def scatter_notes(sizes: ScatterSizes) -> tuple[str, ...]:
    """What is to be told where the part shows more scatter than the machine file states."""
    if not sizes.is_larger:
        return ()
    return (
        f"the machine scatters by {sizes.total * 1e3:.2f} µm in this part ({sizes.per_move * 1e3:.2f} µm from move to move, {sizes.per_pass * 1e3:.2f} µm from pass to "
        f"pass), and [repeatability] of the machine file states {sizes.stated * 1e3:.2f} µm; no program takes that away: measure a second part of the same program",
    )


def scatter_sizes(
    rest: Array, other: Array, shapes: Array, stated: Array, normals: Array, groups: tuple[Ints, Ints], u: float, u_point: float
) -> ScatterSizes:  # fmt: skip
    """Sizes of the scatter per move and per pass.

    rest (n,) mm; other (n, n) mm^2: covariance of everything else that is uncertain, points included; shapes (n, k): F; stated (n, r): columns of
    the scatter that the machine file states, mm; normals (n, 3); groups: number of the move and of the pass of each point; u: what the
    file states, mm, 0 where it states nothing: then sizes are looked for beside `u_point`, the scatter of one point.
    """
    unit = u or u_point
    each = [_by_group(normals, group) for group in groups]
    kernels = [unit**2 * (c @ c.T) for c in each]
    free = _complement(shapes, len(rest))
    weights = np.ones((1, 1, 1))
    factors = FACTORS if stated.shape[1] else np.ones(1)
    if free.shape[1] >= LEAST_FREEDOM:
        seen = [free.T @ k @ free for k in (other, stated @ stated.T, *kernels)]
        weights = _posterior(free.T @ rest, seen, factors)
        move, whole, along = (
            _median(weights.sum(axis=axes), grid)
            for axes, grid in (((0, 2), SIZES), ((0, 1), SIZES), ((1, 2), factors))
        )
    else:
        move, whole, along = 1.0, 1.0, 1.0
    columns = (
        *((("scatter.value", along * stated),) if stated.shape[1] and along else ()),
        *((f"scatter.per_{what}", size * unit * c) for what, size, c in zip(("move", "pass"), (move, whole), each) if size),
    )  # fmt: skip
    return ScatterSizes(
        move * unit,
        whole * unit,
        along,
        u,
        columns,
        _is_larger(weights, factors, unit, u),
    )


def _by_group(normals: Array, group: Ints) -> Array:
    """Columns (n, 3 g): a draw along X, Y, Z for each group, as it shows along the normals."""
    number = np.unique(group, return_inverse=True)[1]
    out = np.zeros((len(normals), number.max() + 1, 3))
    out[np.arange(len(normals)), number] = normals
    flat = out.reshape(len(normals), -1)
    return np.asarray(flat[:, np.abs(flat).max(axis=0) > 0])


def _complement(shapes: Array, n: int) -> Array:
    """Orthonormal directions (n, m) that no combination of the shapes has."""
    if not shapes.shape[1]:
        return np.eye(n)
    scale = np.linalg.norm(shapes, axis=0)
    u, s, _ = np.linalg.svd(shapes[:, scale > 0] / scale[scale > 0], full_matrices=True)
    return np.asarray(u[:, int(np.sum(s > 1e-9 * s[0])) :])


def _posterior(y: Array, seen: list[Array], factors: Array) -> Array:
    """Probability (factors, moves, passes) on the grid of sizes."""
    other, along, move, whole = seen
    log = np.full((len(factors), len(SIZES), len(SIZES)), -np.inf)
    for i, f in enumerate(factors):
        for j, a in enumerate(SIZES):
            base = other + f**2 * along + a**2 * move
            for k, b in enumerate(SIZES):
                log[i, j, k] = _log_likelihood(y, base + b**2 * whole)
    prior = -np.log1p(SIZES**2) + np.log(np.gradient(SIZES))
    believed = (
        np.where(
            factors > 0, -0.5 * (np.log(np.maximum(factors, factors[min(1, len(factors) - 1)] / 2)) / SPREAD) ** 2, -0.5 * (np.log(0.175) / SPREAD) ** 2
        )
        if len(factors) > 1
        else np.zeros(1)
    )  # fmt: skip
    log += believed[:, None, None] + prior[None, :, None] + prior[None, None, :]
    weights = np.exp(log - log.max())
    return np.asarray(weights / weights.sum())


def _log_likelihood(y: Array, cov: Array) -> float:
    try:
        factor = cho_factor(cov, lower=True, check_finite=False)
    except LinAlgError:
        return -np.inf
    return float(-np.log(np.diag(factor[0])).sum() - 0.5 * y @ cho_solve(factor, y, check_finite=False))


def _median(weight: Array, grid: Array) -> float:
    """Median of a probability on a grid, by its cumulated sum between the places."""
    if len(grid) == 1:
        return float(grid[0])
    edges = np.concatenate([[grid[0]], (grid[1:] + grid[:-1]) / 2, [grid[-1]]])
    return float(np.interp(0.5, np.concatenate([[0.0], np.cumsum(weight)]), edges))


def _is_larger(weights: Array, factors: Array, unit: float, u: float) -> bool:
    if weights.size == 1 or not u:
        return False
    total = (
        (factors * u)[:, None, None] ** 2
        + (SIZES * unit)[None, :, None] ** 2
        + (SIZES * unit)[None, None, :] ** 2
    )
    return bool(weights[total > 2.0 * u**2].sum() >= MORE)
