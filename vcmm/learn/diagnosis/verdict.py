"""The verdict, and the reasons why it is not "explained".

A name explains a recording only if its residual is the stated scatter. Two properties of the noise contradict
that however well the name fits: a scatter several times what was stated (the audit had to inflate the noise, so the test
of the residual is blunt), and neighbours so similar that the rest is a movement and no scatter (an AR(1) filter whitens a
slow shape as readily as noise).
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.learn.diagnosis.constants import (
    FALSE_ALARM,
    LEAST_PRINTED,
    STRUCTURE_CORRELATION,
    UNSTATED_RATIO,
)
from vcmm.learn.diagnosis.holdout import is_free_curve
from vcmm.learn.diagnosis.locate import Place
from vcmm.learn.diagnosis.noise import Audit
from vcmm.learn.diagnosis.result import Answer, Unknown


def reasons_against(
    named: bool, rest: Unknown | None, refused: bool, excess: str, noise: Audit, left: float
) -> tuple[str, ...]:
    """Return why the names are not the whole story; empty where they are.

    left: noise after over noise stated; refused: a name did not hold; excess: the finding about the scatter, or "".
    """
    out = []
    if rest is not None:
        out.append(f"something without a name is left: {rest.description}")
    if refused:
        out.append(
            "a name was taken back: it does not predict rows that were not fitted, or a shape without physics explains more"
        )
    if excess:
        out.append(excess)
    scatter = max(left, noise.scale)
    if named and scatter > UNSTATED_RATIO:
        out.append(
            f"the names leave {scatter:.2g} times the noise that was stated: either the noise is stated wrongly, or physics"
            " is hidden in it"
        )
    if named and noise.rho >= STRUCTURE_CORRELATION:
        out.append(
            f"what the names leave is no scatter: each observation tells {noise.rho**2:.0%} of the next one"
            f" (correlation {noise.rho:.2f})"
        )
    return tuple(out)


def unstated_scatter(noise: Audit, left: float, forgiven: float = 0.0) -> str:
    """Return why the scatter is not the stated one, for any tails and correlation; "" where it may be.

    left: the same by rms, which outliers raise and a filter for correlation blurs; forgiven: what the errors of strong
    templates may add, as (scale over stated)^2.
    """
    if noise.scale <= float(np.hypot(noise.limit, np.sqrt(forgiven))):
        return ""
    larger = noise.rho == 0 and left > noise.scale and f"{left:.2g}" != f"{noise.scale:.2g}"
    rms = f" ({left:.2g} times by rms)" if larger else ""
    return (
        f"the noise is {noise.scale:.2g} times what was stated{rms}: either the statement is too small or something is"
        " missing that no column shows"
    )


def shared_curve_remarks(answers: Sequence[Answer]) -> tuple[str, ...]:
    """Return the components that two free curves share: together they are a shape, and neither says why it is so."""
    places = [a.where.get("component", "") for a in answers if is_free_curve(a.effect)]
    shared = dict.fromkeys(p for p in places if places.count(p) > 1)
    return tuple(
        f"two free curves over {p} follow a shape that neither of them has: it is placed and measured, and not explained"
        for p in shared
    )


def describe_probability(probability: float) -> str:
    """Return a probability in words: below one in a thousand no template is known well enough for digits."""
    return f"{probability:.2g}" if probability >= LEAST_PRINTED else f"below {LEAST_PRINTED:g}"


def doubt_remarks(answers: Sequence[Answer]) -> tuple[str, ...]:
    """Return why answers are no findings and not written: names less probable than not, sizes that may be anything, rows that they
    predict worse than no terms do.
    """
    out = []
    for a in answers:
        name = " ".join((a.effect.replace("_", " "), *a.where.values()))
        if a.withheld_because:
            out.append(f"{name} is not written: {a.withheld_because}")
        elif a.impossible_because:
            out.append(f"{name} is a candidate and no finding: {a.impossible_because}")
        elif a.is_undetermined:
            out.append(
                f"{name} is a candidate and no finding: its size is not known to better than half of itself, or spans orders of"
                " magnitude"
            )
        elif a.improbable:
            out.append(
                f"{name} is a candidate and no finding: its probability is {describe_probability(a.probability)}"
            )
    return tuple(out)


def clear_places(places: Sequence[Place], named: bool) -> tuple[tuple[Place, ...], tuple[str, ...]]:
    """Return, where nothing has a name, the places that are surer than the false alarms allow, and what they contradict."""
    if named:
        return tuple(places), ()
    sure = tuple(p for p in places if p.p <= FALSE_ALARM)
    return sure, (f"{sure[0].text}, and nothing in the catalogue does so",) if sure else ()


def verdict(named: bool, against: tuple[str, ...]) -> str:
    """Return one of VERDICTS; `against`: the reasons why the names are not the whole story."""
    if not against:
        return "explained" if named else "nothing missing"
    return "partly explained" if named else "unexplained"
