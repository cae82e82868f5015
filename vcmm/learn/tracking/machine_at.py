"""The machine as it is known on a day: values, what the recordings leave of their uncertainty, and what time has added since.

    theta(day) = theta of the file + F z + G (b + w)
    covariance = that of the state at the last check, carried on  +  what walks and swings have brought in since

The two parts are independent: the first is one Input of all numbers, the second another with the cause "time since calibration", so that
every budget has a line for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.effect import Effect, with_parameter
from vcmm.core.inputs import Input
from vcmm.core.laws import MultivariateNormal, Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.files.own.joint_covariance import JointCovariance
from vcmm.files.own.tracked import SINCE, STATE
from vcmm.learn.tracking.follow import FollowedMachine
from vcmm.learn.tracking.kalman import GaussianState
from vcmm.learn.tracking.quantities import TrackedQuantity
from vcmm.learn.tracking.rates import YEAR
from vcmm.physics.structure.component import CalibrationModes


@dataclass(frozen=True, eq=False)
class DatedMachine:
    """departure (K,) of all numbers from the machine file on a day; state, since (K, c): factors of the two covariances."""

    followed: FollowedMachine
    when: float
    departure: Array
    state: Array
    since: Array

    @property
    def u(self) -> Array:
        """(K,) standard uncertainties on the day."""
        return np.sqrt((self.state**2).sum(axis=1) + (self.since**2).sum(axis=1))

    @property
    def uncertain(self) -> tuple[TrackedQuantity, ...]:
        """Those of which something is not known."""
        rows, u = self.followed.tracked.rows, self.u
        return tuple(q for q in self.followed.tracked.quantities if (u[rows[q.id]] > 0).any())

    def joint(self, factor: Array) -> JointCovariance:
        """The covariance factor @ factor.T of the uncertain quantities as a file has it."""
        rows = self.followed.tracked.rows
        numbers = np.concatenate([np.arange(rows[q.id].start, rows[q.id].stop) for q in self.uncertain])
        names = tuple(q.id for q in self.uncertain for _ in range(q.size))
        position = [np.full(1, np.nan) if is_single(q) else np.arange(float(q.size)) for q in self.uncertain]
        own = factor[numbers]
        return JointCovariance(names, np.concatenate(position), own @ own.T)


def is_single(quantity: TrackedQuantity) -> bool:
    """One number, and no array of one."""
    return np.ndim(getattr(quantity.effect, quantity.parameter)) == 0


def machine_on(followed: FollowedMachine, when: float) -> DatedMachine:
    """On a day not before the last recording; `when` in days."""
    last = followed.last
    days = 0.0 if last is None else when - last
    motion = followed.motion
    decay = np.where(motion.swing > 0, np.exp(-days / motion.tau), 1.0)
    variance = motion.walk**2 * days / YEAR + motion.swing**2 * (1.0 - decay**2)
    kept = GaussianState(decay * followed.state.mean, decay[:, None] * followed.state.factor)
    departure, state = followed.theta(kept)
    return DatedMachine(followed, when, departure, state, followed.ways * np.sqrt(variance))


def effects_on(dated: DatedMachine) -> tuple[Effect, ...]:
    """The machine's effects with their numbers of the day, without the modes of an earlier covariance."""
    rows = dated.followed.tracked.rows
    new: dict[str, Effect] = {}
    for q in dated.followed.tracked.quantities:
        old = np.asarray(getattr(q.effect, q.parameter), dtype=float)
        value = old + np.reshape(dated.departure[rows[q.id]], old.shape)
        effect = new.get(q.effect.id, q.effect)
        new[q.effect.id] = with_parameter(effect, q.parameter, float(value) if value.ndim == 0 else value)
    effects = dated.followed.tracked.machine.effects
    return tuple(new.get(e.id, e) for e in effects if not isinstance(e, CalibrationModes))


def as_machine(dated: DatedMachine) -> Machine:
    """What `load_machine` reads of the files, to rounding."""
    tracked = dated.followed.tracked
    kept = [i for i in tracked.machine.inputs if i.id not in tracked.used]
    own = [_joint(dated.uncertain, dated.joint(dated.state).matrix, "")] if dated.uncertain else []
    if dated.uncertain and dated.since.any():
        own.append(_joint(dated.uncertain, dated.joint(dated.since).matrix, SINCE))
    return replace(tracked.machine, effects=effects_on(dated), inputs=(*kept, *own))


def _joint(quantities: Sequence[TrackedQuantity], matrix: Array, cause: str) -> Input:
    members = tuple(
        Input(q.effect.name, q.effect.where, q.parameter, Normal(1.0), cause=cause) for q in quantities
    )
    widths = tuple(q.size for q in quantities)
    law = MultivariateNormal(matrix)
    return Input(
        "", "", STATE, law, "machine", "followed in time", members=members, cause=cause, widths=widths
    )
