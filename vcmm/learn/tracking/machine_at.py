"""The state of a machine on a day: values, their uncertainty after the recordings, and the addition by time since.

    theta(day) = theta of the file + F z + G (b + w)
    covariance = remainder of the errors at the last check  +  addition by time since

The first is the part of the covariance of that day that goes with the errors of the day of the last check (regression on them); the second is the rest: walks
and swings since, and what the recordings leave open of trends and seasons. The two parts are independent: the first is one Input of all numbers, the second another with the cause "time since calibration", so that
every budget has a line for it.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.effect import Effect, with_parameter
from vcmm.core.inputs import SINCE, STATE, Input, JointCovariance
from vcmm.core.laws import MultivariateNormal, Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.tracking.follow import FollowedMachine
from vcmm.learn.tracking.quantities import TrackedQuantity
from vcmm.physics.structure.component import CalibrationModes

KNOWN = 1e-6  # of the largest: errors below it at the last check say nothing of later ones


@dataclass(frozen=True, eq=False)
class DatedMachine:
    """departure (K,) of all numbers from the machine file on a day; state, since (K, c): factors of the two covariances."""

    history: FollowedMachine
    when: float
    departure: Array
    state: Array
    since: Array

    @property
    def u(self) -> Array:
        """Standard uncertainties on the day (K,)."""
        return np.sqrt((self.state**2).sum(axis=1) + (self.since**2).sum(axis=1))

    @property
    def uncertain(self) -> tuple[TrackedQuantity, ...]:
        """Quantities that are not exactly known."""
        rows, u = self.history.tracked.rows, self.u
        return tuple(q for q in self.history.tracked.quantities if (u[rows[q.id]] > 0).any())

    def joint(self, factor: Array) -> JointCovariance:
        """Return the covariance factor @ factor.T of the uncertain quantities as a file has it."""
        rows = self.history.tracked.rows
        numbers = np.concatenate([np.arange(rows[q.id].start, rows[q.id].stop) for q in self.uncertain])
        names = tuple(q.id for q in self.uncertain for _ in range(q.size))
        position = [np.full(1, np.nan) if is_single(q) else np.arange(float(q.size)) for q in self.uncertain]
        own_factor = factor[numbers]
        return JointCovariance(names, np.concatenate(position), own_factor @ own_factor.T)


def is_single(quantity: TrackedQuantity) -> bool:
    """Return whether a quantity is one number, and no array of one."""
    return np.ndim(getattr(quantity.effect, quantity.parameter)) == 0


def machine_on(followed: FollowedMachine, when: float) -> DatedMachine:
    """Return the machine on a day not before the last recording; `when` in days."""
    days = 0.0 if followed.last is None else when - followed.last
    motion, ways, now = followed.motion, followed.ways, followed.state
    carried = ways @ motion.carry(now.factor, days)
    basis = _row_space(ways @ now.factor)
    fresh = ways * np.sqrt(motion.fresh(days))
    since = np.concatenate([carried - (carried @ basis.T) @ basis, fresh], axis=1) if days > 0 else fresh
    return DatedMachine(
        followed, when, ways @ motion.carry(now.mean, days), (carried @ basis.T) @ basis, since
    )


def _row_space(factor: Array) -> Array:
    """Return orthonormal rows (r, c), the directions of the draws on which numbers of usual size depend."""
    scale = np.maximum(np.sqrt((factor**2).sum(axis=1, keepdims=True)), 1e-300)
    _, size, rows = np.linalg.svd(factor / scale, full_matrices=False)
    return np.asarray(rows[size > KNOWN * max(float(size[0]) if len(size) else 0.0, 1e-300)])


def effects_on(dated: DatedMachine) -> tuple[Effect, ...]:
    """Return the machine's effects with their numbers of the day, without the modes of an earlier covariance."""
    rows = dated.history.tracked.rows
    new: dict[str, Effect] = {}
    for q in dated.history.tracked.quantities:
        old = np.asarray(getattr(q.effect, q.parameter), dtype=float)
        value = old + np.reshape(dated.departure[rows[q.id]], old.shape)
        effect = new.get(q.effect.id, q.effect)
        new[q.effect.id] = with_parameter(effect, q.parameter, float(value) if value.ndim == 0 else value)
    effects = dated.history.tracked.machine.effects
    return tuple(new.get(e.id, e) for e in effects if not isinstance(e, CalibrationModes))


def as_machine(dated: DatedMachine) -> Machine:
    """Return the result of `load_machine` on the files, to rounding; before any recording the machine file itself."""
    tracked = dated.history.tracked
    if not dated.history.recordings:
        return tracked.machine
    kept = [i for i in tracked.machine.inputs if i.id not in tracked.input_ids]
    inputs = [_joint(dated.uncertain, dated.joint(dated.state).matrix, "")] if dated.uncertain else []
    if dated.uncertain and dated.since.any():
        inputs.append(_joint(dated.uncertain, dated.joint(dated.since).matrix, SINCE))
    return replace(tracked.machine, effects=effects_on(dated), inputs=(*kept, *inputs))


def _joint(quantities: Sequence[TrackedQuantity], matrix: Array, cause: str) -> Input:
    members = tuple(
        Input(q.effect.name, q.effect.where, q.parameter, Normal(1.0), cause=cause) for q in quantities
    )
    widths = tuple(q.size for q in quantities)
    law = MultivariateNormal(matrix)
    return Input(
        "", "", STATE, law, "machine", "followed in time", members=members, cause=cause, widths=widths
    )
