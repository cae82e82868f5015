"""Summary of Monte Carlo trials of one quantity: estimate, standard uncertainty, coverage intervals, digits.

Two ways to the same `Summary`: `summarise` from a sample in memory (JCGM 101:2008, 7.5 to 7.7), `Accumulator` from
blocks in constant memory. The accumulator counts and sums integers only, so its result is the same, to the last
bit, for any block size, any order of blocks and any number of workers (`merge`).
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np
from numpy.typing import ArrayLike

from vcmm.answer.evaluation import streams
from vcmm.answer.evaluation.interval import check_interval
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.laws import Array

STATEMENT_KINDS = ("symmetric", "shortest", "upper")
_REACH = 12  # scales on each side of the histogram
_BINS = 1024  # per scale
_UNIT = 2.0**20  # fixed-point steps per scale
_WIDE = 2.0**31  # steps from the centre (2048 scales) up to which squares fit 64 bits


@dataclass(frozen=True, eq=False)
class Summary:
    """Distribution of one output quantity from `trials` Monte Carlo trials.

    `below` (n,) is P(Y <= grid) on the rising `grid` (n,), linear between: sorted trials with (r - 1/2) / M
    (JCGM 101, 7.5.1), or the edges of a histogram. `histogram` is (edges (b + 1,), counts (b,)). `exact_u` tells
    that u is a closed form given by the caller. `warnings` are sentences for the report.
    """

    trials: int
    mean: float
    u: float
    minimum: float
    maximum: float
    grid: Array
    below: Array
    histogram: tuple[Array, Array]
    exact_u: bool = False
    warnings: tuple[str, ...] = ()

    def reflect(self, about: float) -> Summary:
        """Return the distribution of about - y, mirrored."""
        edges, counts = self.histogram
        return replace(
            self, mean=about - self.mean, minimum=about - self.maximum, maximum=about - self.minimum,
            grid=about - self.grid[::-1], below=1 - self.below[::-1], histogram=(about - edges[::-1], counts[::-1]),
        )  # fmt: skip

    def quantile(self, p: float) -> float:
        """Return the value not exceeded with probability p. ModelLimit where the trials are too few to determine it."""
        check_interval(p, "symmetric")
        if min(p, 1 - p) * self.trials < 0.5:
            need = math.ceil(0.5 / min(p, 1 - p))
            raise ModelLimit(f"{self.trials} trials cannot give the {p:g} quantile: run at least {need}.")
        return float(np.interp(p, self.below, self.grid))

    def interval(self, p: float = 0.95, kind: str = "symmetric") -> tuple[float, float]:
        """Return the coverage interval for probability p (JCGM 101, 7.7): symmetric, shortest, or upper = (-inf, y_p)."""
        check_interval(p, kind, STATEMENT_KINDS)
        if kind == "upper":
            return -math.inf, self.quantile(p)
        if kind == "symmetric":
            return self.quantile((1 - p) / 2), self.quantile((1 + p) / 2)
        self.quantile((1 + p) / 2)  # refuses too few trials
        start = np.searchsorted(self.below, self.below[-1] - p, side="right")
        low = self.grid[:start]
        width = np.interp(self.below[:start] + p, self.below, self.grid) - low
        k = int(np.argmin(width))
        return float(low[k]), float(low[k] + width[k])

    def probability(self, low: float = -math.inf, high: float = math.inf) -> float:
        """Return P(low <= Y <= high): the share of conforming trials for tolerance limits."""
        ends = np.interp([low, high], self.grid, self.below, left=0.0, right=1.0)
        return float(ends[1] - ends[0])

    def numerical_error(self, p: float = 0.95) -> float:
        """Return the largest standard deviation, over repeated runs, of mean, u and the ends of the symmetric interval for p.

        From the large-sample formulas: u / sqrt(M), u sqrt((kurtosis - 1) / (4 M)), and the binomial law of the
        number of trials below a quantile. Mean and u are left out where they do not exist or u is a closed form.
        """
        weight = np.diff(self.below)
        square = ((self.grid[1:] + self.grid[:-1]) / 2 - self.mean) ** 2
        m2, m4 = float(weight @ square), float(weight @ square**2)
        errors = [self._error((1 - p) / 2), self._error((1 + p) / 2)]
        if math.isfinite(self.u):
            errors.append(self.u / math.sqrt(self.trials))
        if m2 > 0 and not self.exact_u:
            errors.append(math.sqrt(max(m4 / m2 - m2, 0.0) / self.trials) / 2)
        return max(errors)

    def ends_u(self, p: float = 0.95) -> tuple[float, float]:
        """Return the standard deviations, over repeated runs, of the ends of the symmetric interval for p."""
        return self._error((1 - p) / 2), self._error((1 + p) / 2)

    def digits(self, p: float = 0.95) -> int:
        """Return the significant digits of u to which all results are established, 0 to 6 (JCGM 101, 7.9.2).

        Twice `numerical_error` must not exceed the tolerance. An infinite u counts as half the half-width of the
        interval.
        """
        u = self.u
        if not math.isfinite(u):
            low, high = self.interval(p)
            u = (high - low) / 4
        if u == 0:
            return 6
        error = 2 * self.numerical_error(p)
        return next((n for n in range(6, 0, -1) if error <= tolerance(u, n)), 0)

    def _error(self, p: float) -> float:
        """Return the standard deviation of the quantile for p: binomial, through the empirical distribution itself."""
        e = math.sqrt(p * (1 - p) / self.trials)
        high, low = np.interp([p + e, p - e], self.below, self.grid)
        return float(high - low) / 2


def tolerance(u: float, digits: int) -> float:
    """Return the numerical tolerance delta of a standard uncertainty given to so many significant digits (JCGM 101, 7.9.2)."""
    return 0.5 * 10.0 ** (math.floor(math.log10(u)) - digits + 1)


def summarise(samples: ArrayLike, u: float | None = None) -> Summary:
    """Return the summary of a sample (m,) held in memory. `u`: the closed-form standard uncertainty, if it is known.

    Give `u` when t-laws with nu <= 4 take part: a sample's standard deviation has no finite variance then.
    """
    y = np.sort(np.asarray(samples, float).ravel())
    if len(y) < 2 or not np.isfinite(y).all():
        raise ModelLimit(f"A summary needs at least 2 finite values; got {len(y)} with {_bad(y)} not finite.")
    below = (np.arange(len(y)) + 0.5) / len(y)
    bins = int(np.clip(round(len(y) ** 0.5 / 2), 5, 400))
    counts, edges = np.histogram(y, bins)
    return Summary(
        trials=len(y),
        mean=float(y.mean()),
        u=float(y.std(ddof=1)) if u is None else u,
        minimum=float(y[0]),
        maximum=float(y[-1]),
        grid=y,
        below=below,
        histogram=(edges, counts),
        exact_u=u is not None,
    )


def _bad(values: Array) -> int:
    return int((~np.isfinite(values)).sum())


@dataclass(eq=False)
class Accumulator:
    """Streams blocks of trials of one quantity into integers, in constant memory (0.2 MB).

    `centre` and `scale` (> 0) are a value near the mean and the width of the distribution, best the closed form u
    (Linear.scale where u is infinite). Trials are rounded to scale / 2^20 for the sums, and counted in bins of
    scale / 1024 within +-12 scales; those beyond are counted (first and last of `counts`), reported, and enter
    mean and u.
    """

    centre: float
    scale: float
    counts: Array = field(default_factory=lambda: np.zeros(2 * _REACH * _BINS + 2, np.int64))
    trials: int = 0
    minimum: float = math.inf
    maximum: float = -math.inf
    _first: int = 0  # sums of the fixed-point deviations and of their squares: exact
    _second: int = 0

    def __post_init__(self) -> None:
        if not (math.isfinite(self.centre) and math.isfinite(self.scale) and self.scale > 0):
            raise UsageError(
                f"Accumulator: centre {self.centre} and scale {self.scale} > 0 must be finite numbers."
            )

    def add(self, block: Array) -> None:
        """Take in a block of trials (m,)."""
        block = np.ascontiguousarray(block, float)
        if not len(block):
            return
        low, high = float(block.min()), float(block.max())
        factor = _UNIT / self.scale
        if not max(self.centre - low, high - self.centre) * factor < 2.0**62:  # also false for NaN
            raise ModelLimit(
                f"Trials between {low} and {high} do not fit the scale {self.scale} of the summary."
            )
        self.minimum, self.maximum = min(self.minimum, low), max(self.maximum, high)
        self.trials += len(block)
        sums = np.zeros(3, np.int64)
        fast = streams.kernels(len(block))
        (fast.tally if fast else _tally)(block, self.centre, factor, self.counts, sums)
        self._first += int(sums[0])
        self._second += int(sums[1]) + (int(sums[2]) << 32)
        if max(self.centre - low, high - self.centre) * factor >= _WIDE:
            self._add_wide(np.rint((block - self.centre) * factor))

    def _add_wide(self, steps: Array) -> None:
        """Add sums of the few trials beyond 2048 scales, whose squares do not fit 64 bits."""
        for q in map(int, steps[np.abs(steps) >= _WIDE]):
            self._first += q
            self._second += q * q

    @property
    def sums(self) -> tuple[int, int]:
        """Exact sums of the fixed-point deviations and of their squares."""
        return self._first, self._second

    def take(self, first: int, second: int) -> None:
        """Add such sums, as another process has them."""
        self._first += first
        self._second += second

    def merge(self, other: Accumulator) -> None:
        """Take in the trials of another accumulator with the same centre and scale (another worker or shard)."""
        if (self.centre, self.scale) != (other.centre, other.scale):
            raise UsageError(
                "Accumulators with different centre or scale cannot be merged: give all the same."
            )
        self.counts += other.counts
        self.trials += other.trials
        self.minimum, self.maximum = min(self.minimum, other.minimum), max(self.maximum, other.maximum)
        self.take(*other.sums)

    def summary(self, u: float | None = None) -> Summary:
        """Return the summary of all trials so far. `u`: the closed-form standard uncertainty, if known (see `summarise`)."""
        n = self.trials
        if n < 2:
            raise ModelLimit(f"A summary needs at least 2 trials; got {n}.")
        variance = (n * self._second - self._first**2) / (n * (n - 1))  # integers up to the one division
        unit = self.scale / _UNIT
        grid, below = self._distribution()
        outside = int(self.counts[0] + self.counts[-1])
        text = f"{outside} of {n} trials lie beyond {_REACH} scales: the interval is coarse for p near 1."
        return Summary(
            trials=n,
            mean=self.centre + unit * (self._first / n),
            u=unit * math.sqrt(variance) if u is None else u,
            minimum=self.minimum,
            maximum=self.maximum,
            grid=grid,
            below=below,
            histogram=(self._edges(), self.counts[1:-1].copy()),
            exact_u=u is not None,
            warnings=(text,) if outside else (),
        )

    def _edges(self) -> Array:
        return self.centre + self.scale / _BINS * np.arange(-_REACH * _BINS, _REACH * _BINS + 1)

    def _distribution(self) -> tuple[Array, Array]:
        """Return edges and P(Y <= edge); trials beyond the histogram lie evenly between it and the extremes."""
        edges = np.clip(self._edges(), self.minimum, self.maximum)
        below = np.cumsum(self.counts)[:-1] / self.trials
        return np.concatenate([[self.minimum], edges, [self.maximum]]), np.concatenate([[0.0], below, [1.0]])


def _tally(values: Array, centre: float, factor: float, counts: Array, sums: Array) -> None:
    """Count as vcmm.answer.evaluation._stream_kernels.tally does, in numpy: counts, and sums of q, of the low and the high half of q^2."""
    steps = np.rint((values - centre) * factor)
    q = np.clip(steps, -_WIDE, _WIDE).astype(np.int64)
    k = np.clip((q >> 10) + len(counts) // 2, 0, len(counts) - 1)
    counts += np.bincount(k, minlength=len(counts))
    q = q[np.abs(q) < _WIDE]
    square = q * q
    sums += [q.sum(), (square & 0xFFFFFFFF).sum(), (square >> 32).sum()]
