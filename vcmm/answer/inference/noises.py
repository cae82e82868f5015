"""Noise in the residuals of a feature beside its form: from the known errors of the machine to its limits.

    C = C_known + a^2 C_own + b^2 I         covariance of residuals along orthonormal waves

A limit is no observation: residuals may be read with any error between none and the limit, and each reading leaves another form
possible. With little of it all residuals are form; with much of it a form may hide behind it. So results for a machine of which
only limits are known must not depend on them:

    b    variation from touch to touch, scatter and roughness of the surface together: of any size, known from the residuals alone
         (its law before: every size alike by its logarithm, H. Jeffreys, Proc. R. Soc. A 186 (1946) 453); R0 is not used
    a    errors of the machine itself: none, and all sizes up to the limit, on a ladder of which each rung is twice the one before and
         which depends on the residuals: a worse limit adds rungs and takes none away. The result holds for every rung.

The ladders end where residuals exclude more. Independent departures of standard deviation s leave residuals below |r| = s q with
a small probability, q^2 that quantile of chi-squared, and a form on top makes small residuals less likely still (T. W. Anderson,
Proc. Am. Math. Soc. 6 (1955) 170). Errors of the machine lie along few waves, so they may be MOST_OWN times the measured residuals.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field, replace

import numpy as np

from vcmm.answer.evaluation.bound_shares import split
from vcmm.answer.evaluation.form_family import Ints
from vcmm.answer.evaluation.linear import LinearModel, term_of
from vcmm.answer.evaluation.montecarlo import Term, covariance
from vcmm.answer.evaluation.pairs import SMALLEST
from vcmm.answer.evaluation.part_forms import FORM
from vcmm.core.laws import Law, Normal
from vcmm.core.run import Array

# of the residuals: taken for none; from here on two rungs to a doubling instead of one
LEAST_NOISE = 1 / 16
HALF = 1 / 2
FIRST_OWN, MOST_OWN = 1 / 4, 8.0  # of the residuals: the first and the last rung of the machine's own errors
NONE = -999  # rung of no error at all


@dataclass(frozen=True)
class Rung:
    """systematic, white: half powers of two of a mm, 2^(n / 2), of the machine's own errors and of each touch; both None: the stated noise, where no Input is only a limit."""

    systematic: int | None
    white: int | None


STATED = Rung(None, None)


@dataclass(frozen=True, eq=False)
class Noises:
    """Covariances (d, d) of the noise in the residuals along a base of d orthonormal waves, of n points."""

    machine: Array
    systematic: Array
    scatter: Array
    points: int
    _whitenings: dict[Rung, tuple[Array, float]] = field(default_factory=dict, repr=False)

    @property
    def is_bound(self) -> bool:
        """Whether some of it is known by a limit only."""
        return bool(self.systematic.any() or self.scatter.any())

    def rungs(self, residuals: Array, excluded: float) -> tuple[tuple[Rung, ...], ...]:
        """Return the noises with which residuals (n,) are read: for every size of the machine's own errors the sizes of all other noise.

        excluded: see the docstring of the module.
        """
        rms = float(np.sqrt((residuals**2).mean()))
        if not self.is_bound or rms <= SMALLEST:
            return ((STATED,),)
        systematic = [NONE]
        if self.systematic.any():
            last = min(_size(self.systematic), MOST_OWN * rms)
            systematic += range(2 * _power(FIRST_OWN * rms), 2 * math.ceil(math.log2(last)) + 1, 2)
        return tuple(tuple(Rung(a, b) for b in self._white(rms, excluded)) for a in systematic)

    def _white(self, rms: float, excluded: float) -> list[int]:
        if not self.scatter.any():
            return [NONE]
        half = 2 * _power(HALF * rms)
        most = rms * math.sqrt(self.points / _quantile_of_chi_squared(excluded, len(self.machine)))
        return [
            *range(2 * _power(LEAST_NOISE * rms), half, 2),
            *range(half, math.ceil(2 * math.log2(most)) + 1),
        ]

    def whitening(self, rung: Rung) -> tuple[Array, float]:
        """Return the matrix that turns amounts of the waves in the residuals into independent numbers of variance 1, and the root mean
        square noise of a point, mm.
        """
        if rung not in self._whitenings:
            self._whitenings[rung] = self._whitening(rung)
        return self._whitenings[rung]

    def _whitening(self, rung: Rung) -> tuple[Array, float]:
        d = len(self.machine)
        if rung.systematic is None or rung.white is None:
            spread = self.machine + self.systematic + self.scatter
        else:
            systematic, white = (0.0 if n == NONE else 2.0 ** (n / 2) for n in (rung.systematic, rung.white))
            spread = (
                self.machine
                + self.systematic * (systematic / max(_size(self.systematic), SMALLEST)) ** 2
                + white**2 * np.eye(d)
            )
        spread = spread + SMALLEST**2 * np.eye(d)
        noise = float(np.sqrt(np.trace(spread) / d)) if d else SMALLEST
        return np.linalg.inv(np.linalg.cholesky(spread)) if d else spread, max(noise, SMALLEST)


def _size(spread: Array) -> float:
    """Return the root mean square at a point."""
    return float(np.sqrt(np.trace(spread) / len(spread))) if len(spread) else 0.0


def _power(size: float) -> int:
    return round(math.log2(size))


def _quantile_of_chi_squared(p: float, d: int) -> float:
    """Return the quantile of chi-squared with d degrees of freedom."""
    from scipy.special import gammaincinv

    return max(2.0 * float(gammaincinv(0.5 * max(d, 1), p)), 1e-6)


def noises_of(model: LinearModel, rows: Ints, basis: Array) -> Noises:
    """Return the noises. rows (n,): touches of the feature whose residuals are read; basis (n, d): orthonormal waves in them."""
    operator = np.zeros((basis.shape[1], model.task.touches.run.n))
    operator[:, rows] = basis.T
    stated, systematic, scatter = (_covariance(part, operator) for part in split(model))
    return Noises(stated, systematic, scatter, len(rows))


def _covariance(model: LinearModel, operator: Array) -> Array:
    terms = [
        _finite(term_of(f, model.along_normal(f), operator))
        for f in model.influences
        if f.input.effect != FORM
    ]
    d = len(operator)
    return covariance(terms) if d and terms else np.zeros((d, d))


def _finite(term: Term) -> Term:
    """Return the term with a law of finite variance: a law without one counts by its scale, so that the noise is not overestimated."""
    law = term.law
    return replace(term, law=Normal(law.scale)) if isinstance(law, Law) and not np.isfinite(law.u) else term
