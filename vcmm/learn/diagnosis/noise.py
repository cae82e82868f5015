"""Noise audit: scale, outliers, tails, correlation of neighbours, variance that grows with speed.

Findings about the noise are never the answer to a mean shift; they prepare the data (clipping, weights, an AR(1)
filter) before physics is tested, and the null is simulated with the same preparation. Each statistic is compared with its
own Monte Carlo null.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.answer.evaluation.gaussian import Ints, Whitener, best_width
from vcmm.core.laws import StudentT
from vcmm.core.run import Array
from vcmm.learn.diagnosis.constants import (
    CHANCE,
    FALSE_ALARM,
    FAR_SIGMAS,
    FEWEST,
    HEAVY,
    LEAST_FRACTION,
    OUTLYING,
    QUANTILE,
    RELEVANT,
    SECURE,
    STRONG_CORRELATION,
    STRUCTURE_CORRELATION,
    UNSEEN,
    VERY_STRONG,
)
from vcmm.learn.diagnosis.locate import direction_factors, path_speed, polynomials
from vcmm.learn.diagnosis.null_recordings import Noise, by_columns, draw_null_recordings, robust_scale
from vcmm.learn.diagnosis.problem import Problem, generator
from vcmm.physics.structure.scatter import Scatter

DRAWS = 600
TRIAL_CORRELATIONS = tuple(
    np.append(np.arange(0.0, STRUCTURE_CORRELATION, 0.1), (STRUCTURE_CORRELATION, SECURE))
)
NULL_COUNT = 60


@dataclass(frozen=True, eq=False)
class Audit:
    """scale: sigma of one observation in units of u; rho; growth: ln sigma per mm/s of speed; findings in words.

    limit: the scale that the stated noise may show, whatever its tails, correlation and speed were found to be.
    u_factor: factor on u where the noise was stated too large beyond chance, else 1: beside a smaller noise the uncertainty of
    the calibration weighs more, and is taken for physics where that is not counted.
    """

    scale: float
    rho: float
    growth: float
    noise: Noise
    findings: tuple[str, ...]
    limit: float = np.inf
    u_factor: float = 1.0

    def u(self, problem: Problem) -> Array:
        """Return the standard uncertainties with the found dependence on speed, and smaller where they were stated too large."""
        speed = speeds(problem)
        by_speed = 1.0 if speed is None or self.growth == 0 else np.exp(self.growth * speed)
        return np.asarray(self.u_factor * problem.u * by_speed)


def stated_noise(problem: Problem) -> Noise:
    """Return the law of the recording's noise, else of the machine's repeatability, in units of u."""
    scatter = [i.law for i in problem.machine.inputs if i.effect == Scatter.name]
    law = problem.recording.noise or (scatter[0] if scatter and problem.recording.u is None else None)
    return Noise(float(law.dof)) if isinstance(law, StudentT) and law.dof > 2 else Noise()


def audit(problem: Problem, white: Whitener, rest: Array, seed: int) -> Audit:
    """Look at white residuals (m,) that hold no known effect; `white` must be without AR filter and speed weights."""
    noise = stated_noise(problem)
    null = draw_null_recordings(noise, white, seed, "noise audit", DRAWS)
    spread = robust_scale(null)
    middle = float(np.median(spread))
    findings: list[str] = []
    heavy = _tails(rest, null, spread, findings)
    rho = _correlation(rest, (null, spread), problem, white, seed, findings)
    growth = _growth(rest, null, problem, white, findings)
    scale = float(robust_scale(rest)) / middle
    if not 1.0 / RELEVANT < scale < RELEVANT:
        findings.append(f"the noise is {scale:.2g} times what was stated")
    dof = min(noise.dof, HEAVY) if heavy else noise.dof
    limit = _limit(spread, problem, white, rho, seed) * _by_speed(rest, problem, growth)
    usual = spread / middle
    less = scale if scale < float(np.quantile(usual, 1.0 - QUANTILE)) else 1.0
    return Audit(scale, rho, growth, Noise(dof), tuple(findings), limit, less)


def _limit(spread: Array, problem: Problem, white: Whitener, rho: float, seed: int) -> float:
    """Return the largest scale that a recording of the stated noise shows, and that needs no remark. spread: robust scale of null ones.

    The scale is a median: tails and outliers hardly move it (a t law of 3 degrees of freedom at the same quartiles not at
    all). Correlation of the stated variance widens what chance gives; strong correlation and a larger variance together are
    two signs of the same movement, so there chance alone is the limit.
    """
    usual = spread / float(np.median(spread))
    if rho < STRONG_CORRELATION:
        return max(float(np.quantile(usual, CHANCE)), RELEVANT * float(np.quantile(usual, 1.0 - FALSE_ALARM)))
    rng = generator(seed, "correlated scale")
    noise = chain_noise(rng.standard_normal((problem.m, DRAWS)), problem.before, rho)
    scales = by_columns(lambda x: robust_scale(white.apply(x / white.weight[:, None])), noise)
    return float(np.quantile(scales / float(np.median(spread)), CHANCE))


def _by_speed(rest: Array, problem: Problem, growth: float) -> float:
    """Return the scale over all rows divided by that at the speed of least scatter, where the stated noise is compared."""
    speed = speeds(problem)
    if speed is None or growth == 0:
        return 1.0
    slow = rest * np.exp(-growth * (speed - (speed.min() if growth > 0 else speed.max())))
    return max(float(robust_scale(rest)) / max(float(robust_scale(slow)), LEAST_FRACTION), 1.0)


def _tails(rest: Array, null: Array, spread: Array, findings: list[str]) -> bool:
    scale = robust_scale(rest)
    far, far_null = _beyond(OUTLYING, rest, scale), _beyond(OUTLYING, null, spread)
    if far > np.quantile(far_null, QUANTILE):
        findings.append(f"outliers {100 * far:.1f} %")
        return True
    tail, tail_null = _beyond(FAR_SIGMAS, rest, scale), _beyond(FAR_SIGMAS, null, spread)
    if tail > np.quantile(tail_null, QUANTILE):
        findings.append(f"heavy tails: {100 * tail:.1f} % beyond 3 standard deviations")
        return True
    return False


def _beyond(limit: float, r: Array, spread: Array) -> Array:
    """Return the share of the residuals (m,) or (m, M) beyond `limit` times their spread."""
    return by_columns(lambda x, scale: np.asarray((np.abs(x) > limit * scale).mean(axis=0)), r, spread)


def _correlation(
    rest: Array, null: tuple[Array, Array], problem: Problem, white: Whitener, seed: int, findings: list[str]
) -> float:
    """Return rho; 0 where null recordings (with their spread) show as much."""
    correlation = float(neighbour_correlation(rest, problem.before))
    chance = neighbour_correlation(null[0], problem.before, null[1])
    if not np.isfinite(correlation) or correlation <= np.quantile(chance, QUANTILE):
        return 0.0
    rho = _unbiased_correlation(correlation, problem, white, seed)
    findings.append(f"neighbouring observations are correlated, about {rho:.2f}")
    return rho


def _unbiased_correlation(correlation: float, problem: Problem, white: Whitener, seed: int) -> float:
    """Return the rho whose simulated noise, seen through the same nuisance, gives the statistic found (indirect inference)."""
    rng = generator(seed, "correlation")
    innovation = rng.standard_normal((problem.m, NULL_COUNT))
    medians = []
    for rho in TRIAL_CORRELATIONS:
        noise = chain_noise(innovation, problem.before, rho)
        whitened = white.apply(noise / white.weight[:, None])
        medians.append(float(np.median(neighbour_correlation(whitened, problem.before))))
    return float(np.interp(correlation, np.maximum.accumulate(medians), TRIAL_CORRELATIONS))


def chain_noise(innovation: Array, before: Ints, rho: float) -> Array:
    """Return AR(1) series (m, M) of unit variance from white innovations; rows follow their predecessors."""
    out = innovation.copy()
    for i, j in enumerate(before):
        if j >= 0:
            out[i] = rho * out[j] + np.sqrt(1 - rho**2) * innovation[i]
    return out


def neighbour_correlation(r: Array, before: Ints, spread: Array | None = None) -> Array:
    """Return AR(1) coefficient from differences at lag 1 and 2, blind to slow drifts: gamma2 / gamma1 = 1 + rho; (M,) or scalar.

    gamma_k = half the mean squared difference of observations k apart (Allan-type); values are limited to 3 robust
    standard deviations (`spread`, where it is known) first.
    """
    second = np.where(before >= 0, before[before], -1)
    rows = np.flatnonzero(second >= 0)
    if len(rows) < FEWEST:
        return np.zeros(r.shape[1:])

    def of(part: Array, scale: Array) -> Array:
        x = np.clip(part, -FAR_SIGMAS * scale, FAR_SIGMAS * scale)
        single = ((x[rows] - x[before[rows]]) ** 2).mean(axis=0)
        double = ((x[rows] - x[second[rows]]) ** 2).mean(axis=0)
        return np.asarray(double / np.maximum(single, LEAST_FRACTION) - 1.0)

    return by_columns(of, r, robust_scale(r) if spread is None else spread)


def speeds(problem: Problem) -> Array | None:
    """Return |v| of every observation (m,) mm/s, or None."""
    speed = path_speed(problem.run)
    return None if speed is None else problem.per_observation(speed)


def _growth(rest: Array, null: Array, problem: Problem, white: Whitener, findings: list[str]) -> float:
    """Return d ln sigma / d speed, 0 where the spread does not depend on speed."""
    speed = speeds(problem)
    if speed is None or np.ptp(speed) < UNSEEN * max(1.0, float(np.abs(speed).max())):
        return 0.0
    centred = (speed - speed.mean()) / speed.std()
    slope = float(_log_slope(rest, centred))
    chance = _log_slope(null, centred)
    usual = np.quantile(np.abs(chance), QUANTILE)
    if abs(slope) <= usual:
        return 0.0
    if abs(float(_log_slope(_without_product(rest, problem, white, speed), centred))) <= usual:
        return 0.0  # a mean that speed and place make together looks like a scatter: physics, to be found as such
    findings.append(
        f"the scatter depends on speed: ratio {np.exp(slope * np.ptp(centred)):.2g} from slow to fast"
    )
    return slope / float(speed.std())


def _without_product(rest: Array, problem: Problem, white: Whitener, speed: Array) -> Array:
    """Return the white residuals (m,) less the best mean of the form f(place) g(speed), where the evidence for one is VERY_STRONG.

    An error e(q) v with a place q that the residual changes sign over has no mean at any speed and a spread in
    proportion to it. The product is weighed against no product at equal scatter; the number tried is paid for.
    """
    run = problem.run
    axes = [a for a in run.position if np.ptp(run.position[a]) > 0]
    shapes = [
        white.apply(
            _products(problem.per_observation(run.position[a]), speed) * (factor * problem.u)[:, None]
        )
        for a in axes
        for factor in direction_factors(problem).values()
    ]
    shapes = [x for x in shapes if x.shape[1]]
    if not shapes:
        return rest
    bound = FAR_SIGMAS * robust_scale(rest)
    limited = np.clip(rest, -bound, bound)
    fits = [best_width(x, limited, white.dof) for x in shapes]
    best = int(np.argmax([f.log_evidence for f in fits]))
    if fits[best].log_evidence <= VERY_STRONG + np.log(len(shapes)):
        return rest
    return np.asarray(rest - shapes[best] @ fits[best].mean)


def _products(place: Array, speed: Array) -> Array:
    """Return P_i(place) P_j(speed), i up to 3, j 1 and 2 (m, 8)."""
    a, b = polynomials(place, 3), polynomials(speed, 2)[:, 1:]
    return np.concatenate([a * b[:, [j]] for j in range(b.shape[1])] or [a[:, :0]], axis=1)


def _log_slope(r: Array, x: Array) -> Array:
    """Return the slope of ln|r| on x (standardised): ln of the scale is linear in x; tiny residuals are floored."""

    def of(part: Array) -> Array:
        level = np.log(np.maximum(np.abs(part), 0.05 * robust_scale(part)))
        return np.asarray((x @ (level - level.mean(axis=0))) / len(x))

    return by_columns(of, r)
