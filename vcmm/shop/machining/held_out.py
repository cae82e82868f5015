"""Test whether the shape found in a measured part exceeds scatter, predicts passes that it was not fitted to, and how much of it
the part cannot show.

    evidence = ln p(all points | with the shape) - ln p(all points | without)
    held out = sum over passes of ln p(points of the pass | all other points, with the shape) - ln p(... | without)

The shape is the effect of the identified causes at the measured points, with its size free: a normal prior of `SIZE` standard deviations. The
joint normal law of everything that is known to be uncertain, scatter of moves and passes included, gives the prediction of points from one
another (leave-group-out by blocks of the precision: Rasmussen, Williams, Gaussian Processes (2006), 5.4.2). The evidence by chance is
simulated: parts with the known uncertainty only, in each of which the best of all covariates and of sines over each axis is chosen,
as a search would; `FALSE_ALARM` of the simulated parts have more evidence than the threshold. Passes held out must not speak against the shape:
a radius beyond its stated uncertainty gains nothing there, since the other passes show it in both cases.

A shift or turn of the whole part does not show in the drawing frame. That part of the shape (`unseen`) rests on the identified cause alone.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.run import Array
from vcmm.shop.machining.mismatch import AXES, Ints, ObservedPoints, covariates, rigid_columns
from vcmm.shop.machining.passes import PASS

SIZE = 7.0  # prior standard deviations of a shape: the size from which the right name ranks first in 95 % (docs/exam.md)
FALSE_ALARM = 0.01  # of parts with nothing concealed that reach the threshold
FORGIVEN = 1.0  # nats: the gain in passes held out is not believed to be better known
DRAWS = 400
FREE = 1.0  # mm: of the place of the part in the drawing frame
PERIODS = (
    0.02,
    0.03,
    0.05,
    0.08,
    0.12,
    0.2,
    0.35,
    0.6,
    1.0,
)  # of the range of an axis, of sines that a search may choose
LEAST_COLUMN_SCALE = 1e-12


@dataclass(frozen=True)
class HeldOutProof:
    """evidence, threshold: nats, the second by chance; gain: nats in passes held out; visible_square, rigid_square: mm^2, squared size of the shape where the
    part shows it, and of its share that is a shift or turn of the part; largest: mm, of that; shift: x, y, z of it in the middle of the
    points, mm."""

    evidence: float
    threshold: float
    gain: float
    visible_square: float
    rigid_square: float
    largest: float
    shift: tuple[float, float, float]

    @property
    def holds(self) -> bool:
        return self.evidence > self.threshold and self.gain > -FORGIVEN


def held_out_proof(
    points: ObservedPoints, shape: Array, scatter: float, rigid: bool, seed: int
) -> HeldOutProof:
    """Test a shape (n,) mm along the normals, plus as the rest; scatter: of one point, mm; rigid: the part may lie anywhere."""
    base = rigid_columns(points) if rigid else np.zeros((len(shape), 0))
    cov = points.covariance + scatter**2 * np.eye(len(shape)) + FREE**2 * base @ base.T
    precision: Array = np.asarray(np.linalg.inv(cov), dtype=np.float64)
    number = points.run.columns[PASS]
    groups: list[Ints] = [np.flatnonzero(number == g).astype(np.intp) for g in np.unique(number)]
    q, y = _in_precision(precision, shape[:, None]), points.rest[:, None]
    gain = _held_out(precision, q, y, groups)[0]
    rng = np.random.default_rng(seed)
    draws = np.linalg.cholesky(cov) @ rng.standard_normal((len(shape), DRAWS))
    chance = _best_by_chance(precision, _columns_to_search(points), draws)
    part = np.linalg.lstsq(base, shape, rcond=None)[0] if rigid else np.zeros(0)
    unseen = base @ part if rigid else np.zeros(len(shape))
    moved = part[:3] if rigid else np.zeros(3)
    return HeldOutProof(
        evidence=float(_evidence(precision, q, y)[0]),
        threshold=max(float(np.quantile(chance, 1.0 - FALSE_ALARM)), 0.0),
        gain=float(gain),
        visible_square=float(np.sum((shape - unseen) ** 2)),
        rigid_square=float(unseen @ unseen),
        largest=float(np.abs(unseen).max(initial=0.0)),
        shift=(float(moved[0]), float(moved[1]), float(moved[2])),
    )


def _columns_to_search(points: ObservedPoints) -> list[Array]:
    """Return columns (n, k) of each candidate that a search may choose."""
    out = [c.columns for c in covariates(points)]
    for i, letter in enumerate(AXES):
        place = points.run.position.get(letter)
        if place is None or not np.ptp(place) > 0:
            continue
        for period in PERIODS:
            angle = 2.0 * np.pi * place / (period * np.ptp(place))
            out.append(points.normals[:, [i]] * np.column_stack([np.sin(angle), np.cos(angle)]))
    return out


def _best_by_chance(precision: Array, searched: list[Array], draws: Array) -> Array:
    """Return the evidence (M,) of the shape that a search chooses in each draw (n, M)."""
    evidence = [_evidence(precision, _in_precision(precision, columns), draws) for columns in searched]
    return np.asarray(np.max(evidence, axis=0))


def _evidence(precision: Array, q: Array, y: Array) -> Array:
    """Return the evidence (M,) of directions q (n, k) with q^T P q = 1, sizes N(0, SIZE^2), in observations (n, M)."""
    square = ((q.T @ precision @ y) ** 2).sum(axis=0)
    wide = 1.0 + SIZE**2
    return np.asarray(0.5 * (SIZE**2 / wide * square - q.shape[1] * np.log(wide)))


def _in_precision(precision: Array, columns: Array) -> Array:
    """Return the directions (n, k) of the columns with q^T P q = 1: a unit is a standard deviation of its size."""
    scale = np.sqrt((columns**2).sum(axis=0))
    kept = columns[:, scale > LEAST_COLUMN_SCALE] / scale[scale > LEAST_COLUMN_SCALE]
    value, vector = np.linalg.eigh(kept.T @ precision @ kept)
    good = value > 1e-6 * max(float(value.max(initial=0.0)), LEAST_COLUMN_SCALE)
    return np.asarray(kept @ vector[:, good] / np.sqrt(value[good]))


def _held_out(precision: Array, q: Array, y: Array, groups: list[Ints]) -> Array:
    """Sum over groups (M,) of the gain in the log probability of their points, given all others."""
    pq = precision @ q
    # (P^-1 + SIZE^2 q q^T)^-1 by Woodbury; q^T P q = 1
    after = precision - SIZE**2 / (1.0 + SIZE**2) * pq @ pq.T
    out = np.zeros(y.shape[1])
    for p, sign in ((precision, 1.0), (after, -1.0)):
        py = p @ y
        for g in groups:
            block = p[np.ix_(g, g)]
            quadratic = (py[g] * np.linalg.solve(block, py[g])).sum(axis=0)
            out += sign * 0.5 * (quadratic - np.linalg.slogdet(block)[1])
    return out
