"""Rows far from what is predicted, by their lines: a verdict counts each of them as a few standard deviations, and says so.

A row is told where, by the stated law of the noise, so many rows would show one as far less than once in 1000 recordings.
"""

from __future__ import annotations

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener
from vcmm.core.run import Array
from vcmm.learn.diagnosis.constants import CHANCE, FAR
from vcmm.learn.diagnosis.delivery import left_over
from vcmm.learn.diagnosis.noise import stated_noise
from vcmm.learn.diagnosis.null import robust_scale
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.select import Selection


def far_rows(problem: Problem, rest: Array) -> tuple[str, ...]:
    """What to tell; rest (m,): white residuals after all names, nothing pulled in."""
    size = np.abs(rest) / float(robust_scale(rest))
    out = size > _limit(stated_noise(problem).dof, len(rest))
    if not out.any():
        return ()
    count = int(out.sum())
    rows = f"{problem.recording.places(out)} lie{'s' if count == 1 else ''}"
    far = f"{size[out].max():.1f}" if count == 1 else f"{size[out].min():.1f} to {size[out].max():.1f}"
    return (
        f"{rows} {far} standard deviations from what is predicted, and count as {FAR:g}: bad readings, or something that happened there"
        " alone and that no verdict is about; look at them",
    )


def raw_rest(problem: Problem, white: Whitener, selection: Selection) -> Array:
    """White residuals (m,) after the terms, nothing pulled in."""
    return white.apply(left_over(problem, selection))


def _limit(dof: float, m: int) -> float:
    """Standard deviations (of the normal law's robust scale) that one of m rows exceeds with the probability 1 - CHANCE."""
    from scipy.stats import norm, t

    tail = (1.0 - CHANCE) / (2.0 * m)
    if not np.isfinite(dof):
        return float(norm.isf(tail))
    return float(t.isf(tail, dof) / t.isf(norm.sf(1.0), dof))
