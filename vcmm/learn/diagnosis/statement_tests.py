"""Pulls: test whether the statements of the machine file agree with the rows.

    r = K z + e,  z ~ N(0, 1),  e ~ N(0, sigma^2)      K: effect of one standard uncertainty of every Input on the rows
    pull = z of the rows (one number), the estimate after the rows less the statement, in units of the stated u

An Input of many numbers (a table with its correlation) has one pull too: z' C^-1 z, C its covariance by the statement,
follows a chi-square law, put on the scale of the normal law by Wilson & Hilferty, Proc. Natl. Acad. Sci. 17 (1931) 684.
A statement that is true has a pull beyond 3 in 1 of 370 cases (normal law).
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vcmm.answer.evaluation.gaussian import condition
from vcmm.core.run import Array
from vcmm.learn.diagnosis.constants import FAR_SIGMAS, LOWEST, MOSTLY
from vcmm.learn.diagnosis.problem import Problem


@dataclass(frozen=True)
class Pull:
    """Input id; estimate after less estimate stated, in units of the stated standard uncertainty; numbers that the rows tell of."""

    input: str
    pull: float
    numbers: int


def calibration_pulls(problem: Problem, rest: Array, sigma: float, u: Array, rho: float) -> tuple[Pull, ...]:
    """Return the pulls of all Inputs that the rows show, the largest first. rest (m,): residual, mm or rad, after the findings.

    sigma: noise over u (m,); rho: correlation of neighbours.
    """
    if not problem.stated:
        return ()
    white = problem.without_statements([name for name, _ in problem.stated]).whitener(u, rho)
    k, y = white.apply(problem.calibration) / sigma, white.apply(rest) / sigma
    posterior = condition(k.T @ k, k.T @ y, np.ones(k.shape[1]))
    left, z = posterior.covariance, posterior.mean  # variance of z that the rows leave
    out, at = [], 0
    for name, columns in problem.stated:
        part = slice(at, at + columns.shape[1])
        out.append(_pull(name, z[part], np.eye(columns.shape[1]) - left[part, part]))
        at += columns.shape[1]
    stated = {item.id for item in problem.machine.inputs} | {name for name, _ in problem.recording.known}
    return tuple(sorted((p for p in out if p.numbers and p.input in stated), key=lambda p: -abs(p.pull)))


def _pull(name: str, z: Array, precision: Array) -> Pull:
    """Return the pull of one Input: z (k,) of the rows, and the covariance of such estimates where the statement is true."""
    size, vector = np.linalg.eigh(precision)
    is_visible = size > MOSTLY
    k = int(is_visible.sum())
    if len(z) == 1 or not k:
        return Pull(name, float(z[0]) if k else 0.0, k)
    square = float(np.sum((vector[:, is_visible].T @ z) ** 2 / size[is_visible]))
    return Pull(name, _as_normal(square, k), k)


def _as_normal(square: float, dof: int) -> float:
    """Return a chi-square on the scale of the standard normal law."""
    spread = 2.0 / (9.0 * dof)
    return float((np.cbrt(square / dof) - (1.0 - spread)) / np.sqrt(spread))


def pull_limit(count: int) -> float:
    """Return the value that the largest of `count` pulls exceeds as rarely as one pull exceeds 3 where every statement is true: 3.6 of 8,
    3.8 of 21."""
    from scipy.special import ndtr, ndtri

    return float(-ndtri(ndtr(-FAR_SIGMAS) / max(count, 1)))


def contradiction_probability(pull: float, count: int) -> float:
    """Return the probability that a statement with this pull does not hold, the largest of `count` pulls, equal odds before.

    1 / (1 - e p ln p) with p the two-sided probability of chance: the most that p can say against a statement (Sellke,
    Bayarri & Berger, Am. Stat. 55 (2001) 62).
    """
    from scipy.special import ndtr

    p = min(max(2.0 * count * float(ndtr(-abs(pull))), LOWEST), 1.0 / math.e)
    return float(1.0 / (1.0 - math.e * p * np.log(p)))
