"""Choice of touches among candidates: u^2 of every output in closed form, and how one touch more or less changes it.

A choice gives every candidate a count w_i. With J the rows of the motions (motions.py), per feature M = sum w J J^T, the
output b reads s_i = b^T M^-1 J_i of each touch, and

    u^2 = | sum w_i s_i A_i |^2  +  sum (w_i t_i^2 + w_i^2 c_i^2) s_i^2

with A (N, K) the factor of everything that touches share (machine field, temperatures, form), t_i the scatter of a touch and c_i
the short part of the form, which repeats do not average. One touch more changes M by J J^T; with v = M^-1 J, h = J.v
and beta = b.v / (1 + h) the gain g = sum w s A becomes g + beta (A_j - v^T H), H = sum w J A^T: Sherman & Morrison, Ann.
Math. Stat. 21 (1950) 124. So all candidates are judged at once; Fedorov, Theory of Optimal Experiments (1972), ch. 3.
"""

from __future__ import annotations

from copy import copy
from dataclasses import dataclass
from itertools import pairwise

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import ModelLimit
from vcmm.core.pose import Array
from vcmm.task.measuring.plan import Ints

LEAST_GAIN = 1e-9  # an exchange that lowers the objective by a smaller share is the last
RANK = 1e-9  # h nearer to 1 than this: the touch cannot be dropped
CRITERIA = ("U", "A", "D")


@dataclass(frozen=True, eq=False)
class TouchCandidates:
    """N possible touches. feature (N,): number of the feature; rows: its motions per feature, (N_f, p_f).

    common (N, K) mm; touch, short (N,) mm: standard deviations; seconds (F,): duration of a touch on each feature.
    points, normals (N, 3) in the drawing frame.
    """

    names: tuple[str, ...]
    feature: Ints
    points: Array
    normals: Array
    rows: tuple[Array, ...]
    common: Array
    touch: Array
    short: Array
    seconds: Array

    def of(self, f: int) -> Ints:
        return np.flatnonzero(self.feature == f)


@dataclass(frozen=True, eq=False)
class Target:
    """Objective to minimise: sum of weight_r u_r^2 over output rows (R, P), P the motions of all features in order.

    D: the logarithm of the determinant of the information instead, and rows do not matter.
    """

    rows: Array
    weight: Array
    criterion: str = "U"


class Design:
    """Counts of the candidates and what follows from them; changed by `add` and `drop`."""

    def __init__(self, candidates: TouchCandidates, target: Target, counts: npt.ArrayLike) -> None:
        self.c, self.target = candidates, target
        self.counts = np.array(counts, dtype=np.intp)
        ends = np.cumsum([0, *(r.shape[1] for r in candidates.rows)])
        self.columns = [slice(a, b) for a, b in pairwise(ends)]
        self.rows_of = [candidates.of(f) for f in range(len(candidates.names))]
        self.refresh()

    def copy(self) -> Design:
        other = copy(self)
        other.counts = self.counts.copy()
        other.inverse, other.h, other.noise = list(self.inverse), list(self.h), list(self.noise)
        other.log_dets, other.read = list(self.log_dets), list(self.read)
        return other

    @property
    def n(self) -> int:
        return int(self.counts.sum())

    def per_feature(self) -> dict[str, int]:
        return {name: int(self.counts[r].sum()) for name, r in zip(self.c.names, self.rows_of)}

    def refresh(self) -> None:
        """Compute everything anew from the counts. ModelLimit where a feature is not determined."""
        count = len(self.rows_of)
        self.inverse, self.h, self.noise, self.read = ([np.zeros((0, 0))] * count for _ in range(4))
        self.log_dets = [0.0] * count
        for f in range(count):
            self._refresh(f)
        self._add_up()

    def _refresh(self, f: int) -> None:
        """Compute the contribution of the touches of one feature."""
        rows, jac, s = self.rows_of[f], self.c.rows[f], self.columns[f]
        w = self.counts[rows].astype(float)
        matrix = (jac.T * w) @ jac
        if jac.shape[1]:
            size = np.sqrt(np.maximum(np.diag(matrix), 1e-300))
            if np.linalg.eigvalsh(matrix / np.outer(size, size))[0] < RANK:
                raise ModelLimit(
                    f'the chosen points do not determine the feature "{self.c.names[f]}"; add points'
                )
            self.log_dets[f] = float(np.linalg.slogdet(matrix)[1])
        self.inverse[f] = np.linalg.inv(matrix)
        self.h[f] = (jac.T * w) @ self.c.common[rows]
        self.noise[f] = (jac.T * (w * self.c.touch[rows] ** 2 + w**2 * self.c.short[rows] ** 2)) @ jac
        self.read[f] = self.target.rows[:, s] @ self.inverse[f] @ self.h[f]

    def _add_up(self) -> None:
        self.log_det = sum(self.log_dets)
        self.gain = sum(self.read, np.zeros((len(self.target.rows), self.c.common.shape[1])))

    def variances(self, rows: Array | None = None) -> Array:
        """Return u^2 (R,) of output rows (by default those of the target)."""
        b = self.target.rows if rows is None else rows
        gain, scatter = np.zeros((len(b), self.c.common.shape[1])), np.zeros(len(b))
        for f, s in enumerate(self.columns):
            q = b[:, s] @ self.inverse[f]
            gain += q @ self.h[f]
            scatter += np.einsum("rp,pq,rq->r", q, self.noise[f], q)
        return np.asarray(np.sum(gain**2, axis=1) + scatter)

    def value(self) -> float:
        """Return the objective; smaller is better."""
        if self.target.criterion == "D":
            return -self.log_det
        return float(self.target.weight @ self.variances())

    def sensitivities(self, rows: Array) -> Array:
        """Return s (R, N): the response of each output to one touch of each candidate."""
        out = np.zeros((len(rows), len(self.counts)))
        for f, s in enumerate(self.columns):
            out[:, self.rows_of[f]] = rows[:, s] @ self.inverse[f] @ self.c.rows[f].T
        return out

    def changes(self, f: int, sign: int) -> Array:
        """Return the change of the objective by one touch more (sign 1) or less (-1) at each candidate of a feature, (N_f,).

        inf where a touch cannot be dropped.
        """
        rows, jac = self.rows_of[f], self.c.rows[f]
        v = jac @ self.inverse[f]
        h = np.einsum("np,np->n", v, jac)
        left = 1.0 + sign * h
        possible = np.ones(len(rows), dtype=bool)
        if sign < 0:
            possible = (self.counts[rows] > 0) & (left > RANK)
        safe = np.where(possible, left, 1.0)
        if self.target.criterion == "D":
            return np.where(possible, -np.log(safe), np.inf)
        b = self.target.rows[:, self.columns[f]]
        beta = sign * (v @ b.T) / safe[:, None]  # (N_f, R)
        surprise = self.c.common[rows] - v @ self.h[f]
        shared = 2.0 * beta * (surprise @ self.gain.T) + beta**2 * np.sum(surprise**2, axis=1)[:, None]
        wq = self.noise[f] @ self.inverse[f] @ b.T
        w = self.counts[rows].astype(float)
        more = sign * self.c.touch[rows] ** 2 + ((w + sign) ** 2 - w**2) * self.c.short[rows] ** 2
        variance = np.einsum("np,pq,nq->n", v, self.noise[f], v) + more
        scatter = -2.0 * beta * (v @ wq) + beta**2 * variance[:, None]
        return np.where(possible, (shared + scatter) @ self.target.weight, np.inf)

    def add(self, i: int, count: int = 1) -> None:
        """Add one touch at a candidate; the other features stay as they are."""
        self.counts[i] += count
        self._refresh(int(self.c.feature[i]))
        self._add_up()

    def drop(self, i: int) -> None:
        self.add(i, -1)


def fewest_touches(c: TouchCandidates, spare: int = 1) -> Ints:
    """Return counts (N,) of a small choice: D-optimal greedy, `spare` touches more than each fit needs (at least one)."""
    counts = np.zeros(len(c.feature), dtype=np.intp)
    for f in range(len(c.names)):
        rows, jac = c.of(f), c.rows[f]
        p = jac.shape[1]
        size = np.sqrt(np.mean(jac**2, axis=0)) if len(rows) else np.ones(p)
        scaled = jac / np.where(size > 0, size, 1.0)
        inverse = np.eye(p) * 1e6
        for _ in range(min(max(p + (spare if p > 1 else 0), 1), len(rows))):
            v = scaled @ inverse
            gain = np.einsum("np,np->n", v, scaled) - 1e12 * counts[rows]
            best = int(np.argmax(gain))
            counts[rows[best]] += 1
            inverse -= np.outer(v[best], v[best]) / (1.0 + v[best] @ scaled[best])
    return counts


def exchange_touches(design: Design, passes: int = 4) -> Design:
    """Run the Fedorov exchange within each feature: drop a touch, add the best; repeated while the objective falls."""
    for _ in range(passes):
        before = design.value()
        for i in np.flatnonzero(design.counts):
            if design.counts[i] == 0:
                continue
            _swap(design, int(i))
        if design.value() > before - LEAST_GAIN * abs(before):
            break
    return design


def _swap(design: Design, i: int) -> None:
    """Replace touch i by the best candidate of its feature, if that is better."""
    f = int(design.c.feature[i])
    rows = design.rows_of[f]
    at = int(np.flatnonzero(rows == i)[0])
    if not np.isfinite(design.changes(f, -1)[at]):
        return
    before = design.value()
    design.drop(i)
    best = best_candidate(design, f)
    design.add(best if best >= 0 else i)
    if best >= 0 and design.value() > before:
        design.counts[best] -= 1
        design.add(i)


def best_candidate(design: Design, f: int) -> int:
    """Number of the candidate of a feature whose touch lowers the objective most; -1 where there is none."""
    change = design.changes(f, 1)
    rows = design.rows_of[f]
    best = int(np.argmin(change)) if len(change) else -1
    return int(rows[best]) if best >= 0 and np.isfinite(change[best]) else -1
