"""Parts that were measured or cut between the last check that agreed with its prediction and the alarm, and the possible shift of their
characteristics.

    shift = g (m1 - m0),   u^2 = g (P0 + P1) g'

m0, P0: state after the last good check, carried to the day of the alarm; m1, P1: after the alarm's recording; g: characteristic per number of the state
(vcmm.learn.tracking.task_limits). The two states have noise in common, so that u is at most this much. On which day of the interval the machine changed is not known: a part is
shifted by this, or not at all.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Any

import numpy as np

from vcmm.learn.tracking.dates import moment
from vcmm.learn.tracking.follow import FollowedCheck, FollowedMachine, course
from vcmm.learn.tracking.task_limits import CharacteristicGain


@dataclass(frozen=True)
class DatedPart:
    name: str
    date: str


@dataclass(frozen=True)
class CharacteristicShift:
    """name; shift and its standard uncertainty, mm or rad (unit)."""

    name: str
    shift: float
    u: float
    unit: str


@dataclass(frozen=True)
class DoubtfulParts:
    """alarm: date of its recording; since: date of the last good check, None: there was none."""

    alarm: str
    since: str | None
    parts: tuple[DatedPart, ...]
    shifts: tuple[CharacteristicShift, ...]

    def to_dict(self) -> dict[str, Any]:
        return {
            "alarm": self.alarm,
            "since": self.since,
            "parts": [{"part": p.name, "date": p.date} for p in self.parts],
            "shifts": [
                {"characteristic": s.name, "shift": s.shift, "u": s.u, "unit": s.unit} for s in self.shifts
            ],
        }


def doubtful_parts(
    followed: FollowedMachine, parts: Sequence[DatedPart], gains: Sequence[CharacteristicGain]
) -> tuple[DoubtfulParts, ...]:
    """Return the doubtful parts of every alarm, in the order of the dates; parts of the day of the alarm itself are doubtful too."""
    states, out = course(followed), []
    for i, check in enumerate(followed.checks):
        if not check.alarm:
            continue
        good = _last_good(followed.checks, i)
        since = None if good is None else followed.checks[good]
        numbers = [
            p
            for p in parts
            if (since is None or moment(p.date) > since.when) and np.floor(moment(p.date)) <= check.when
        ]
        start = followed.start if good is None else states[good]
        day = check.when - (followed.recordings[0].when if since is None else since.when)
        before, after = followed.motion.step(start, day), states[i]
        shifts = []
        for g in gains:
            spread = np.concatenate([g.gain @ before.factor, g.gain @ after.factor])
            moved = float(g.gain @ (after.mean - before.mean))
            shifts.append(CharacteristicShift(g.name, moved, float(np.sqrt((spread**2).sum())), g.unit))
        out.append(DoubtfulParts(check.date, since.date if since else None, tuple(numbers), tuple(shifts)))
    return tuple(out)


def _last_good(checks: Sequence[FollowedCheck], before: int) -> int | None:
    return next((k for k in range(before - 1, -1, -1) if not checks[k].alarm), None)
