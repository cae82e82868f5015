"""Design the poses of a touch probe: rotary positions to touch at, and the information that they give.

Every pose gives information on the errors, the own errors of the probe and the unknowns of the spheres, all at once:

    A = sum over poses of X' W X        X = [errors behind their prior | own errors, unit variance | nuisance]

so places and sizes of the spheres, which all poses share, are marginalised after the sum (Schur complement), not pose by pose. Chosen
are the poses that leave the smallest root mean variance of the tip error over the volume (as `design`), one added at a time and
then swapped while that pays: no proof of the best. Source: Fedorov, Theory of Optimal Experiments (1972), exchange; the criterion
is that of I-optimality.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.calibration.design import NODES, PlannedSetup, volume_field
from vcmm.learn.calibration.evidence import NormalEquations
from vcmm.learn.calibration.identifiability import Identifiability, identify, is_angle
from vcmm.learn.calibration.job import ranges_of, spans_of
from vcmm.learn.calibration.model import ErrorModel, error_model
from vcmm.learn.calibration.prior import prior, scale_factor, usual
from vcmm.learn.calibration.readings import Readings, readings
from vcmm.learn.calibration.solve import Before, columns_of
from vcmm.learn.calibration.touching import touched_errors
from vcmm.task.instruments.touch_probe import TOUCH_PROBE
from vcmm.task.response.recording import Ints

FREE = 1.0  # mm: standard uncertainty of what is free, large beside every reading
ENOUGH_VOLUME_RATIO = (
    1.05  # of the volume of all poses: the fewest poses that come so near, where no budget is stated
)
TOLD = 1e-3  # information of all poses over that of the prior, from which a combination of errors counts as determined
PAYS = 1e-3  # of the volume: a swap that gains less ends the search


@dataclass(frozen=True, eq=False)
class PoseCandidate:
    """One rotary position of one set-up: its angles (rad), its duration (minutes), its touches."""

    setup: str
    angles: dict[str, float]
    minutes: float
    touches: int


@dataclass(frozen=True, eq=False)
class PosePlan:
    """grams (k, p, p): information of each pose on errors, own errors and nuisance; factor (size, r) of the prior of the errors."""

    model: ErrorModel
    candidates: tuple[PoseCandidate, ...]
    grams: Array
    instrument_size: int
    factor: Array
    field: Array

    @cached_property
    def behind(self) -> Array:
        """The same information on the numbers behind the prior, (k, p', p')."""
        size = self.model.size
        lift = np.zeros((self.grams.shape[1], self.factor.shape[1] + self.grams.shape[1] - size))
        lift[:size, : self.factor.shape[1]] = self.factor
        lift[size:, self.factor.shape[1] :] = np.eye(self.grams.shape[1] - size)
        return np.asarray(lift.T @ self.grams @ lift)

    @cached_property
    def weight(self) -> Array:
        """Mean square of the tip error over the volume per unit variance of the numbers; without the part that even all poses leave
        undetermined."""
        visible = self.field @ self.factor @ self.seen_part
        return np.asarray(visible.T @ visible / (len(visible) / 3))

    @cached_property
    def seen_part(self) -> Array:
        """Projection (r, r) on the part of the numbers behind the prior that the touches of all poses determine. The rest is as unknown
        after any choice, and large: it
        would hide the effect of the choice.
        """
        values, vectors = np.linalg.eigh(
            self.factor.T @ self._information(range(len(self.candidates))) @ self.factor
        )
        basis = vectors[:, values > TOLD]
        return np.asarray(basis @ basis.T)

    def covariance(self, chosen: Sequence[int]) -> Array:
        """Return the covariance (r, r) of the numbers behind the prior, after the poses."""
        r = self.factor.shape[1]
        precision = np.full(self.behind.shape[1], 1.0 / FREE**2)
        precision[: r + self.instrument_size] = 1.0
        full = np.diag(precision) + self.behind[list(chosen)].sum(axis=0)
        return np.asarray(np.linalg.inv(full)[:r, :r])

    def volume(self, chosen: Sequence[int]) -> float:
        """Return the root mean variance of the tip error over the volume, mm, of the part that all poses together determine."""
        return float(np.sqrt((self.covariance(chosen) * self.weight).sum()))

    def minutes(self, chosen: Sequence[int]) -> float:
        return float(sum(self.candidates[i].minutes for i in chosen))

    def expected_covariance(self, chosen: Sequence[int]) -> Array:
        """Return the covariance (size, size) of the errors, mm and rad."""
        return np.asarray(self.factor @ self.covariance(chosen) @ self.factor.T)

    def uncertainties(self, chosen: Sequence[int]) -> dict[str, float]:
        """Name -> standard uncertainty, mm or rad; of a curve the rms over its travel."""
        return self._by_name(np.diag(self.expected_covariance(chosen)))

    def before(self) -> dict[str, float]:
        """Name -> standard uncertainty before any touch, mm or rad: the prior of vcmm.learn.calibration.prior; of a curve the rms over its travel."""
        return self._by_name((self.factor**2).sum(axis=1))

    def _by_name(self, variance: Array) -> dict[str, float]:
        return {name: float(np.sqrt(variance[self.model.slices[name]].mean())) for name in self.model.names}

    def correlated_pairs(self, chosen: Sequence[int]) -> list[tuple[str, str, float]]:
        """Return the pairs of location errors whose correlation is larger than 0.9, largest first."""
        names = self.model.pairs
        rows = [self.model.slices[n].start for n in names]
        full = self.expected_covariance(chosen)[np.ix_(rows, rows)]
        u = np.sqrt(np.diag(full))
        pairs = [
            (names[i], names[j], float(full[i, j] / (u[i] * u[j])))
            for i in range(len(names))
            for j in range(i)
            if u[i] * u[j] > 0
        ]
        return sorted((p for p in pairs if abs(p[2]) > 0.9), key=lambda p: -abs(p[2]))

    def identifiability(self, chosen: Sequence[int]) -> Identifiability:
        """Return the errors that the poses identify, judged against next to no earlier knowledge; own errors have their u."""
        return identify(NormalEquations(self._information(chosen), np.zeros(self.model.size), self.model))

    def _information(self, chosen: Sequence[int]) -> Array:
        """Return the information of the poses on the errors, places and sizes of the spheres free, as (size, size)."""
        size, own_size = self.model.size, self.instrument_size
        full = self.grams[list(chosen)].sum(axis=0)
        inner = full[size:, size:].copy()
        inner[:own_size, :own_size] += np.eye(own_size)
        rest = np.linalg.pinv(inner, rcond=1e-10, hermitian=True)
        a = full[:size, :size] - full[:size, size:] @ rest @ full[size:, :size]
        return np.asarray((a + a.T) / 2)


def is_pose_design(setups: Sequence[PlannedSetup]) -> bool:
    """Return whether all set-ups of a plan touch with a probe in the spindle."""
    used = [s.certificate for s in setups]
    return bool(used) and all(c is not None and c.instrument.name == TOUCH_PROBE.name for c in used)


def pose_plan(setups: Sequence[PlannedSetup], machine: Machine) -> PosePlan:
    """Return the information of every rotary position of every set-up. Raises UsageError where nothing turns."""
    ranges = ranges_of(spans_of([r for s in setups for r in s.recordings]), machine)
    if not any(is_rotary(a) for a in ranges):
        raise UsageError(
            "no rotary axis turns in the set-ups; a design of poses chooses rotary positions: add rotary = { C = [...] }"
        )
    model = error_model(ranges, NODES, touched_errors(ranges))
    parts = [(s, readings(r, machine, model, s.certificate)) for s in setups for r in s.recordings]
    columns, names = columns_of([p for _, p in parts], Before.nothing(model))
    widths = [p.nuisance.shape[1] for _, p in parts]
    starts = np.cumsum([columns[0].shape[1], *widths])
    grams, candidates = [], []
    for (setup, part), columns_of_part, start, width in zip(parts, columns, starts, widths):
        full = np.zeros((part.m, int(starts[-1])))
        full[:, : columns_of_part.shape[1]] = columns_of_part
        full[:, start : start + width] = part.nuisance
        for pose, rows in _by_pose(setup, part):
            x = full[rows] / part.u[rows, None]
            grams.append(x.T @ x)
            candidates.append(pose)
    lengths = {c.component: 0.35 * c.travel for c in model.curves}
    factor = scale_factor(prior(model, lengths), usual(model))
    return PosePlan(
        model, tuple(candidates), np.array(grams), len(names), factor, volume_field(model, machine)
    )


def _by_pose(setup: PlannedSetup, part: Readings) -> list[tuple[PoseCandidate, Ints]]:
    """Return every rotary position of a set-up, and which of its readings belong to it."""
    recording = part.recording
    values, codes = recording.groups("pose")
    out = []
    for code in range(len(values)):
        rows = np.flatnonzero(codes == code)
        run, first = recording.run, int(recording.row[rows[0]])
        angles = {a: float(q[first]) for a, q in run.position.items() if is_rotary(a)}
        out.append((PoseCandidate(setup.name, angles, setup.minutes / len(values), len(rows)), rows))
    return out


def best_poses(plan: PosePlan, budget: float | None) -> list[int]:
    """Return the numbers of the poses within the budget (minutes); without one the fewest that come near the information of all.

    Raises UsageError where the budget is too short for a single pose.
    """
    everything = range(len(plan.candidates))
    aim = 0.0 if budget is not None else ENOUGH_VOLUME_RATIO * plan.volume(everything)
    chosen: list[int] = []
    while len(chosen) < len(plan.candidates):
        left = np.inf if budget is None else budget + 1e-9 - plan.minutes(chosen)
        free = [i for i in everything if i not in chosen and plan.candidates[i].minutes <= left]
        if not free or (chosen and plan.volume(chosen) <= aim):
            break
        chosen = [*chosen, min(free, key=lambda i: plan.volume([*chosen, i]))]
    if not chosen:
        least = min(c.minutes for c in plan.candidates)
        raise UsageError(f"the budget of {budget:g} min is too short for one pose, which takes {least:g} min")
    return _swap_poses(plan, chosen, budget)


def _swap_poses(plan: PosePlan, chosen: list[int], budget: float | None) -> list[int]:
    """Swap one pose for another while the volume gains."""
    now = plan.volume(chosen)
    while True:
        swaps = [
            [*(j for j in chosen if j != out), new]
            for out in chosen
            for new in range(len(plan.candidates))
            if new not in chosen
        ]
        swaps = [s for s in swaps if budget is None or plan.minutes(s) <= budget + 1e-9]
        if not swaps:
            return sorted(chosen)
        best = min(swaps, key=plan.volume)
        value = plan.volume(best)
        if value >= now * (1 - PAYS):
            return sorted(chosen)
        chosen, now = best, value


def unit_of(name: str) -> tuple[str, float]:
    """Return the unit of an error as it is printed, and how many are in 1 mm or 1 rad."""
    return ("urad", 1e6) if is_angle(name) else ("um", 1e3)
