"""The slow truth: trials with multiplied transforms, contact found on the nominal surface, iterated fits.

Used to certify the linear model on the very same draws, and as an engine of its own for small numbers of trials.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.effect import Effect, basis, parameter, with_parameter
from vcmm.influence import Influence, shifted
from vcmm.inputs import EVERY
from vcmm.kinematics import Motion, exact_tip_error
from vcmm.linear import LinearModel
from vcmm.run import Array, Run
from vcmm.streams import copy_code, draw
from vcmm.task import evaluate_all, fit_features, measured_points

DIRECT = 4  # parameters with at most this many elements are put into the effect itself, so that nothing is linearised


@dataclass(frozen=True, eq=False)
class Draws:
    """Draws of one Input for some trials: departures (m, copies, k), canonical units, and the raw numbers (m, copies, r)."""

    influence: Influence
    raw: Array
    departures: Array

    def head(self, count: int) -> Draws:
        """The first trials."""
        return Draws(self.influence, self.raw[:count], self.departures[:count])

    def on_rows(self, trial: int) -> Array:
        """(n, k): the departure that acts on each row."""
        return np.asarray(self.departures[trial][self.influence.codes])


def draw_inputs(model: LinearModel, seed: int, first: int, count: int) -> list[Draws]:
    """The same numbers that the Monte Carlo tiers draw for trials first .. first + count - 1."""
    out = []
    for influence in model.influences:
        law, factor = influence.input.spread(influence.response.shape[2])
        r = factor.shape[1]
        lanes = [(k, copy_code(c)) for c in influence.copies for k in range(r)]
        raw = draw(seed, influence.input.id, np.array(lanes, dtype=np.uint32), law, first, count)
        raw = raw.reshape(count, len(influence.copies), r)
        out.append(Draws(influence, raw, raw @ factor.T))
    return out


def linear_quantities(model: LinearModel, drawn: list[Draws]) -> Array:
    """q (m, K) of the linear model for given draws, products included."""
    q = np.broadcast_to(model.q0, (len(drawn[0].raw), len(model.q0))).copy() if drawn else model.q0[None]
    for one in drawn:
        along = model.along_normal(one.influence)
        codes = one.influence.codes
        q += np.einsum("mnk,nk->mn", one.departures[:, codes], along) @ model.operator.T
    for product in model.products:
        first, second = (drawn[i].departures[:, :, 0] for i in (product.first, product.second))
        for one_copy, other_copy, gain in model.meetings(product):
            q += (first[:, one_copy] * second[:, other_copy])[:, None] * gain
    return np.asarray(q)


def exact_values(model: LinearModel, drawn: list[Draws]) -> Array:
    """Characteristics (m, C) with transforms multiplied, contact found and fits iterated.

    Parameters are put into their effects; those of many elements or of several copies act by their unit response, which
    is exact for all but scanned ones (a time constant redrawn per touch stays linearised).
    """
    return evaluate_all(
        model.task, fit_features(model.task, measured_points(model.task, exact_errors(model, drawn)))
    )


def exact_errors(model: LinearModel, drawn: list[Draws]) -> Array:
    """indicated - true (m, n, 3) of every touch in every trial, workpiece axes, transforms multiplied."""
    trials = len(drawn[0].raw) if drawn else 1
    bases = _Bases(model.task.touches.run)
    return np.stack([_indication_error(model, drawn, t, bases) for t in range(trials)])


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


def _indication_error(model: LinearModel, drawn: list[Draws], trial: int, bases: _Bases) -> Array:
    machine, run = model.task.machine, model.task.touches.run
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
