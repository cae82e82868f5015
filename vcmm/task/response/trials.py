"""Compute exact errors of trials: the machine with sampled Inputs put into its effects and the transforms multiplied."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.effect import Effect, basis, parameter, with_parameter
from vcmm.core.inputs import EVERY
from vcmm.core.kinematics import Motion, exact_tip, nominal_tip
from vcmm.core.laws import Law
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.task.response.carrier import shift_channel
from vcmm.task.response.influence import Influence

DIRECT = 4  # parameters with at most this many elements are put into the effect itself, so that nothing is linearised
AT_ONCE = 10_000  # rows of all trials that are worked out together
TRIALS_OF_EFFECT = 3  # trials by which an effect shows that it answers in proportion


@dataclass(frozen=True, eq=False)
class Draws:
    """Draws of one Input for some trials: departures (m, copies, k), canonical units, and the raw numbers (m, copies, r)."""

    influence: Influence
    raw: Array
    departures: Array

    def head(self, count: int) -> Draws:
        """Return the first trials."""
        return self.part(0, count)

    def part(self, first: int, last: int) -> Draws:
        """Return the trials first .. last - 1."""
        return Draws(self.influence, self.raw[first:last], self.departures[first:last])

    def moves(self) -> Array:
        """Return the motion of every row by the draws (m, n, 3), first order."""
        return np.einsum("nik,mnk->mni", self.influence.response, self.departures[:, self.influence.codes])

    def on_rows(self, trial: int) -> Array:
        """Return the departure that acts on each row (n, k)."""
        return np.asarray(self.departures[trial][self.influence.codes])


def exact_errors(machine: Machine, run: Run, drawn: Sequence[Draws]) -> Array:
    """Return indicated - true (m, n, 3) of every row of a prepared run in every trial, workpiece axes, transforms multiplied.

    Parameters are put into their effects; those of many elements or of several copies act by their unit response, which
    is exact for all but scanned ones (a time constant redrawn per touch stays linearised).
    """
    count = len(drawn[0].raw) if drawn else 1
    drawn = [single for draws in drawn for single in _singles(draws)]
    size = max(1, AT_ONCE // run.n)
    bases = _Bases(run)
    blocks = [[d.part(at, at + size) for d in drawn] for at in range(0, count, size)]
    return np.concatenate([_block_errors(machine, run, b, min(size, count), bases) for b in blocks])


def _block_errors(machine: Machine, run: Run, drawn: Sequence[Draws], count: int, bases: _Bases) -> Array:
    """Return the errors (m, n, 3) of one block of trials: motions effect by effect, the transforms of all trials multiplied at once."""
    trials = range(len(drawn[0].raw) if drawn else count)
    channels = [d for d in drawn if d.influence.input.is_channel]
    runs = [_with_channels(run, channels, t) for t in trials] if channels else [run] * len(trials)
    motions, reading = [], np.zeros((len(trials), run.n, 3))
    for effect in machine.effects:
        six = _drawn_motions(effect, runs, [d for d in drawn if _acts(d, effect)], bases)
        if effect.link == "reading":
            reading += six[:, :, :3]
        else:
            signed = machine.sign(effect) * six.reshape(-1, 6)
            motions.append(Motion(effect.link, effect.place, signed))
    position = {axis: np.tile(q, len(trials)) for axis, q in run.position.items()}
    every = Run(position, np.tile(run.offset, (len(trials), 1)))
    tip = exact_tip(machine.chain, machine.axes, every, motions).reshape(reading.shape)
    return np.asarray(reading - (tip - bases.tip(machine)))


def _with_channels(run: Run, channels: Sequence[Draws], trial: int) -> Run:
    """Return the run of one trial, with its sampled channels moved; the run itself where no channel is sampled."""
    plain: dict[str, Array] = {}
    for channel in channels:
        name, amount = channel.influence.input.parameter, channel.on_rows(trial)[:, 0]
        if name in run.columns and name.removeprefix("temp_").removesuffix("_C") not in run.series:
            plain[name] = plain.get(name, run.columns[name]) + amount
        else:
            run = shift_channel(run, name, amount)
    return run.with_columns(plain) if plain else run


def _singles(draws: Draws) -> list[Draws]:
    """Return the draws of every single quantity that is known together with others."""
    joint = draws.influence.input
    if not joint.members:
        return [draws]
    common = isinstance(joint.law, Law)
    out, ends = [], np.cumsum([0, *joint.member_widths])
    for i, (member, share) in enumerate(joint.scalars):
        moved = share * draws.departures if common else draws.departures[:, :, ends[i] : ends[i + 1]]
        out.append(Draws(replace(draws.influence, input=member), draws.raw, moved))
    return out


class _Bases:
    """Quantities that do not depend on the draws, computed once: motions at the estimates, responses of parameters of many elements.

    Kept per effect object, not per name. Any effect may read channels, so that nothing is kept of a trial that
    moves one.
    """

    def __init__(self, run: Run) -> None:
        self.run = run
        self.known: dict[tuple[int, str], Array] = {}
        self.plain: dict[int, bool] = {}  # whether an effect answers in proportion

    def tip(self, machine: Machine) -> Array:
        """Return the nominal tip (n, 3) mm of the run."""
        if (0, "tip") not in self.known:
            self.known[0, "tip"] = nominal_tip(machine.chain, machine.axes, self.run)
        return self.known[0, "tip"]

    def motion(self, effect: Effect, run: Run) -> Array:
        """Return the effect's motion at its estimates."""
        if run is not self.run:
            return effect.error_motion(run)
        key = (id(effect), "")
        if key not in self.known:
            self.known[key] = effect.error_motion(run)
        return self.known[key]

    def of(self, effect: Effect, name: str, run: Run) -> Array:
        """Return unit responses (n, 6, k)."""
        if run is not self.run and np.size(getattr(effect, parameter(effect, name).name)) <= DIRECT:
            return basis(effect, name, run)
        key = (id(effect), name)
        if key not in self.known:
            self.known[key] = basis(effect, name, self.run)
        return self.known[key]


def _acts(draws: Draws, effect: Effect) -> bool:
    target = draws.influence.input
    return not target.is_channel and target.effect == effect.name and target.where in (EVERY, effect.where)


def _drawn_motions(effect: Effect, runs: Sequence[Run], drawn: Sequence[Draws], bases: _Bases) -> Array:
    """Return the motions (m, n, 6) of one effect in all trials of a block, each with its run.

    Where the first trials show that the motion depends on its sampled parameters only, and in proportion, all trials are
    the estimates plus unit responses; else every trial is put into the effect by itself.
    """
    if id(effect) not in bases.plain:
        bases.plain[id(effect)] = _answers_in_proportion(effect, runs, drawn, bases)
    if bases.plain[id(effect)]:
        return _in_proportion(effect, len(runs), drawn, bases)
    return np.stack([_drawn_motion(effect, run, drawn, t, bases) for t, run in enumerate(runs)])


def _answers_in_proportion(
    effect: Effect, runs: Sequence[Run], drawn: Sequence[Draws], bases: _Bases
) -> bool:
    if any(parameter(effect, d.influence.input.parameter).metadata["scan"] for d in drawn):
        return False
    first = [d.head(TRIALS_OF_EFFECT) for d in drawn]
    in_proportion = _in_proportion(effect, len(runs[:TRIALS_OF_EFFECT]), first, bases)
    shown = np.stack(
        [_drawn_motion(effect, run, first, t, bases) for t, run in enumerate(runs[:TRIALS_OF_EFFECT])]
    )
    rounding = 1e-12 * max(float(np.abs(shown).max()), float(np.abs(in_proportion).max()))
    return bool(np.abs(in_proportion - shown).max() <= rounding)


def _in_proportion(effect: Effect, count: int, drawn: Sequence[Draws], bases: _Bases) -> Array:
    """Return the motions (m, n, 6): the motion at the estimates of the unmoved run, and departures times unit responses."""
    total = np.broadcast_to(bases.motion(effect, bases.run), (count, bases.run.n, 6))
    for draws in drawn:
        unit = bases.of(effect, draws.influence.input.parameter, bases.run)
        if len(draws.influence.copies) == 1:
            total = total + (draws.departures[:, 0] @ unit.reshape(-1, unit.shape[2]).T).reshape(total.shape)
        else:
            total = total + np.einsum("nik,mnk->mni", unit, draws.departures[:, draws.influence.codes])
    return total


def _drawn_motion(effect: Effect, run: Run, drawn: Sequence[Draws], trial: int, bases: _Bases) -> Array:
    extra, moved = np.zeros((run.n, 6)), effect
    for draws in drawn:
        name = draws.influence.input.parameter
        departure = draws.departures[trial]
        if len(departure) == 1 and departure.shape[1] <= DIRECT:
            value = np.asarray(getattr(moved, parameter(effect, name).name), dtype=float)
            changed = value + departure[0].reshape(value.shape)
            moved = with_parameter(moved, name, float(changed) if value.ndim == 0 else changed)
        else:
            extra += np.einsum("nik,nk->ni", bases.of(effect, name, run), draws.on_rows(trial))
    motion = bases.motion(effect, run) if moved is effect else moved.error_motion(run)
    return np.asarray(motion + extra)
