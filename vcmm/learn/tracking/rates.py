"""How fast numbers wander: rates per group, and how the state goes on in time.

    b(t + d) = b(t) + N(0, walk^2 d / year)                       random walk; zero: constant
    w(t + d) = e^(-d / tau) w(t) + N(0, swing^2 (1 - e^(-2 d / tau)))    Ornstein-Uhlenbeck: mean-reverting, stationary

in units of the usual size of the parameter (Uhlenbeck & Ornstein, Phys. Rev. 36 (1930) 823; exact step: Gillespie, Phys. Rev. E 54 (1996)
2084). Rates stand on a grid of powers of two, bounded: a number that changed by more than eight of its usual sizes in a year is no drift.
The prior of a walk is centred at a quarter of the usual size in a year, a factor of four to either side (one standard deviation); it is an assumption, and
`typical` of each effect states the source of the size. What is used is the root mean square of the walk over all that is still probable, so that few
recordings do not make a machine look steadier than they can tell. A swing has half of the prior at zero.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.tracking.kalman import GaussianState, advance
from vcmm.learn.tracking.quantities import TrackedMachine

YEAR = 365.25  # days
WALKS = (0.0, *(2.0**k for k in range(-6, 4)))
SWINGS = (0.0, *(2.0**k for k in range(-6, 3)))
TAUS = (1.0, 30.0)  # days: from set-up to set-up, and of the season of a shop
CENTRE, SPREAD = -2.0, 2.0  # of log2 of a walk
START = WALKS.index(0.25)


@dataclass(frozen=True)
class GroupRates:
    """Of one group: numbers on the grids WALKS, SWINGS and TAUS; mean: root mean square of the walk over its probabilities."""

    walk: int = START
    swing: int = 0
    tau: int = 0
    mean: float = -1.0

    @property
    def size(self) -> float:
        """The walk in a year: its root mean square where that is known, else that of the grid."""
        return self.mean if self.mean >= 0 else WALKS[self.walk]

    @property
    def log_prior(self) -> float:
        """Of the walk and the swing, nats, but for a constant."""
        steps = [
            np.log2(WALKS[self.walk]) if self.walk else -7.0,
            np.log2(SWINGS[self.swing]) if self.swing else 0.0,
        ]
        walk = -0.5 * ((steps[0] - CENTRE) / SPREAD) ** 2
        known = sum(np.exp(-0.5 * ((k - CENTRE) / SPREAD) ** 2) for k in range(-6, 3))
        swing = (
            np.log(0.5)
            if not self.swing
            else np.log(0.5 / (known * len(TAUS))) - 0.5 * ((steps[1] - CENTRE) / SPREAD) ** 2
        )
        return float(walk + swing)

    def neighbours(self) -> list[GroupRates]:
        """One step on the grids."""
        out = [replace(self, walk=k) for k in (self.walk - 1, self.walk + 1) if 0 <= k < len(WALKS)]
        if not self.swing:
            return out + [replace(self, swing=SWINGS.index(0.25), tau=t) for t in range(len(TAUS))]
        out += [replace(self, swing=k) for k in (self.swing - 1, self.swing + 1) if k < len(SWINGS)]
        return (
            out + [replace(self, swing=0)] + [replace(self, tau=t) for t in range(len(TAUS)) if t != self.tau]
        )

    @property
    def words(self) -> str:
        """constant, random walk, mean-reverting, with their sizes."""
        parts = [f"random walk of {self.size:.3g} in a year" if self.size else ""]
        parts += [
            f"mean-reverting by {SWINGS[self.swing]:.3g} over {TAUS[self.tau]:.3g} d" if self.swing else ""
        ]
        return ", ".join(p for p in parts if p) or "constant"


@dataclass(frozen=True, eq=False)
class WanderingMotion:
    """Rates of every number of a state z, b, w: walk, swing, tau (n,)."""

    walk: Array
    swing: Array
    tau: Array

    def step(self, state: GaussianState, days: float) -> GaussianState:
        """The state `days` later. Zero days: the same state."""
        if days <= 0:
            return state
        decay = np.where(self.swing > 0, np.exp(-days / self.tau), 1.0)
        variance = self.walk**2 * days / YEAR + self.swing**2 * (1.0 - decay**2)
        return advance(state, decay, variance)


def motion_of(groups: Array, stated: int, rates: tuple[GroupRates, ...]) -> WanderingMotion:
    """groups (g,): number of the group of each shape; stated: coefficients z, which are constant."""
    walk = np.array([r.size for r in rates])[groups]
    swing = np.array([SWINGS[r.swing] for r in rates])[groups]
    tau = np.array([TAUS[r.tau] for r in rates])[groups]
    none, one = np.zeros(len(groups)), np.ones(len(groups))
    still = np.zeros(stated)
    return WanderingMotion(
        np.concatenate([still, walk, none]),
        np.concatenate([still, none, swing]),
        np.concatenate([still + 1.0, one, tau]),
    )


def first_state(motion: WanderingMotion, stated: int) -> GaussianState:
    """At the date of the machine file: z standard normal, b zero, w stationary."""
    n = len(motion.walk)
    spread = np.concatenate([np.ones(stated), np.zeros(n - stated)]) + motion.swing
    used = np.flatnonzero(spread > 0)
    factor = np.zeros((n, len(used)))
    factor[used, np.arange(len(used))] = spread[used]
    return GaussianState(np.zeros(n), factor)


def first_rates(tracked: TrackedMachine) -> tuple[GroupRates, ...]:
    levels = np.array([GroupRates(k).log_prior for k in range(len(WALKS))])
    return tuple(GroupRates(mean=mean_walk(levels, range(len(WALKS)))) for _ in tracked.groups)


def mean_walk(logs: Array, levels: Sequence[int]) -> float:
    """Root mean square of the walk over levels of the grid with probabilities exp(logs): a Gaussian of the variance of the mixture."""
    weights = np.exp(logs - np.max(logs))
    square = np.array([WALKS[k] for k in levels]) ** 2
    return float(np.sqrt(weights @ square / weights.sum()))
