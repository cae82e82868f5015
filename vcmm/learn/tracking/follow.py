"""One recording after another: predict, test, update, and now and then learn the rates anew.

What one recording adds is a function of what was known before it and of itself, so that it does not matter whether recordings come at once or one
by one. Rates are learnt after 3, 4, 6, 8, 12, 16, 24 ... recordings, from all of them; the state is then worked out anew with these rates.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.calibration.result import rms
from vcmm.learn.tracking.alarms import chance_of, level
from vcmm.learn.tracking.changes import Jump, Update, jumps_of, update
from vcmm.learn.tracking.compress import SeenRecording
from vcmm.learn.tracking.kalman import GaussianState
from vcmm.learn.tracking.learn_rates import columns_for, is_due, learn_rates
from vcmm.learn.tracking.quantities import TrackedMachine
from vcmm.learn.tracking.rates import GroupRates, WanderingMotion, first_rates, first_state, motion_of


@dataclass(frozen=True)
class FollowedCheck:
    """Result of a recording when it came. chance, level: of the innovation test; alarm: chance < level.

    rms_predicted, rms_unchanged: rms of its differences from the prediction and from the machine file at the start, both in
    units of the noise. spread: rms of the innovation over its standard uncertainty (near 1 where bands are honest). change:
    probability that something jumped before it; suspects: by name. answer: what `diagnose` said of an alarm.
    """

    name: str
    date: str
    when: float
    rows: int
    rank: int
    noise: float
    outliers: int
    chance: float
    level: float
    rms_predicted: float
    rms_unchanged: float
    spread: float
    change: float
    suspects: tuple[tuple[str, float], ...]
    answer: str = ""

    @property
    def alarm(self) -> bool:
        return self.chance < self.level


@dataclass(frozen=True, eq=False)
class FollowedMachine:
    """Recordings so far, what each said, the state at the last of them, and the rates."""

    tracked: TrackedMachine
    alpha: float
    rates: tuple[GroupRates, ...]
    state: GaussianState
    recordings: tuple[SeenRecording, ...] = ()
    checks: tuple[FollowedCheck, ...] = ()

    @cached_property
    def motion(self) -> WanderingMotion:
        return motion_of(self.tracked.group_of_mode, self.tracked.stated, self.rates)

    @property
    def start(self) -> GaussianState:
        """The state at the date of the machine file, before any recording."""
        return first_state(self.motion)

    @property
    def last(self) -> float | None:
        """Day of the last recording."""
        return self.recordings[-1].when if self.recordings else None

    def at(self, when: float) -> GaussianState:
        """Return the state on a day not before the last recording."""
        return self.motion.step(self.state, 0.0 if self.last is None else when - self.last)

    @cached_property
    def ways(self) -> Array:
        """Matrix (K, n) from the state to all numbers."""
        growth = self.tracked.growth
        return np.concatenate(
            [self.tracked.factor, growth, growth, growth, 0.0 * growth, 0.0 * growth, growth], axis=1
        )


def start_following(tracked: TrackedMachine, alpha: float) -> FollowedMachine:
    """Start before any recording."""
    rates = first_rates(tracked)
    motion = motion_of(tracked.group_of_mode, tracked.stated, rates)
    return FollowedMachine(tracked, alpha, rates, first_state(motion))


def follow_one(before: FollowedMachine, recording: SeenRecording, date: str) -> FollowedMachine:
    """Return the state after one more recording; its FollowedCheck is the last of `checks`."""
    jumps = jumps_of(before.tracked)
    columns = columns_for(recording, before.tracked.stated)
    state = before.at(recording.when)
    number = len(before.recordings) + 1
    chance, spread = chance_of(state, columns, recording.value, jumps)
    days = 0.0 if before.last is None else recording.when - before.last
    new = update(state, columns, recording.value, jumps, days)
    check = _check(recording, date, (chance, level(number, before.alpha), spread), state, columns, new)
    out = replace(
        before, state=new.state, recordings=(*before.recordings, recording), checks=(*before.checks, check)
    )
    if not is_due(number):
        return out
    rates = learn_rates(out.tracked, out.recordings, jumps, out.rates)
    return again(replace(out, rates=rates), jumps)


def _check(
    recording: SeenRecording,
    date: str,
    test: tuple[float, float, float],
    state: GaussianState,
    columns: Array,
    new: Update,
) -> FollowedCheck:
    from_state = recording.value - columns @ state.mean
    return FollowedCheck(
        recording.name, date, recording.when, recording.rows, recording.rank, recording.noise, recording.outliers, test[0], test[1],
        rms(from_state), rms(recording.value), test[2], new.probability, new.suspects,
    )  # fmt: skip


def again(followed: FollowedMachine, jumps: Sequence[Jump]) -> FollowedMachine:
    """The state worked out from the start with the present rates; what the checks said when they came stays."""
    motion, stated = followed.motion, followed.tracked.stated
    state, before = first_state(motion), None
    for recording in followed.recordings:
        days = 0.0 if before is None else recording.when - before
        new = update(motion.step(state, days), columns_for(recording, stated), recording.value, jumps, days)
        state, before = new.state, recording.when
    return replace(followed, state=state)


def course(followed: FollowedMachine) -> list[GaussianState]:
    """The state after every recording, with the present rates."""
    out, motion, stated, before = [], followed.motion, followed.tracked.stated, None
    state, jumps = first_state(motion), jumps_of(followed.tracked)
    for recording in followed.recordings:
        days = 0.0 if before is None else recording.when - before
        state = update(
            motion.step(state, days), columns_for(recording, stated), recording.value, jumps, days
        ).state
        out.append(state)
        before = recording.when
    return out
