"""Rates of the random change of numbers per group, and the step of the state in time.

    b(t + d) = b(t) + v d / year + N(0, walk^2 d / year)                 random walk with a trend; v ~ N(0, trend^2), constant
    w(t + d) = e^(-d / tau) w(t) + N(0, swing^2 (1 - e^(-2 d / tau)))    Ornstein-Uhlenbeck: mean-reverting, stationary
    s(t + d) = s cos(a) + c sin(a),  c(t + d) = -s sin(a) + c cos(a)     season of one year, a = 2 pi d / year; s, c ~ N(0, season^2)
    p(t + d) = e^(-d / 1 day) p(t)                                       a change that passes; zero but for jumps

in units of the usual size of the parameter (Uhlenbeck & Ornstein, Phys. Rev. 36 (1930) 823, exact step: Gillespie, Phys. Rev. E 54 (1996)
2084; trend and season: A. Harvey, Forecasting, Structural Time Series Models and the Kalman Filter (1989), 2.3). On the first day b = -s: the
machine file is right on its date within its own covariance, in whatever season that was.

Rates stand on grids of powers of two, bounded: a number that changed by more than eight of its usual sizes in a year is no drift.
The prior of each is centred at a quarter of the usual size (in a year; of the season: its amplitude), a factor of four to either side (one
standard deviation); it is an assumption, and `typical` of each effect states the source of the size. Trend, season and swing have half of
their prior at zero. What is used is the root mean square over all levels that are still probable: the Gaussian of the variance of the mixture, so that few recordings
do not make a machine look steadier, or less of a season, than they can tell.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.tracking.kalman import GaussianState, advance
from vcmm.learn.tracking.quantities import TrackedMachine

YEAR = 365.25  # days
WALKS = (0.0, *(2.0**k for k in range(-6, 4)))
TRENDS = (0.0, *(2.0**k for k in range(-4, 3)))
SEASONS = (0.0, *(2.0**k for k in range(-5, 2)))
SWINGS = (0.0, *(2.0**k for k in range(-6, 3)))
TAUS = (1.0, 30.0)  # days: from set-up to set-up, and of weeks
GRIDS = {"walk": WALKS, "trend": TRENDS, "season": SEASONS}
CENTRE, SPREAD = -2.0, 2.0  # of log2 of a rate
BLOCKS = 6  # b, w, s, c, v, p
PASSES = 1.0  # days: time constant of what passes


def log_priors(name: str) -> Array:
    """Of every level of a grid, nats: of a walk ln of exp(-((log2 - CENTRE) / SPREAD)^2 / 2), none as 2^-7; of the others half at zero."""
    grid = np.array(GRIDS[name])
    steps = np.log2(np.where(grid > 0, grid, 2.0**-7))
    logs = -0.5 * ((steps - CENTRE) / SPREAD) ** 2
    if name != "walk":
        logs[1:] -= np.log(np.exp(logs[1:]).sum())
        logs[0] = 0.0
    return np.asarray(logs - np.log(np.exp(logs).sum()))


def root_mean_square(logs: Array, levels: Array) -> float:
    """Return the root mean square over levels with probabilities exp(logs): a Gaussian of the variance of the mixture."""
    weights = np.exp(logs - np.max(logs))
    return float(np.sqrt(weights @ levels**2 / weights.sum()))


def _of_prior(name: str) -> float:
    return root_mean_square(log_priors(name), np.array(GRIDS[name]))


@dataclass(frozen=True)
class GroupRates:
    """Rates of one group: walk and trend in a year, season: root mean squares over their probabilities; swing, tau: numbers on SWINGS and TAUS."""

    walk: float
    trend: float
    season: float
    swing: int = 0
    tau: int = 0

    @property
    def log_prior(self) -> float:
        """Of the swing, nats, but for a constant."""
        if not self.swing:
            return float(np.log(0.5))
        norm = sum(np.exp(-0.5 * ((k - CENTRE) / SPREAD) ** 2) for k in range(-6, 3))
        step = np.log2(SWINGS[self.swing])
        return float(np.log(0.5 / (norm * len(TAUS))) - 0.5 * ((step - CENTRE) / SPREAD) ** 2)

    def neighbours(self) -> list[GroupRates]:
        """One step on the grids of the swing."""
        if not self.swing:
            return [replace(self, swing=SWINGS.index(0.25), tau=t) for t in range(len(TAUS))]
        out = [replace(self, swing=k) for k in (self.swing - 1, self.swing + 1) if k < len(SWINGS)]
        return out + [replace(self, tau=t) for t in range(len(TAUS)) if t != self.tau]

    @property
    def words(self) -> str:
        """Return constant, random walk, trend, season, mean-reverting, with their sizes, in words."""
        parts = [
            f"random walk of {self.walk:.3g} in a year" if self.walk else "",
            f"trend of {self.trend:.3g} in a year" if self.trend else "",
            f"season of {self.season:.3g}" if self.season else "",
            f"mean-reverting by {SWINGS[self.swing]:.3g} over {TAUS[self.tau]:.3g} d" if self.swing else "",
        ]
        return ", ".join(p for p in parts if p) or "constant"


@dataclass(frozen=True, eq=False)
class WanderingMotion:
    """Rates of every shape: walk, trend, season, swing, tau (g,). A state is z (stated,), b, w, s, c, v, p (g,) each."""

    stated: int
    walk: Array
    trend: Array
    season: Array
    swing: Array
    tau: Array

    @property
    def size(self) -> int:
        return self.stated + BLOCKS * len(self.walk)

    def block(self, number: int) -> slice:
        """Return the slice of the state that holds b, w, s, c, v or p (number 0 to 5)."""
        g = len(self.walk)
        return slice(self.stated + number * g, self.stated + (number + 1) * g)

    def carry(self, rows: Array, days: float) -> Array:
        """Return the state (n, ...) after the given days, without its random increment."""
        b, w, s, c, v, p = (self.block(k) for k in range(BLOCKS))
        turn = 2.0 * np.pi * days / YEAR
        out = rows.copy()
        out[b] += rows[v] * (days / YEAR)
        out[w] *= np.reshape(np.exp(-days / self.tau), (-1, *(1,) * (rows.ndim - 1)))
        out[p] *= np.exp(-days / PASSES)
        out[s] = rows[s] * np.cos(turn) + rows[c] * np.sin(turn)
        out[c] = rows[c] * np.cos(turn) - rows[s] * np.sin(turn)
        return out

    def fresh(self, days: float) -> Array:
        """Return the variance (n,) of the random increment in the given days."""
        out = np.zeros(self.size)
        out[self.block(0)] = self.walk**2 * days / YEAR
        out[self.block(1)] = self.swing**2 * -np.expm1(-2.0 * days / self.tau)
        return out

    def step(self, state: GaussianState, days: float) -> GaussianState:
        """Return the state `days` later. Zero days: the same state."""
        if days <= 0:
            return state
        carried = GaussianState(self.carry(state.mean, days), self.carry(state.factor, days))
        return advance(carried, self.fresh(days))

    def later(self, covariance: Array, days: float) -> Array:
        """Return the covariance `days` later."""
        out = self.carry(self.carry(covariance, days).T, days)
        out[np.diag_indices(self.size)] += self.fresh(days)
        return out


def motion_of(groups: Array, stated: int, rates: tuple[GroupRates, ...]) -> WanderingMotion:
    """Return the motion from the rates of the groups. groups (g,): number of the group of each shape; stated: coefficients z, which are constant."""
    walk, trend, season = (np.array([getattr(r, k) for r in rates])[groups] for k in GRIDS)
    swing = np.array([SWINGS[r.swing] for r in rates])[groups]
    tau = np.array([TAUS[r.tau] for r in rates])[groups]
    return WanderingMotion(stated, walk, trend, season, swing, tau)


def first_state(motion: WanderingMotion) -> GaussianState:
    """Return the state at the date of the machine file: z standard normal, b = -s, w stationary."""
    b, w, s, c, v, _ = (motion.block(k) for k in range(BLOCKS))
    root = np.zeros((motion.size, motion.size))
    root[np.arange(motion.stated), np.arange(motion.stated)] = 1.0
    for rows, columns, size in ((w, w, motion.swing), (s, s, motion.season), (c, c, motion.season)):
        root[rows, columns] = np.diag(size)
    root[b, s], root[v, v] = -np.diag(motion.season), np.diag(motion.trend)
    return GaussianState(np.zeros(motion.size), root[:, root.any(axis=0)])


def first_rates(tracked: TrackedMachine) -> tuple[GroupRates, ...]:
    """Return the rates before any recording: the root mean squares of the priors."""
    return tuple(
        GroupRates(_of_prior("walk"), _of_prior("trend"), _of_prior("season")) for _ in tracked.groups
    )


def nearest_level(name: str, rate: float) -> int:
    """The level of a grid next to a rate, where the search for what is probable begins."""
    grid = np.array(GRIDS[name])
    return int(np.abs(np.log2(np.maximum(grid, 2.0**-8)) - np.log2(max(rate, 2.0**-8))).argmin())
