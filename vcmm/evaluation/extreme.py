"""What is known of a true value whose indicated value is an extreme one: the inverse, what it may claim, its budget."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vcmm.core.run import Array
from vcmm.evaluation.inverse import BLIND, Inverted, inverted
from vcmm.evaluation.linear import LinearModel
from vcmm.evaluation.montecarlo import Term, simulate
from vcmm.evaluation.true_parts import TrueParts
from vcmm.gps import characteristics as gps
from vcmm.gps.criteria import chosen
from vcmm.measuring.settings import Settings

STEPS = np.array(
    [0, 0.1, 0.25, 0.5, 0.75, 1, 1.5, 2, 3, 4, 6, 8, 12, 20, 40, 80.0]
)  # true values over the noise
TRIALS, CONTACT_TRIALS, NUMBERS = 8000, 600, 2e7
AUDITED, AUDIT_TRIALS = (
    (0.0, 0.4, 0.9, 2.5, 5.0, 10.0, 30.0),
    2000,
)  # true values over the noise, between the steps
BELOW, BELOW_UNKNOWN = (
    0.02,
    0.05,
)  # what attained coverage may fall short of p: by the family, by one it does not know


FAR = 30.0  # true values over the noise: where it acts linearly
MEANT, MEANT_FORM = (
    20.0,
    4.0,
)  # for which U is told at least; of form, where U grows with what lies between the points


def _half(values: Array) -> float:
    """Half the width of the middle 68 %: a standard deviation that heavy tails do not move."""
    low, high = np.quantile(values, [0.1587, 0.8413])
    return float(high - low) / 2


@dataclass(frozen=True, eq=False)
class Extreme:
    """One characteristic with an extreme value. limit: the zone, None where there is none; mm."""

    model: LinearModel
    terms: Sequence[Term]
    settings: Settings
    limit: float | None

    @cached_property
    def parts(self) -> TrueParts:
        return TrueParts(self.model, self.model.characteristics[0])

    @cached_property
    def trials(self) -> int:
        most = TRIALS if chosen(self.parts.characteristic).gauss else CONTACT_TRIALS
        return int(np.clip(NUMBERS / len(self.model.q0), 500, most))

    def _noise(self, terms: Sequence[Term], first: int, count: int, fold: bool = True) -> Array:
        blocks = simulate(
            np.zeros(len(self.model.q0)), terms, seed=self.settings.seed, trials=count, first=first, fold=fold
        )
        return np.concatenate(list(blocks))

    @cached_property
    def noise(self) -> Array:
        return self._noise(self.terms, 0, len(self.shapes))

    @cached_property
    def shapes(self) -> Array:
        """(m, K): parts of all known families, one after another."""
        known = self.parts.families[0]
        count = self.trials // len(known)
        return np.concatenate([self.parts.shapes(family, count, self.settings.seed) for family in known])

    def _indicated(self, true: float, shapes: Array, noise: Array) -> Array:
        return np.asarray(self.model.values(self.parts.indicated + true * shapes + noise)[:, 0])

    @cached_property
    def scale(self) -> float:
        """Spread of what is indicated of a part far from perfect, where noise acts linearly, mm."""
        some = slice(None, None, max(1, self.trials // 1000))  # of every family
        shapes, noise = self.shapes[some], self.noise[some]
        far = FAR * _half(self._indicated(0.0, shapes, noise)) + 1e-6
        alone = self._indicated(far, shapes, np.zeros_like(noise))
        return max(_half(self._indicated(far, shapes, noise) - alone), 1e-12)

    @cached_property
    def true(self) -> Array:
        """True values at which the machine is asked, mm."""
        own = [] if self.limit is None else [self.limit]
        steps = STEPS if chosen(self.parts.characteristic).gauss else STEPS[::2]
        return np.unique(np.concatenate([self.scale * steps, own]))

    @cached_property
    def table(self) -> Array:
        """Indicated values (t, m)."""
        return np.stack([self._indicated(t, self.shapes, self.noise) for t in self.true])

    @cached_property
    def inverse(self) -> Inverted:
        return inverted(self.true, np.split(self.table, len(self.parts.families[0]), axis=1))

    @cached_property
    def reference(self) -> int:
        """Number of the true value whose indication spreads most, up to a few times the noise or what is indicated.

        Further out noise acts linearly: U of it holds for every part that is off by as much, and for better ones.
        """
        estimate = self.inverse.given(
            float(self.model.values(self.model.q0)[0]), self.settings.p, ""
        ).estimate
        form = self.parts.characteristic.type in gps.FORM
        most = max((MEANT_FORM if form else MEANT) * self.scale, estimate)
        return int(np.argmax(np.where(self.true <= most * (1 + 1e-12), self.table.std(axis=1), 0.0)))

    @property
    def u(self) -> float:
        """Standard deviation of what is indicated at the reference."""
        return float(self.table[self.reference].std())

    @property
    def expanded(self) -> float:
        """Half of where p of the indications of the reference lie."""
        low, high = self.inverse.ends(float(self.true[self.reference]), self.settings.p)
        return (high - low) / 2

    def contributions(self) -> tuple[list[float], float]:
        """Standard deviation of what each Input alone adds, and by the form of the part between its points, at the reference."""
        true, some = float(self.true[self.reference]), slice(None, None, max(1, self.trials // 2000))
        shapes = self.shapes[some]
        quiet = self._indicated(true, shapes, np.zeros_like(self.noise[some]))
        out = []
        for term in self.terms:
            noise = self._noise([term], 0, len(shapes), fold=False)
            out.append(float((self._indicated(true, shapes, noise) - quiet).std()) if noise.any() else 0.0)
        return out, float(quiet.std())

    def shortfall(self) -> str:
        """Why the interval is not claimed to hold the true value in p of measurements; empty where it was seen to.

        Seen: parts and machines that the inverse was not made of are drawn, of its own family and of others, and counted.
        """
        p = self.settings.p
        if self.inverse.sight(p) < BLIND:
            return "the points hardly meet some forms: a part of any true value could indicate as little"
        noise = self._noise(self.terms, len(self.shapes), min(AUDIT_TRIALS, self.trials))
        known, unknown = self.parts.families
        for family in (*known, *unknown):
            shapes = self.parts.shapes(family, len(noise), self.settings.seed + 1)
            least = p - (BELOW if family in known else BELOW_UNKNOWN)
            found = min(
                self.inverse.attained(t * self.scale, self._indicated(t * self.scale, shapes, noise), p)
                for t in AUDITED
            )
            if found < least:
                return (
                    f"of parts with {family} departures the interval holds the true value in {found:.1%} only"
                )
        return ""
