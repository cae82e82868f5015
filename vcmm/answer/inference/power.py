"""Power of the test of memory: how often it would notice noise that continues from touch to touch, at the points of one task.

The share of parts with e_t = 0.95 e_(t-1) + a_t, of the noise that is stated, without form or with four times as much form (the
lesser share counts), whose likelihood ratio exceeds the largest of the limits that the test has (families of forms, noise over what is stated), see `residual_tests`: its power (E. L. Lehmann,
J. P. Romano, Testing Statistical Hypotheses, 2005, 3.1). A long memory looks like a form to few points: then the test cannot see it.
"""

from __future__ import annotations

from collections.abc import Mapping
from itertools import product

import numpy as np
import numpy.typing as npt

from vcmm.answer.evaluation.form_family import KNOWN
from vcmm.answer.inference.memory import RHOS, Whitening, likelihood_ratio, whitening
from vcmm.answer.inference.residual_tests import (
    ALARM,
    LEAST_SCAN,
    MOST_FORM_POINTS,
    NOISES,
    FeatureTest,
    Ints,
    ResidualTests,
    as_large,
)
from vcmm.core.run import Array

Booleans = npt.NDArray[np.bool_]

RHO, LEAST_POWER = 0.95, 0.9  # the memory that is tested; power below which it is reported as not covered
FORMS, GROUPS = (0.0, 4.0), 4  # form over noise of the parts; groups by the size of their residuals
PARTS, LIMITS = 100, 599  # parts drawn with memory; parts of the null at most: ALARM / 2 of 600 are three
MOST_POWER_POINTS = 400  # points of all scans up to which the power is counted: the time goes with their cube
TOO_FEW = (
    "noise that goes on from touch to touch (correlation {rho:g} of neighbours): {n} points are too few to notice it, the test of the "
    "residuals would in {power:.0%} of such parts; at 36 points an outside count held {sizes} of their sizes and {forms} of their roundnesses"
)
HELD = {"sizes": "30 of 117", "forms": "93 of 117"}  # docs/referee.md, machine ar
NOT_COUNTED = (
    "noise that goes on from touch to touch (correlation {rho:g} of neighbours): how often it is noticed is not counted beyond "
    "{most} points in all"
)
NOT_TESTED = "noise that goes on from touch to touch: {why}"
NO_POINTS = NOT_TESTED.format(why="values alone do not show it; hand in the points (--points)")
TOO_FEW_POINTS, TOO_MANY_POINTS = (
    f"no feature has the {LEAST_SCAN} points from which it is looked for",
    f"it is not looked for on features of more than {MOST_FORM_POINTS} points",
)


def power(tests: ResidualTests, order: Mapping[str, Ints], rho: float = RHO) -> float:
    """Return the share of parts whose memory would be noticed, all tested features together; the least over the forms that they may have."""
    scans, shares = _scans(tests), []
    white = [
        {n: [whitening(f.bases[number][order[n]], r) for r in RHOS] for n, f in scans.items()}
        for number in (0, -1)
    ]
    for ratio in FORMS:
        rng, rests = np.random.default_rng([tests.seed, 95]), dict[str, Array]()
        for n, f in scans.items():
            e = np.empty((PARTS, f.n))
            e[:, order[n]] = _noise_with_memory(rng, f.n, rho)
            rests[n] = f.rest(tests.scale[n] * (e + ratio * tests.shapes(n, KNOWN[0])[:PARTS]))
        size = sum((r**2).sum(axis=1) for r in rests.values())
        noticed = 0
        for group in np.array_split(np.argsort(size), GROUPS):  # the null of a part is as large as it is
            some = {n: r[group] for n, r in rests.items()}
            noticed += int(np.any([_is_noticed(tests, order, w, some) for w in white], axis=0).sum())
        shares.append(noticed / PARTS)
    return min(shares)


def _is_noticed(
    tests: ResidualTests,
    order: Mapping[str, Ints],
    white: Mapping[str, list[Whitening]],
    rests: Mapping[str, Array],
) -> Booleans:
    """Return whether each of some parts of about one size exceeds the largest limit that the test has for that size."""
    limit = 0.0
    sizes = {n: float(np.linalg.norm(r, axis=1).mean()) for n, r in rests.items()}
    for k, share in product(range(len(KNOWN)), NOISES):
        null = {n: _null(tests, n, k, share, sizes[n])[:, order[n]] for n in rests}
        limit = max(
            limit, float(np.quantile(likelihood_ratio(white, null)[0], 1.0 - ALARM / 2))
        )  # Bonferroni
    return likelihood_ratio(white, {n: r[:, order[n]] for n, r in rests.items()})[0] > limit


def memory_not_covered(tests: ResidualTests, order: Mapping[str, Ints]) -> tuple[str, ...]:
    """Return the memory that the test would not notice, in a sentence; none where it would."""
    scans = _scans(tests)
    if not scans:
        return (
            NOT_TESTED.format(
                why=TOO_MANY_POINTS
                if any(f.n > MOST_FORM_POINTS for f in tests.features.values())
                else TOO_FEW_POINTS
            ),
        )
    n = sum(f.n for f in scans.values())
    if n > MOST_POWER_POINTS:
        return (NOT_COUNTED.format(rho=RHO, most=MOST_POWER_POINTS),)
    chance = power(tests, order)
    return () if chance >= LEAST_POWER else (TOO_FEW.format(rho=RHO, n=n, power=chance, **HELD),)


def _scans(tests: ResidualTests) -> dict[str, FeatureTest]:
    return {n: f for n, f in tests.features.items() if LEAST_SCAN <= f.n <= MOST_FORM_POINTS}


def _noise_with_memory(rng: np.random.Generator, n: int, rho: float) -> Array:
    """Sample noise of size 1 with memory, (PARTS, n)."""
    e = rng.normal(size=(PARTS, n))
    for i in range(1, n):
        e[:, i] = rho * e[:, i - 1] + np.sqrt(1.0 - rho**2) * e[:, i]
    return e


def _null(tests: ResidualTests, name: str, family: int, share: float, size: float) -> Array:
    """Return residuals (draws, n) of parts without memory, as large as those with it: form makes up for the missing noise."""
    f, few = tests.features[name], slice(0, LIMITS)
    shapes = f.rest(tests.shapes(name, KNOWN[family])[few])
    return as_large(share * f.rest(tests.noise[name][few]), shapes, size)
