"""Carrier: carry the error motion of an effect to the tip and project it on a direction. All columns of G are computed here.

    seen = s d . t + r d . g        t translation of the tip (of a sight that turns: its rotation w), g reading

s = -1 and r = +1 give indicated - true along d; observations of a recording have their own s and r (see
`vcmm.task.response.observe`). First order is linear in the six numbers of a link, so that its way to the sight is worked out
once, as the transpose of `tip_motion`; thousands of effects then cost one small product each.

Uncertainty looks along x, y and z of every row, a placement along the normal of every touch, a diagnosis along the
sensitive direction of both ends of every observation: all three ask a Carrier.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np
import numpy.typing as npt

from vcmm.core.effect import Effect, basis, parameter, projected_basis, required, with_parameter
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.inputs import Input
from vcmm.core.kinematics import LinkFrames, link_frames, sensitivity, turn_sensitivity
from vcmm.core.knowledge import acted_on
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run, Series

Ints = npt.NDArray[np.intp]
STEP = {"_C": 0.5, "_mm": 1e-3, "_rad": 1e-5}  # for run columns, by the unit in their name; others 1e-3


@dataclass(frozen=True, eq=False)
class Sight:
    """The sensitive directions: direction (m, 3) in workpiece axes, one per observation; zero where nothing is seen.

    rows (m,): the row of the run of each observation, None = row by row. motion, reading: the signs s and r of the
    docstring of this module. turning: rotations of the tip (rad) are seen, not translations (mm).
    """

    direction: Array
    rows: Ints | None = None
    motion: float = -1.0
    reading: float = 1.0
    turning: bool = False
    cut_sign: float = (
        1.0  # sign besides of readings that a finished part shows the other way (Effect.about.on_cut_part)
    )

    def of_rows(self, values: Array) -> Array:
        """Return values of the rows of the run (n, ...), one per observation (m, ...)."""
        return values if self.rows is None else values[self.rows]

    def of(self, motion: Array, reading: Array) -> Array:
        """Return observations (m, k) from tip motions (n, 6, k) mm and rad, and readings (n, 3, k) mm, of all rows of the run."""
        moved = motion[:, 3:] if self.turning else motion[:, :3]
        return np.einsum(
            "mi,mik->mk", self.direction, self.of_rows(self.motion * moved + self.reading * reading)
        )


@dataclass(eq=False)
class Carrier:
    """Effects of a machine seen along a sight. run: prepared by the machine."""

    machine: Machine
    run: Run
    sight: Sight

    def __post_init__(self) -> None:
        self._ways: dict[tuple[str, str], Array] = {}
        self._runs_apart: dict[str, tuple[Run, Run, float]] = {}

    @cached_property
    def _where(self) -> tuple[Run, LinkFrames]:
        """Run of the axis positions at each observation, and the frames of the links there."""
        position = {a: self.sight.of_rows(q) for a, q in self.run.position.items()}
        run = Run(position, self.sight.of_rows(self.run.offset))
        return run, link_frames(self.machine.chain, self.machine.axes, run)

    def along(self, direction: Array) -> Carrier:
        """Return the carrier for the same machine and run along another direction (m, 3); the frames of the links are shared."""
        other = Carrier(self.machine, self.run, replace(self.sight, direction=direction))
        other.__dict__["_where"] = self._where
        return other

    def weights(self, effect: Effect) -> Array:
        """Return the observed value per unit of each of the six numbers of the effect's link (m, 6)."""
        key = (effect.link, "" if effect.link == "reading" else effect.place)
        if key not in self._ways:
            self._ways[key] = self._way(key)
        turned = (
            self.sight.cut_sign if effect.link == "reading" and effect.about.on_cut_part == "turned" else 1.0
        )
        factor = turned * self.machine.sign(effect)
        return self._ways[key] if factor == 1.0 else factor * self._ways[key]

    def _way(self, link: tuple[str, str]) -> Array:
        sight = self.sight
        if link[0] == "reading":
            return np.concatenate([sight.reading * sight.direction, np.zeros_like(sight.direction)], axis=1)
        run, frames = self._where
        along = turn_sensitivity if sight.turning else sensitivity
        return sight.motion * along(frames, self.machine.axes, run, link, sight.direction)

    def through(self, effect: Effect, six: Array) -> Array:
        """Return observations (m,) or (m, k) from error motions (n, 6) or (n, 6, k) of the effect's link."""
        return np.einsum("mj,mj...->m...", self.weights(effect), self.sight.of_rows(six))

    def parameter(self, effect: Effect, name: str, run: Run | None = None) -> Array:
        """Return the columns (m, k) per unit of each element of a parameter of an effect. run: another run of the same rows."""
        run = self.run if run is None else run
        if self.sight.rows is None:
            return projected_basis(effect, name, run, self.weights(effect))
        return self.through(effect, basis(effect, name, run))

    def of_input(self, quantity: Input, effects: Sequence[Effect]) -> Array:
        """Return the columns (m, k) per unit of each element of an Input, through the effects on which it acts (a column: those that read it)."""
        if quantity.members:
            nothing, parts = len(self.sight.direction), []
            for member, width in zip(quantity.members, quantity.member_widths):
                acting = acted_on(self.machine, member)
                parts.append(self.of_input(member, acting) if acting else np.zeros((nothing, width)))
            return quantity.join_responses(parts)
        if quantity.is_channel:
            parts = [self.through(effect, self.unit_motion(quantity, effect)) for effect in effects]
            return np.asarray(sum(parts, np.zeros((len(self.sight.direction), 1))))
        parts = [self.parameter(effect, quantity.parameter) for effect in effects]
        return np.asarray(sum(parts)) if parts else np.zeros((len(self.sight.direction), 1))

    def unit_motion(self, quantity: Input, effect: Effect) -> Array:
        """Return the error motion (n, 6, k) of an effect per unit of an Input; of a column by central difference."""
        if not quantity.is_channel:
            return basis(effect, quantity.parameter, self.run)
        high, low, step = self.runs_one_step_apart(quantity.parameter)
        return ((effect.error_motion(high) - effect.error_motion(low)) / (2 * step))[:, :, None]

    def runs_one_step_apart(self, column: str) -> tuple[Run, Run, float]:
        """Return `runs_one_step_apart` of the run, cached: many effects read one temperature."""
        if column not in self._runs_apart:
            self._runs_apart[column] = runs_one_step_apart(self.run, column)
        return self._runs_apart[column]

    def product(self, quantity: Input, other: Input) -> Array:
        """Return the observed value (m,) per product of the departures of two scalar Inputs; zero where they do not meet."""
        total = np.zeros(len(self.sight.direction))
        for a, share in quantity.scalars:
            for b, other_share in other.scalars:
                effects = shared_effects(self.machine, a, b)
                if effects:
                    total += share * other_share * self._product(a, b, effects)
        return total

    def _product(self, quantity: Input, other: Input, effects: Sequence[Effect]) -> Array:
        """Return the response (m,) to one Input with the other changed to both sides."""
        if quantity.is_channel:
            quantity, other = (
                other,
                quantity,
            )  # the first is a parameter: temperatures do not meet one another
        total = np.zeros((len(self.sight.direction), 1))
        for effect in effects:
            if other.is_channel:
                high, low, step = self.runs_one_step_apart(other.parameter)
                pair = [self.parameter(effect, quantity.parameter, run) for run in (high, low)]
            else:
                spec = parameter(effect, other.parameter)
                name, step = spec.name, other.size if spec.metadata["scan"] else 1.0
                value = float(getattr(effect, name))
                moved = [with_parameter(effect, name, value + v) for v in (step, -step)]
                pair = [self.parameter(e, quantity.parameter) for e in moved]
            total += (pair[0] - pair[1]) / (2 * step)
        return total[:, 0]


def meet(machine: Machine, quantity: Input, other: Input) -> bool:
    """Return whether two scalar Inputs are multiplied in an effect."""
    return any(shared_effects(machine, a, b) for a, _ in quantity.scalars for b, _ in other.scalars)


def shared_effects(machine: Machine, quantity: Input, other: Input) -> list[Effect]:
    """Return the effects in which two single quantities meet as a product."""
    if quantity.is_channel and other.is_channel:
        return []  # an effect is linear in each temperature
    if quantity.is_channel or other.is_channel:
        channel, param = (quantity, other) if quantity.is_channel else (other, quantity)
        return [e for e in acted_on(machine, param) if channel.parameter in required(e)]
    if quantity.effect == other.effect and quantity.where == other.where:
        return list(acted_on(machine, quantity))
    return []


def responses(carriers: Sequence[Carrier], quantity: Input, effects: Sequence[Effect]) -> list[Array]:
    """Return the columns (m, k) of each of several carriers of one run, per unit of an Input; the unit motions are computed once for all.

    Raises UsageError for an Input on several effects (where = "*") whose parameters differ in size.
    """
    if quantity.members:
        by_member = [
            _of_member(carriers, quantity, m, k) for m, k in zip(quantity.members, quantity.member_widths)
        ]
        return [
            quantity.join_responses([response[i] for response in by_member]) for i in range(len(carriers))
        ]
    totals: list[Array] = []
    for effect in effects:
        six = carriers[0].unit_motion(quantity, effect)
        parts = [carrier.through(effect, six) for carrier in carriers]
        if totals and parts[0].shape != totals[0].shape:
            raise UsageError(
                f'{quantity.id}: where = "*" needs parameters of one size; name the effects one by one'
            )
        totals = [t + p for t, p in zip(totals, parts)] if totals else parts
    return totals


def _of_member(carriers: Sequence[Carrier], joint: Input, quantity: Input, width: int) -> list[Array]:
    effects = acted_on(carriers[0].machine, quantity)
    if joint.widths:
        effects = tuple(e for e in effects if not missing_columns(e, carriers[0].run))
    answers = responses(carriers, quantity, effects)
    return answers or [np.zeros((len(c.sight.direction), width)) for c in carriers]


def missing_columns(effect: Effect, run: Run) -> tuple[str, ...]:
    """Return the columns that an effect needs and the run has neither as a column nor as a log."""
    return tuple(
        c
        for c in required(effect)
        if c not in run.columns and c.removeprefix("temp_").removesuffix("_C") not in run.series
    )


def runs_one_step_apart(run: Run, column: str) -> tuple[Run, Run, float]:
    """Return the run with a column a step higher and a step lower, and the step, for central differences."""
    step = next((s for ending, s in STEP.items() if column.endswith(ending)), 1e-3)
    return (
        shift_channel(run, column, np.full(run.n, step)),
        shift_channel(run, column, np.full(run.n, -step)),
        step,
    )


def shift_channel(run: Run, channel: str, amount: Array) -> Run:
    """Return a run whose column (and the log behind it) is raised by amount (n,)."""
    if channel not in run.columns:
        raise UsageError(
            f'channel = "{channel}" is not a column of this run.{choose_from(channel, sorted(run.columns))}'
        )
    out = run.with_columns({channel: run.column(channel) + amount})
    sensor = channel.removeprefix("temp_").removesuffix("_C")
    if sensor in run.series:
        log = run.series[sensor]
        out = replace(
            out, series={**run.series, sensor: Series(log.time, log.value + float(np.mean(amount)))}
        )
    return out
