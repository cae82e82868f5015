"""How well a choice of touches measures form: the range of its residuals against that of the whole surface.

Few points see little of the form and report too little: u is the rms of (measured range - true range) over draws of
form, machine and scatter that are the same for every choice, so that choices can be compared.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.pose import Array
from vcmm.placing.candidates import Problem
from vcmm.placing.design import Design

DRAWS = 200


@dataclass(frozen=True, eq=False)
class FormCheck:
    """Draws of one feature: errors (N_f, draws) that touches share, scatter (N_f, draws) of one touch each, true range."""

    feature: int
    shared: Array
    scatter: Array
    short: Array
    true: Array

    @classmethod
    def of(cls, problem: Problem, feature: str, seed: int) -> FormCheck:
        """The true range is that of the form, less its least-squares element, over all candidates."""
        c = problem.candidates
        f = c.names.index(feature)
        rows = c.of(f)
        rng = np.random.default_rng([seed, f])
        z = rng.normal(size=(c.shared.shape[1], DRAWS))
        form = c.shared[rows, problem.form] @ z[problem.form]
        jac = c.rows[f]
        rest = form - jac @ np.linalg.lstsq(jac, form, rcond=None)[0]
        scatter = c.touch[rows, None] * rng.normal(size=(len(rows), DRAWS))
        short = c.short[rows, None] * rng.normal(size=(len(rows), DRAWS))
        return cls(f, c.shared[rows] @ z, scatter, short, np.ptp(rest, axis=0))

    @property
    def typical(self) -> float:
        """mm: the mean true range."""
        return float(np.mean(self.true))

    def square(self, design: Design) -> float:
        """Mean square of measured - true range, mm^2."""
        rows = design.rows_of[self.feature]
        w = design.counts[rows]
        used = np.flatnonzero(w)
        jac = design.c.rows[self.feature][used]
        error = (self.shared + self.short)[used] + self.scatter[used] / np.sqrt(w[used])[:, None]
        fitted = design.inverse[self.feature] @ ((jac.T * w[used]) @ error)
        return float(np.mean((np.ptp(error - jac @ fitted, axis=0) - self.true) ** 2))
