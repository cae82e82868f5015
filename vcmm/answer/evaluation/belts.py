"""Infer the true value from the indicated one, by a confidence belt of sampled and measured parts.

For every true value t the sampled parts show the scatter of the indicated value y, bias and lost or added form included. The
interval of t for an observed y holds all t under which y is no surprise (Neyman's construction): it attains its probability at
every size of the form, not only on average. Lower end 0 where a perfect part would do; an indicated value below that of most
perfect parts is read as that of the middle one (limits constrained by power), so that the interval never shrinks to 0.

Quantiles of y - t are taken among neighbours in t; where the residuals show the roughness of the surface (orientation, location,
extreme sizes), among parts whose residuals are as large, all lengths counted in units of the residuals. J. Neyman, Phil. Trans. A 236 (1937) 333; the one-sided end:
G. Cowan et al., Power-constrained limits, arXiv:1105.3166.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, field
from typing import Literal

import numpy as np
from numpy.lib.stride_tricks import sliding_window_view

from vcmm.answer.evaluation.bound_shares import doubtful
from vcmm.answer.evaluation.pairs import Pairs
from vcmm.core.run import Array
from vcmm.part.gps import characteristics as gps
from vcmm.part.part import Characteristic

CLASSES = 8  # of roughness, each with as many of the drawn parts
SMOOTHEST = 0.01  # share of the drawn parts with smaller residuals
# parts in a window at most: the 2.5 % quantile of their departures errs by 0.9 % in probability
NEIGHBOURS = 300
WINDOW = (
    1 / 40
)  # of all parts: 300 of 12 000; a window of a fixed share blurs as much however many parts are drawn
ORDER: Literal["weibull"] = (
    "weibull"  # place p (n + 1): below it lies the share p on average, however few the parts (Hyndman and Fan 1996, type 6)
)
FEWEST = 60  # parts in a window: with fewer than 39 the 2.5 % quantile lies below the least of them
SMOOTH = 10  # windows on either side over which quantiles are averaged, four to a width
MOST_ONE_SIDED = 0.7  # of all misses at the upper end alone; 1 would fail more often than 1 - p where the lower end leaves 0
LEVELS = np.concatenate([[0.005, 0.01, 0.02], np.arange(0.025, 0.98, 0.025), [0.98, 0.99, 0.995]])


@dataclass(frozen=True, eq=False)
class Belt:
    """One class of roughness: true (g,) mm or rad, rising; departure (g, levels): quantiles of indicated - true there."""

    true: Array
    departure: Array
    _curves: dict[float, Array] = field(
        default_factory=dict, repr=False
    )  # many parts ask for the same levels

    def at(self, level: float) -> Array:
        """Return the quantile (g,) of the indicated value for every true value, never falling."""
        if level not in self._curves:
            self._curves[level] = np.maximum.accumulate(self.true + _between_levels(self.departure, level))
        return self._curves[level]


def _between_levels(departure: Array, level: float) -> Array:
    """Interpolate quantiles (g,) at a level from those at LEVELS, linearly, as `np.interp` row by row (to the same digit)."""
    if not LEVELS[0] <= level < LEVELS[-1]:
        return departure[:, 0 if level < LEVELS[0] else -1]
    j = int(np.searchsorted(LEVELS, level, side="right")) - 1
    slope = (departure[:, j + 1] - departure[:, j]) / (LEVELS[j + 1] - LEVELS[j])
    return np.asarray(slope * (level - LEVELS[j]) + departure[:, j])


@dataclass(frozen=True, eq=False)
class FamilyInverse:
    """Belts of a characteristic by roughness, in units of the residuals; whole: of all parts, in mm or rad.

    roughest: upper ends of the classes but the last, mm; smoothest: points with smaller residuals than nearly all sampled parts
    (touched up, or typed in) are read with this value. is_bounded: no true value is below 0.
    """

    belts: tuple[Belt, ...]
    whole: Belt
    roughest: Array
    is_bounded: bool
    smoothest: float = 0.0

    def belt(self, rest: float | None) -> Belt:
        """Return the belt of the roughness class of a root mean square of residuals."""
        return self.whole if rest is None else self.belts[int(np.searchsorted(self.roughest, rest))]

    def quantile(self, level: float, indicated: Array, rest: Array | None, beside: int = 0) -> Array:
        """Return the true values (m,) that are not exceeded with this confidence, given indicated values (m,).

        beside: number of classes by which the part is taken as rougher than its residuals, which vary by chance.
        """
        if rest is None:
            return _crossing(self.whole, 1.0 - level, indicated, self.is_bounded)
        rest = np.maximum(rest, self.smoothest)
        classes = np.clip(np.searchsorted(self.roughest, rest) + beside, 0, len(self.roughest))
        out = np.empty(len(indicated))
        for k in np.unique(classes):
            mine = classes == k
            unit = rest[mine] if len(self.roughest) else np.ones(int(mine.sum()))
            out[mine] = unit * _crossing(
                self.belts[int(k)], 1.0 - level, indicated[mine] / unit, self.is_bounded
            )
        return out

    def interval(self, p: float, indicated: Array, rest: Array | None) -> tuple[Array, Array]:
        """Ends (m,), (m,) of the interval of the true value. Where it begins at 0 only its upper end can miss: it misses more.

        Of sizes, whose errors change their sign with the roughness, it goes half way to those of the classes beside it.
        """
        low, high = (self.quantile(level, indicated, rest) for level in ((1.0 - p) / 2.0, (1.0 + p) / 2.0))
        if not self.is_bounded:
            if rest is None:
                return low, high
            near = [
                [self.quantile(q, indicated, rest, k) for k in (-1, 0, 1)]
                for q in ((1.0 - p) / 2.0, (1.0 + p) / 2.0)
            ]
            return (low + np.min(near[0], axis=0)) / 2.0, (high + np.max(near[1], axis=0)) / 2.0
        return low, np.where(
            low > 0.0, high, self.quantile(1.0 - MOST_ONE_SIDED * (1.0 - p), indicated, rest)
        )

    def confidence(self, limit: float, indicated: float, rest: float | None) -> float:
        """Return the confidence that the true value does not exceed a limit: P(indication > indicated) for a part at the limit."""
        belt = self.belt(rest)
        if rest is not None and len(self.roughest):
            rest = max(rest, self.smoothest)
            limit, indicated = limit / rest, indicated / rest
        if self.is_bounded:
            indicated = max(
                indicated, float(belt.at(0.5)[0])
            )  # less says no more than that, as in `_crossing`
        row = [float(np.interp(limit, belt.true, column)) for column in belt.departure.T]
        return 1.0 - float(
            np.interp(indicated - limit, np.maximum.accumulate(row), LEVELS, left=0.0, right=1.0)
        )


def _crossing(belt: Belt, level: float, indicated: Array, bounded: bool) -> Array:
    """Return the true value at which a quantile of the indicated one passes the value that was found; extrapolated linearly beyond the last."""
    curve = belt.at(level)
    if not bounded:  # one row: a departure that does not depend on the size
        return np.asarray(indicated - (curve[0] - belt.true[0]))
    indicated = np.maximum(indicated, belt.at(0.5)[0])
    inside = np.interp(indicated, curve, belt.true, left=0.0)
    return np.maximum(np.where(indicated > curve[-1], belt.true[-1] + indicated - curve[-1], inside), 0.0)


@dataclass(frozen=True, eq=False)
class Inverse:
    """The inverses of several families of parts: the interval holds those of all of them, the estimate is their mean."""

    families: tuple[FamilyInverse, ...]

    def estimate(self, indicated: Array, rest: Array | None) -> Array:
        """Return the estimates (m,): the middle of the confidence."""
        return np.mean([f.quantile(0.5, indicated, rest) for f in self.families], axis=0)

    def interval(self, p: float, indicated: Array, rest: Array | None) -> tuple[Array, Array]:
        """Ends (m,), (m,) of the interval of the true value."""
        ends = [f.interval(p, indicated, rest) for f in self.families]
        return np.min([low for low, _ in ends], axis=0), np.max([high for _, high in ends], axis=0)

    def sight(self, p: float) -> float:
        """Return the least indication of a part that is far off, as a share of its true value; 1 where it is unbounded."""
        ends = [(f.whole.at((1.0 - p) / 2.0)[-1], f.whole.true[-1]) for f in self.families if f.is_bounded]
        return min((float(y / max(t, 1e-15)) for y, t in ends), default=1.0)

    def within(self, low: float, high: float, indicated: float, rest: float | None) -> float:
        """Return the confidence that the true value lies between two limits (low -inf: none), by the family in which it is nearest to doubt."""
        below = [0.0 if low == -np.inf else f.confidence(low, indicated, rest) for f in self.families]
        return min(f.confidence(high, indicated, rest) - b for f, b in zip(self.families, below))


@dataclass(frozen=True, eq=False)
class UnitedInverse:
    """Inverses for all machines that the bounds allow, from the least to the limit (`vcmm.answer.evaluation.bound_shares`).

    The interval holds those of all of them. The estimate is that of the least: no correction is applied for errors that were not shown to exist.
    """

    of_share: tuple[Inverse, ...]

    @property
    def families(self) -> tuple[FamilyInverse, ...]:
        """Inverses of the families for machines at the limit."""
        return self.of_share[-1].families

    def estimate(self, indicated: Array, rest: Array | None) -> Array:
        return self.of_share[0].estimate(indicated, rest)

    def interval(self, p: float, indicated: Array, rest: Array | None) -> tuple[Array, Array]:
        ends = [inverse.interval(p, indicated, rest) for inverse in self.of_share]
        return np.min([low for low, _ in ends], axis=0), np.max([high for _, high in ends], axis=0)

    def sight(self, p: float) -> float:
        return min(inverse.sight(p) for inverse in self.of_share)

    def within(self, low: float, high: float, indicated: float, rest: float | None) -> float:
        return doubtful([inverse.within(low, high, indicated, rest) for inverse in self.of_share])


Reading = Inverse | UnitedInverse


def inverse_of(c: Characteristic, index: int, drawn: Sequence[Pairs]) -> Inverse:
    """Return the inverse of characteristic number `index` from sampled parts, one family after another."""
    return Inverse(tuple(family_inverse(c, index, pairs) for pairs in drawn))


def family_inverse(c: Characteristic, index: int, drawn: Pairs) -> FamilyInverse:
    """Return the belts of characteristic number `index` from sampled parts of one family."""
    true, indicated, rest = parts_with_element(index, drawn)
    bounded = gps.is_one_sided(c)
    whole = _belt(true, indicated, bounded)
    rest = np.maximum(rest, 1e-12)
    if (
        not sorted_by_roughness(c) or rest.max() <= 1e-9
    ):  # as many points as the fits have freedoms: no residuals
        return FamilyInverse((whole,), whole, np.zeros(0), bounded)
    rough = rest > 1e-9  # parts without form on a machine without errors leave nothing to divide by
    true, indicated, rest = true[rough], indicated[rough], rest[rough]
    edges = np.quantile(rest, np.arange(1, CLASSES) / CLASSES)
    classes, t, y = np.searchsorted(edges, rest), true / rest, indicated / rest
    belts = [_belt(t[classes == k], y[classes == k], bounded) for k in range(len(edges) + 1)]
    return FamilyInverse(tuple(belts), whole, edges, bounded, float(np.quantile(rest, SMOOTHEST)))


def parts_with_element(index: int, drawn: Pairs) -> tuple[Array, Array, Array]:
    """Return true, indicated, rest (m,) of the parts that have such an element."""
    true, indicated, rest = (a[:, index] for a in (drawn.true, drawn.indicated, drawn.rest))
    has = np.isfinite(true) & np.isfinite(indicated)
    return true[has], indicated[has], rest[has]


def lost_share(index: int, drawn: Pairs) -> float:
    """Return the share of the parts that have no such element."""
    return 1.0 - len(parts_with_element(index, drawn)[0]) / len(drawn.true)


def sorted_by_roughness(c: Characteristic) -> bool:
    """Return whether the residuals carry information that the value itself does not: not for forms, profiles and run-out."""
    return c.type in ("size", "distance", "angle", *gps.LOCATED_TYPES)


def _belt(true: Array, indicated: Array, bounded: bool) -> Belt:
    departure = indicated - true
    if not bounded:
        return Belt(np.zeros(1), np.quantile(departure, LEVELS)[None])
    order = np.argsort(true, kind="stable")
    true, departure = true[order], departure[order]
    width = _width(len(true))
    step = max(width // 4, 1)
    middle = np.median(sliding_window_view(true, width)[::step], axis=1)
    rows = _smooth(np.quantile(sliding_window_view(departure, width)[::step], LEVELS, axis=1, method=ORDER).T)
    keep = np.concatenate([[True], np.diff(middle) > 0])
    return Belt(middle[keep], rows[keep])


def _width(count: int) -> int:
    """Return the number of parts in a window. A tenth of few parts spans half a decade of true values, and doubled the upper end of a flatness."""
    return min(NEIGHBOURS, max(int(WINDOW * count), min(count // 10, FEWEST), 1))


def _smooth(rows: Array) -> Array:
    """Return the quantiles (g, levels) averaged over their neighbours with weights that fall to both sides, shorter at the ends."""
    out = np.empty_like(rows)
    for i in range(len(rows)):
        reach = min(i, len(rows) - 1 - i, SMOOTH)
        weight = 1.0 + reach - np.abs(np.arange(-reach, reach + 1))
        out[i] = weight @ rows[i - reach : i + reach + 1] / weight.sum()
    return out


def coverage(inverse: Reading, index: int, drawn: Pairs, p: float, by_roughness: bool = True) -> float:
    """Return the share of sampled parts whose true value lies in the interval for p. by_roughness: read with their roughness."""
    true, indicated, rest = parts_with_element(index, drawn)
    low, high = inverse.interval(p, indicated, rest if by_roughness else None)
    return float(((low <= true + 1e-12) & (true <= high + 1e-12)).mean())
