"""Exact trials: the errors of one machine with drawn Inputs put into its effects and the transforms multiplied."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.effect import Effect, basis, parameter, with_parameter
from vcmm.core.inputs import EVERY
from vcmm.core.kinematics import Motion, exact_tip_error
from vcmm.core.laws import Law
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.response.carrier import shifted
from vcmm.response.influence import Influence

DIRECT = 4  # parameters with at most this many elements are put into the effect itself, so that nothing is linearised


@dataclass(frozen=True, eq=False)
class Draws:
    """Draws of one Input for some trials: departures (m, copies, k), canonical units, and the raw numbers (m, copies, r)."""

    influence: Influence
    raw: Array
    departures: Array

    def head(self, count: int) -> Draws:
        """The first trials."""
        return self.part(0, count)

    def part(self, first: int, last: int) -> Draws:
        """Trials first .. last - 1."""
        return Draws(self.influence, self.raw[first:last], self.departures[first:last])

    def moves(self) -> Array:
        """(m, n, 3): what the draws move every row by, first order."""
        return np.einsum("nik,mnk->mni", self.influence.response, self.departures[:, self.influence.codes])

    def on_rows(self, trial: int) -> Array:
        """(n, k): the departure that acts on each row."""
        return np.asarray(self.departures[trial][self.influence.codes])


def exact_errors(machine: Machine, run: Run, drawn: Sequence[Draws]) -> Array:
    """indicated - true (m, n, 3) of every row of a prepared run in every trial, workpiece axes, transforms multiplied.

    Parameters are put into their effects; those of many elements or of several copies act by their unit response, which
    is exact for all but scanned ones (a time constant redrawn per touch stays linearised).
    """
    trials = len(drawn[0].raw) if drawn else 1
    drawn = [single for one in drawn for single in _singles(one)]
    bases = _Bases(run)
    return np.stack([_indication_error(machine, run, drawn, t, bases) for t in range(trials)])


def _singles(one: Draws) -> list[Draws]:
    """The draws of every single quantity that is known together with others."""
    joint = one.influence.input
    if not joint.members:
        return [one]
    common = isinstance(joint.law, Law)
    out = []
    for i, (member, share) in enumerate(joint.scalars):
        moved = share * one.departures if common else one.departures[:, :, i : i + 1]
        out.append(Draws(replace(one.influence, input=member), one.raw, moved))
    return out


class _Bases:
    """What does not depend on the draws, made once: motions at the estimates, responses of parameters of many elements.

    Kept per effect object, not per name. Channels may be read by any effect, so that nothing is kept of a trial that
    moves one.
    """

    def __init__(self, run: Run) -> None:
        self.run = run
        self.known: dict[tuple[int, str], Array] = {}

    def motion(self, effect: Effect, run: Run) -> Array:
        """The effect's motion at its estimates."""
        if run is not self.run:
            return effect.error_motion(run)
        key = (id(effect), "")
        if key not in self.known:
            self.known[key] = effect.error_motion(run)
        return self.known[key]

    def of(self, effect: Effect, name: str, run: Run) -> Array:
        """Unit responses (n, 6, k)."""
        if run is not self.run and np.size(getattr(effect, parameter(effect, name).name)) <= DIRECT:
            return basis(effect, name, run)
        key = (id(effect), name)
        if key not in self.known:
            self.known[key] = basis(effect, name, self.run)
        return self.known[key]


def _indication_error(machine: Machine, run: Run, drawn: Sequence[Draws], trial: int, bases: _Bases) -> Array:
    for one in drawn:
        if one.influence.input.is_channel:
            run = shifted(run, one.influence.input.parameter, one.on_rows(trial)[:, 0])
    motions, reading = [], np.zeros((run.n, 3))
    for effect in machine.effects:
        six = _drawn_motion(effect, run, [d for d in drawn if _acts(d, effect)], trial, bases)
        if effect.link == "reading":
            reading += six[:, :3]
        else:
            motions.append(Motion(effect.link, effect.place, machine.sign(effect) * six))
    return np.asarray(reading - exact_tip_error(machine.chain, machine.axes, run, motions))


def _acts(one: Draws, effect: Effect) -> bool:
    target = one.influence.input
    return not target.is_channel and target.effect == effect.name and target.where in (EVERY, effect.where)


def _drawn_motion(effect: Effect, run: Run, drawn: list[Draws], trial: int, bases: _Bases) -> Array:
    extra, moved = np.zeros((run.n, 6)), effect
    for one in drawn:
        name = one.influence.input.parameter
        departure = one.departures[trial]
        if len(departure) == 1 and departure.shape[1] <= DIRECT:
            value = np.asarray(getattr(moved, parameter(effect, name).name), dtype=float)
            changed = value + departure[0].reshape(value.shape)
            moved = with_parameter(moved, name, float(changed) if value.ndim == 0 else changed)
        else:
            extra += np.einsum("nik,nk->ni", bases.of(effect, name, run), one.on_rows(trial))
    motion = bases.motion(effect, run) if moved is effect else moved.error_motion(run)
    return np.asarray(motion + extra)
