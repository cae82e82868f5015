"""The verdict, and in words why it is not "explained".

A name explains a recording only if what it leaves is the scatter that was stated. Two things in the noise speak against
that however well the name fits: a scatter several times what was stated (the audit had to inflate the noise, so the test
of what is left is blunt), and neighbours so alike that the rest is a movement and no scatter (an AR(1) filter whitens a
slow shape as readily as noise).
"""

from __future__ import annotations

from vcmm.diagnosis.noise import Audit
from vcmm.diagnosis.result import Unknown

UNSTATED = 3.0  # times the stated noise: from there a named cause is not the whole story
STRUCTURED = 0.9  # correlation of neighbours, from which each observation tells 0.9^2 = 81 % of the next one's variance


def reasons(
    named: bool, rest: Unknown | None, refused: bool, excess: str, noise: Audit, left: float
) -> tuple[str, ...]:
    """Why the names are not the whole story; empty where they are.

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
    if named and scatter > UNSTATED:
        out.append(
            f"the names leave {scatter:.2g} times the noise that was stated: either the noise is stated wrongly, or physics"
            " is hidden in it"
        )
    if named and noise.rho >= STRUCTURED:
        out.append(
            f"what the names leave is no scatter: each observation tells {noise.rho**2:.0%} of the next one"
            f" (correlation {noise.rho:.2f})"
        )
    return tuple(out)


def verdict(named: bool, against: tuple[str, ...]) -> str:
    """One of VERDICTS; `against`: the reasons why the names are not the whole story."""
    if not against:
        return "explained" if named else "nothing missing"
    return "partly explained" if named else "unexplained"
