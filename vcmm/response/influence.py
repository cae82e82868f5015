"""Influence: how one Input moves every observation. The columns of G before any fit.

For an Input on `effect[where].parameter` the unit response of the effect is carried to the tip; for an Input on a
run column the whole machine is evaluated a little to either side. Both give d(indicated - true) / d(input) in
workpiece axes, (n, 3, k). Two Inputs of one effect (a coefficient and its temperature) also have a product term.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from typing import Any

import numpy as np

from vcmm.core.effect import Effect, basis, with_parameter
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.inputs import EVERY, Input
from vcmm.core.kinematics import Motion, tip_motion
from vcmm.core.laws import MultivariateNormal, MultivariateSamples
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run, Series

STEP = {"_C": 0.5, "_mm": 1e-3, "_rad": 1e-5}  # for run columns, by the unit in their name; others 1e-3


@dataclass(frozen=True, eq=False)
class Influence:
    """response (n, 3, k): change of indicated - true per unit of each element of the Input; workpiece axes, mm.

    copies: labels of the independent draws; codes (n,): which draw acts on which row.
    """

    input: Input
    response: Array
    copies: tuple[str, ...]
    codes: Any


def influences(machine: Machine, run: Run, inputs: Sequence[Input]) -> tuple[Influence, ...]:
    """One Influence per Input. `run` is prepared. Raises UsageError for a target that does not exist."""
    _refuse_twins(inputs)
    carry = _Carrier(machine, run)
    out = []
    for one in inputs:
        response = (
            _of_channel(machine, run, one) if one.is_channel else _of_parameter(machine, run, one, carry)
        )
        _check_size(one, response.shape[2])
        copies, codes = run.copies(one.redraw)
        out.append(Influence(one, response, tuple(copies), codes))
    return tuple(out)


def _refuse_twins(inputs: Sequence[Input]) -> None:
    """Two Inputs of one name would be drawn from one stream, in step."""
    ids = [i.id for i in inputs]
    for name in ids:
        if ids.count(name) > 1:
            raise UsageError(f"{name} has {ids.count(name)} inputs; keep one, or join them into one law")


def _check_size(one: Input, k: int) -> None:
    """The law fits the number of elements of the parameter."""
    law, scale = one.law, one.scale
    given = None if scale is None or np.size(scale) == 1 else np.size(scale)
    if isinstance(law, MultivariateNormal):
        given = len(law.covariance)
    elif isinstance(law, MultivariateSamples):
        given = law.values.shape[1]
    if given is not None and given != k:
        raise UsageError(
            f"{one.id}: the law is for {given} numbers, but the parameter has {k}; give one for each"
        )


def targets(machine: Machine, one: Input) -> list[Effect]:
    """The effects an Input acts on. Raises UsageError when there is none."""
    found = [e for e in machine.effects if e.name == one.effect and one.where in (EVERY, e.where)]
    if not found:
        known = sorted({e.id for e in machine.effects})
        raise UsageError(
            f"{one.id}: the machine has no such effect.{choose_from(f'{one.effect}[{one.where}]', known)}"
        )
    if one.where != EVERY and len(found) > 1:
        raise UsageError(
            f"{one.id} acts on {len(found)} effects of that name; make them one effect, or tell them apart by their place"
        )
    return found


class _Carrier:
    """Maps six error motions of a link to the tip, (n, 3, 6), made once per link and place."""

    def __init__(self, machine: Machine, run: Run) -> None:
        self.machine, self.run = machine, run
        self.maps: dict[tuple[str, str], Array] = {}

    def to_indication(self, effect: Effect, six: Array) -> Array:
        """(n, 6, k) of the effect's link -> (n, 3, k) of indicated - true."""
        if effect.link == "reading":
            return six[:, :3]
        key = (effect.link, effect.place)
        if key not in self.maps:
            unit = [Motion(*key, np.broadcast_to(np.eye(6)[j], (self.run.n, 6))) for j in range(6)]
            machine = self.machine
            columns = [tip_motion(machine.chain, machine.axes, self.run, [m])[:, :3] for m in unit]
            self.maps[key] = np.stack(columns, axis=2)
        return -self.machine.sign(effect) * np.einsum("nij,njk->nik", self.maps[key], six)


def _of_parameter(machine: Machine, run: Run, one: Input, carry: _Carrier) -> Array:
    found = targets(machine, one)
    for effect in found:
        machine.asked(effect, run)
    parts = [carry.to_indication(e, basis(e, one.parameter, run)) for e in found]
    if any(p.shape != parts[0].shape for p in parts):
        raise UsageError(f'{one.id}: where = "*" needs parameters of one size; name the effects one by one')
    return np.sum(parts, axis=0)


def _of_channel(machine: Machine, run: Run, one: Input) -> Array:
    step = next((s for ending, s in STEP.items() if one.parameter.endswith(ending)), 1e-3)
    high = machine.indication_error(shifted(run, one.parameter, np.full(run.n, step)))
    low = machine.indication_error(shifted(run, one.parameter, np.full(run.n, -step)))
    return ((high - low) / (2 * step))[:, :, None]


def shifted(run: Run, channel: str, amount: Array) -> Run:
    """A run whose column (and the log behind it) is raised by amount (n,)."""
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


@dataclass(frozen=True, eq=False)
class Product:
    """Second-order term of two scalar Inputs: response (n, 3) per product of their departures at each row.

    first, second: numbers of the Influences. Which copies meet in a row is told by their codes.
    """

    first: int
    second: int
    response: Array


def products(machine: Machine, run: Run, found: Sequence[Influence]) -> tuple[Product, ...]:
    """Mixed terms d2(indicated - true) / dx_i dx_j for pairs of scalar Inputs that meet in one effect.

    GUM H.1: alpha_s dTheta + theta dAlpha; the product of the two departures remains where an estimate is zero.
    """
    out = []
    scalar = [i for i, f in enumerate(found) if f.response.shape[2] == 1]
    scalar = [i for i in scalar if not isinstance(found[i].input.law, MultivariateSamples)]
    for a, i in enumerate(scalar):
        for j in scalar[a + 1 :]:
            one, other = found[i].input, found[j].input
            common = shared(machine, run, one, other)
            if common:
                response = _mixed(replace(machine, effects=tuple(common)), run, one, other)
                if np.abs(response).max(initial=0.0) > 1e-12:
                    out.append(Product(i, j, response))
    return tuple(out)


def shared(machine: Machine, run: Run, one: Input, other: Input) -> list[Effect]:
    """Effects in which two scalar Inputs meet as a product."""
    if one.is_channel and other.is_channel:
        return []  # an effect is linear in each temperature
    if one.is_channel or other.is_channel:
        channel, param = (one, other) if one.is_channel else (other, one)
        return [e for e in targets(machine, param) if channel.parameter in e.required()]
    if one.effect == other.effect and one.where == other.where:
        return targets(machine, one)
    return []


def _mixed(machine: Machine, run: Run, one: Input, other: Input) -> Array:
    """Mixed second difference; any step is exact for a product, one standard deviation keeps the rounding small."""
    h, g = _step(one), _step(other)
    total = np.zeros((run.n, 3))
    for a in (1.0, -1.0):
        for b in (1.0, -1.0):
            moved, where = moved_by(*moved_by(machine, run, one, a * h), other, b * g)
            total += a * b * moved.indication_error(where)
    return total / (4.0 * h * g)


def _step(one: Input) -> float:
    _, factor = one.spread(1)
    u = float(np.ravel(one.law.u)[0]) * abs(float(factor[0, 0]))
    return u if 0 < u < np.inf else 1e-6


def moved_by(machine: Machine, run: Run, one: Input, amount: float | Array) -> tuple[Machine, Run]:
    """Machine and run with the target of one Input changed by `amount`, the same for all rows."""
    if one.is_channel:
        return machine, shifted(run, one.parameter, np.full(run.n, float(np.asarray(amount))))
    changed = []
    for effect in machine.effects:
        if effect.name == one.effect and one.where in (EVERY, effect.where):
            effect = with_parameter(effect, one.parameter, getattr(effect, one.parameter) + amount)
        changed.append(effect)
    return replace(machine, effects=tuple(changed)), run
