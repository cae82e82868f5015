"""Bends of lines and planes, extrapolated beyond the outermost points to the ends of the feature.

    d = c0 + c1 u + c2 u^2 + c3 u^3 + e      departures at the points, u from -1 to 1 over a line (of planes all products up to the third degree)

A part that is bent as u^3 and touched on nine tenths of its length shows 0.9^3 = 0.73 of its straightness: the belts, whose forms are
waves, do not reach that far. So the polynomial that least squares put through the points is evaluated all over the feature, its
amounts sampled with their covariance (t-law of the degrees of freedom that the fit leaves), and the upper end of the interval is no
lower than that of these draws. A polynomial that the residuals do not show (F-test, N. R. Draper, H. Smith, Applied Regression
Analysis, 1998, 1.3) is not extrapolated, and no interval ever becomes shorter.
"""

from __future__ import annotations

from dataclasses import dataclass, replace
from zlib import crc32

import numpy as np

from vcmm.answer.evaluation.ends import GROUPS, jackknife_u
from vcmm.answer.evaluation.form_family import coordinates
from vcmm.answer.evaluation.not_covered import BEYOND_SAID, UNSEEN, beyond_touches
from vcmm.answer.evaluation.result import CharacteristicResult
from vcmm.answer.evaluation.true_values import all_over
from vcmm.answer.evaluation.truth import Limits, Statement, Truth
from vcmm.core.run import Array
from vcmm.part.part import Characteristic, Feature

TYPES = ("straightness", "flatness")
DEGREE = 3  # of the bends; as of the forms between the points of sizes
DRAWS = 2000
SHOWN = 0.05  # level of the F-test
NEW = 0.1  # of a column lies outside of those before it: less, and the points do not tell it
LEFT = 3  # degrees of freedom that the fit leaves at least
ALONG = 41  # places along a line
CARRIED_ON = ", but for bends up to the third degree, which are carried on to the ends"


@dataclass(frozen=True, eq=False)
class WithBends:
    """The result of a belt, with the bend that the points show extrapolated. forms (m,): sampled ranges of the whole feature, mm."""

    truth: Truth
    forms: Array

    def state(self, y: float, p: float, kind: str, limits: Limits | None = None) -> Statement:
        statement = self.truth.state(y, p, kind, limits)
        high = upper_end(self.forms, p)
        if high <= statement.interval[1]:
            return statement
        within = statement.p_conform
        if limits is not None and within is not None:
            of_forms = float(((self.forms >= limits[0]) & (self.forms <= limits[1])).mean())
            within = min(
                (within, of_forms), key=lambda chance: abs(chance - 0.5)
            )  # accepted where both say so
        u = None if statement.interval_u is None else (statement.interval_u[0], _end_u(self.forms, p))
        return replace(statement, interval=(statement.interval[0], high), p_conform=within, interval_u=u)


def upper_end(forms: Array, p: float) -> float:
    """Return the upper end above which lies as much probability as above a symmetric interval for p."""
    return float(np.quantile(forms, (1.0 + p) / 2.0))


def _end_u(forms: Array, p: float) -> float:
    kept = [np.delete(forms, np.s_[g::GROUPS]) for g in range(GROUPS)]
    return float(jackknife_u(np.array([[upper_end(ranges, p)] for ranges in kept]))[0])


def bend_ranges(
    c: Characteristic, feature: Feature, points: Array, departures: Array, seed: int
) -> Array | None:
    """Return ranges (m,) mm of the bends that the points (n, 3) of a line or plane with these departures (n,) leave possible all over it; None where
    the points reach its ends, show no bend, or are too few to determine one.
    """
    if c.type not in TYPES or c.filter is not None or 1.0 - beyond_touches(feature, points)[1] <= UNSEEN:
        return None
    everywhere, middles = (all_over(feature, points, ALONG, middles=m) for m in (False, True))
    here, there, mean = (_products(*coordinates(feature, p)) for p in (points, everywhere, middles))
    kept = _independent_columns(here)
    motions = 2 if feature.kind == "line" else 3
    if len(kept) <= motions or len(points) - len(kept) < LEFT or kept[:motions] != list(range(motions)):
        return None
    here, there, mean = here[:, kept], there[:, kept], mean[:, kept]
    amounts, free = np.linalg.lstsq(here, departures, rcond=None)[0], len(points) - len(kept)
    rest = float(((departures - here @ amounts) ** 2).sum())
    if not _is_shown(here[:, :motions], departures, rest, len(kept) - motions, free):
        return None
    root = np.linalg.cholesky(np.linalg.inv(here.T @ here))
    rng = np.random.default_rng([seed, 31, crc32(c.name.encode())])
    scale = np.sqrt(rest / rng.chisquare(free, DRAWS))
    drawn = amounts + scale[:, None] * (rng.standard_normal((DRAWS, len(kept))) @ root.T)
    flat = (
        np.linalg.pinv(mean[:, :motions]) @ mean
    )  # what the element takes of every product, by the whole surface
    return np.asarray(np.ptp(drawn @ (there - there[:, :motions] @ flat).T, axis=1))


def _products(u: Array, v: Array) -> Array:
    """Return 1, then the products of u and v of one degree after another (n, k); u is 0 all over a line, whose place is v."""
    pairs = [(i, d - i) for d in range(DEGREE + 1) for i in range(d, -1, -1)]
    return np.stack([u**i * v**j for i, j in pairs if i == 0 or np.any(u)], axis=1)


def _independent_columns(columns: Array) -> list[int]:
    """Return the numbers of the columns that the points distinguish from those before them."""
    kept: list[int] = []
    base = np.zeros((len(columns), 0))
    for k, column in enumerate(columns.T):
        left = column - base @ (base.T @ column)
        left -= base @ (base.T @ left)
        if np.linalg.norm(left) > NEW * np.linalg.norm(column) > 0.0:
            kept.append(k)
            base = np.column_stack([base, left / np.linalg.norm(left)])
    return kept


def _is_shown(motions: Array, departures: Array, rest: float, bends: int, free: int) -> bool:
    """Return whether the bends explain more of the departures than noise does, at the level SHOWN."""
    from scipy.stats import f

    flat = departures - motions @ np.linalg.lstsq(motions, departures, rcond=None)[0]
    explained = max(float((flat**2).sum()) - rest, 0.0) / bends
    return bool(explained > f.ppf(1.0 - SHOWN, bends, free) * max(rest, 1e-24) / free)


def with_bends(r: CharacteristicResult, forms: Array) -> CharacteristicResult:
    """Return the result with an upper end no lower than that of the extrapolated bend."""
    assert r.truth is not None
    remarks = tuple(
        f"{remark}{CARRIED_ON}" if remark.startswith(BEYOND_SAID) else remark for remark in r.not_covered
    )
    return replace(r, truth=WithBends(r.truth, forms), not_covered=remarks)
