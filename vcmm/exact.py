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


def linear_values(model: LinearModel, drawn: list[Draws]) -> Array:
    """Characteristics (m, C) of the linear model for given draws."""
    q = np.broadcast_to(model.q0, (len(drawn[0].raw), len(model.q0))).copy() if drawn else model.q0[None]
    for one in drawn:
        along = model.along_normal(one.influence)
        codes = one.influence.codes
        q += np.einsum("mnk,nk->mn", one.departures[:, codes], along) @ model.operator.T
    for product in model.products:
        pair = drawn[product.first].raw[:, 0, 0] * drawn[product.second].raw[:, 0, 0]
        factors = [drawn[i].influence.input.spread(1)[1][0, 0] for i in (product.first, product.second)]
        q += pair[:, None] * factors[0] * factors[1] * model.product_gain(product)
    return model.values(q)


def exact_values(model: LinearModel, drawn: list[Draws]) -> Array:
    """Characteristics (m, C) with nothing linearised but parameters of many elements, which act linearly anyway."""
    return evaluate_all(
        model.task, fit_features(model.task, measured_points(model.task, exact_errors(model, drawn)))
    )


def exact_errors(model: LinearModel, drawn: list[Draws]) -> Array:
    """indicated - true (m, n, 3) of every touch in every trial, workpiece axes, transforms multiplied."""
    trials = len(drawn[0].raw) if drawn else 1
    bases = _Bases(model)
    return np.stack([_indication_error(model, drawn, t, bases) for t in range(trials)])


class _Bases:
    """Unit responses of array parameters, made once: they do not depend on the draws."""

    def __init__(self, model: LinearModel) -> None:
        self.model = model
        self.shifted = {i.input.parameter for i in model.influences if i.input.is_channel}
        self.known: dict[tuple[str, str], Array] = {}

    def motion(self, effect: Effect) -> Array:
        """The effect's motion at its estimates, for trials that change neither its parameters nor its columns."""
        key = (effect.id, "")
        if key not in self.known:
            self.known[key] = effect.error_motion(self.model.task.touches.run)
        return self.known[key]

    def of(self, effect: Effect, name: str) -> Array:
        key = (effect.id, name)
        if key not in self.known:
            self.known[key] = basis(effect, name, self.model.task.touches.run)
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
    extra, untouched = np.zeros((run.n, 6)), effect
    for one in drawn:
        name = one.influence.input.parameter
        departure = one.departures[trial]
        if len(departure) == 1 and departure.shape[1] <= DIRECT:
            value = np.asarray(getattr(effect, parameter(effect, name).name), dtype=float)
            moved = value + departure[0].reshape(value.shape)
            effect = with_parameter(effect, name, float(moved) if value.ndim == 0 else moved)
        else:
            extra += np.einsum("nik,nk->ni", bases.of(effect, name), one.on_rows(trial))
    base = run is bases.model.task.touches.run or not set(effect.required()) & bases.shifted
    motion = bases.motion(effect) if effect is untouched and base else effect.error_motion(run)
    return motion + extra
