"""The prior of a mechanism that no catalogue holds.

Such a mechanism can do whatever the best name does, so the rows cannot tell it from that name, however many nats the name has: its odds
against the name are a constant w, and a probability p becomes p / (1 + w).

w is the ratio of wrong to right claims of the exam, each plus one: OUTSIDE where the account closes; OUTSIDE_OPEN where something is left that
the catalogue does not hold, for then there is such a mechanism, and what was told may be its work as well as that of the name. Either was
fitted on each half of the cases and tested on the other (docs/exam.md).
It is a statement about the name. What is a finding stays one, and is written: it predicted rows held out, whatever it is called.
"""

from __future__ import annotations

from dataclasses import replace

from vcmm.learn.diagnosis.constants import OUTSIDE, OUTSIDE_OPEN
from vcmm.learn.diagnosis.result import VERDICTS, Answer, Diagnosis

CLOSED = VERDICTS[:2]  # nothing missing, explained


def with_outside(d: Diagnosis) -> Diagnosis:
    """The diagnosis with what a mechanism outside the catalogue leaves to its names."""
    share = 1.0 / (1.0 + (OUTSIDE if d.verdict in CLOSED else OUTSIDE_OPEN))
    return replace(d, answer=tuple(_left(a, share) for a in d.answer))


def _left(a: Answer, share: float) -> Answer:
    return replace(
        a,
        probability=a.probability * share,
        rival_probability=a.rival_probability * share,
        alias_probability=a.alias_probability * share,
        kin=None if a.kin is None else a.kin.times(share),
        stands=not a.improbable,
    )
