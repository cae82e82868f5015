"""Describe a number in time, recording by recording: steady, in proportion to time, a step, or otherwise; present always, or since a date.

Weighted least squares with the stated standard uncertainties. A line gains chi-square over a constant with one degree of freedom, a
step with one for each place where it may be (the smallest chance times the number of places, after Bonferroni). Where what remains is
more than the uncertainties allow, they are enlarged by the ratio of R. T. Birge, Phys. Rev. 40 (1932) 207, and the gain is held
against Student's law of what remains. A steady number is called otherwise less often than 1 in 370 times.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.diagnosis.constants import FAR_SIGMAS

STEADY, DRIFT, STEP, IRREGULAR = "steady", "drift", "step", "irregular"
CHANCE = math.erfc(FAR_SIGMAS / math.sqrt(2.0)) / len(
    (DRIFT, STEP, IRREGULAR)
)  # of each way not to be steady
ALWAYS, APPEARS, GOES, NOW_AND_THEN = "always", "appears", "goes", "now and then"


@dataclass(frozen=True)
class Trend:
    """kind: "" where it cannot be judged. amount, u: of the whole drift, or of the step; first, last: numbers of the recordings that it
    lies between.
    """

    kind: str
    amount: float | None = None
    u: float | None = None
    first: int | None = None
    last: int | None = None


@dataclass(frozen=True)
class _Gain:
    """Gain of a description over a constant. tries: places that it was chosen from; more: parameters beside the constant."""

    chi2: float
    trend: Trend
    tries: int
    more: int


def trend(times: Sequence[float | None], found_values: Sequence[tuple[float, float] | None]) -> Trend:
    """Return the trend of values with standard uncertainties, None where the number was not found, in the order of time.

    times: of every recording, in any unit; where one is not known only a step is looked for, since order is all that is known.
    """
    at = [i for i, s in enumerate(found_values) if s is not None]
    pairs = [s for s in found_values if s is not None]
    if len(at) < 2 or not all(u is not None and u > 0 for _, u in pairs):
        return Trend("")
    values, u = np.array(pairs).T
    dates = [at_time for i in at if (at_time := times[i]) is not None]
    gains = _steps(at, values, u)
    if len(dates) == len(at) > 2 and len(set(dates)) > 2:
        gains.append(_line(np.array(dates), at, values, u))
    total, best = _chi2(values, u), max(gains, key=lambda g: g.chi2 - 2 * math.log(g.tries))
    free = len(at) - 1 - best.more
    rest = max(total - best.chi2, 0.0)
    scale = rest / free if free > 0 and _beyond(rest, free) < CHANCE else 1.0
    if best.tries * _two_sided_chance(best.chi2 / scale, free if scale > 1 else None) < CHANCE:
        course = best.trend
        return Trend(
            course.kind, course.amount, float(course.u or 0.0) * math.sqrt(scale), course.first, course.last
        )
    return Trend(IRREGULAR if _beyond(total, len(at) - 1) < CHANCE else STEADY)


def presence(found_values: Sequence[tuple[float, float] | None]) -> tuple[str, int | None, int | None]:
    """Return whether a number was found always, since when, or until when: between which two recordings (their numbers) that lies."""
    there = [s is not None for s in found_values]
    turns = [i for i in range(len(there) - 1) if there[i] != there[i + 1]]
    if not turns:
        return ALWAYS, None, None
    if len(turns) > 1:
        return NOW_AND_THEN, None, None
    return (GOES if there[0] else APPEARS), turns[0], turns[0] + 1


def _chi2(values: Array, u: Array) -> float:
    """Return the chi-square about the weighted mean."""
    mean = np.average(values, weights=u**-2)
    return float((((values - mean) / u) ** 2).sum())


def _steps(at: Sequence[int], values: Array, u: Array) -> list[_Gain]:
    """Return the best place of a step."""
    total, out = _chi2(values, u), []
    for k in range(1, len(values)):
        parts = [(values[:k], u[:k]), (values[k:], u[k:])]
        before, after = (float(np.average(v, weights=s**-2)) for v, s in parts)
        spread = math.sqrt(sum(1.0 / float((s**-2).sum()) for _, s in parts))
        made = Trend(STEP, after - before, spread, at[k - 1], at[k])
        out.append(
            _Gain(total - sum(_chi2(v, s) for v, s in parts), made, len(values) - 1, min(2, len(values) - 1))
        )
    return [max(out, key=lambda g: g.chi2)]


def _line(times: Array, at: Sequence[int], values: Array, u: Array) -> _Gain:
    w = u**-2
    x = times - np.average(times, weights=w)
    square = float((w * x * x).sum())
    slope, span = float((w * x * values).sum()) / square, float(times[-1] - times[0])
    return _Gain(slope**2 * square, Trend(DRIFT, slope * span, span / math.sqrt(square), at[0], at[-1]), 1, 1)


def _beyond(chi2: float, free: int) -> float:
    """Return the chance of a chi-square as large or larger."""
    from scipy.special import gammaincc

    return float(gammaincc(free / 2, chi2 / 2))


def _two_sided_chance(square: float, free: int | None) -> float:
    """Return the chance of a squared deviation as large or larger: normal, or Student's with so many degrees of freedom."""
    if free is None:
        return math.erfc(math.sqrt(max(square, 0.0) / 2))
    from scipy.special import betainc

    return float(betainc(free / 2, 0.5, free / (free + square)))
