"""Physics without a name that who made the recording has found already: it stands among what is known to be uncertain.

A part that comes back measured is searched for waves in time down to two points per period, along all directions at once, which is
beyond the shapes that are searched here. What is found so goes along as a covariance called "unknown ...", so that no name takes
its place, and the verdict has to say it.
"""

from __future__ import annotations

import re
from dataclasses import replace

import numpy as np

from vcmm.learn.diagnosis.result import Diagnosis, NextStep, Unknown
from vcmm.learn.diagnosis.verdict import verdict
from vcmm.task.response.recording import UNKNOWN, Recording

WAVES = 10  # that are watched: their period is known to a hundredth then


def describe_unknown(found: Diagnosis, recording: Recording) -> Diagnosis:
    """The same with the unknown of the recording told: verdict, reason, what to measure next."""
    told = [(name.removeprefix(UNKNOWN), k) for name, k in recording.known if name.startswith(UNKNOWN)]
    if not told:
        return found
    rests = [
        Unknown(("time",), f"a {what}, which no effect of the catalogue does", _rms(k), drawn=False)
        for what, k in told
    ]
    why = tuple(f"something without a name is in the recording: {rest.description}" for rest in rests)
    steps = tuple(step for what, _ in told if (step := _watch(what)) is not None)
    return replace(
        found,
        verdict=verdict(bool(found.found), (*found.reasons, *why)),
        reasons=(*found.reasons, *why),
        unknown=found.unknown or rests[0],
        next_measurement=(*steps, *found.next_measurement),
    )


def _rms(columns: np.ndarray) -> float:
    """Of the shape that columns (m, r) are scaled to."""
    return float(np.sqrt(np.mean(columns**2)))


def _watch(what: str) -> NextStep | None:
    """How to see a wave of time by itself: nothing moves, so what swings is no axis and no cutting."""
    match = re.search(r"wave of ([\d.e+]+) s", what)
    if match is None:
        return None
    period = float(match[1])
    do = (
        f"Leave the axes standing with the spindle, pumps and cooling switched on as in the cut, and log an indicator from the spindle to the "
        f"table in X, Y and Z for {WAVES * period:.3g} s, at least every {period / 10:.2g} s: what swings with {period:.3g} s comes from beside the "
        "axes; switch the units off one by one. If nothing swings, it comes with the motion: log the axes' actual positions over the same program."
    )
    return NextStep((what,), do, 3 * WAVES * period / 60.0, 0.0)
