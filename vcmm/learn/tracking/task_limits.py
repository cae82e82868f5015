"""Effect of the state of the machine on a task: u of a characteristic on any day, from the covariance of the state alone.

    u^2(day) = u_rest^2 + g C(day) g'        g: change of the characteristic per number of the machine, C: their covariance

g is exact to first order (vcmm.answer.evaluation.linear); u_rest is all that is uncertain besides, and stays. Extremes (form, location)
are no linear function of the machine and are refused.
"""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.linear import LinearModel, build
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.inputs import SINCE, STATE
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.core.units import quantity
from vcmm.learn.tracking.machine_at import DatedMachine, as_machine
from vcmm.physics.structure.component import CalibrationModes
from vcmm.task.measuring.scenario import Scenario

LINEAR = ("size", "distance", "angle")
K = 2.0  # U = 2 u


@dataclass(frozen=True, eq=False)
class TaskLimit:
    """name of the characteristic; limit of U = 2 u, mm or rad; gain (n,) per number of the state; rest: u of all else; unit."""

    name: str
    limit: float
    gain: Array
    rest: float
    unit: str


@dataclass(frozen=True, eq=False)
class CharacteristicGain:
    """name and type of the characteristic; gain (n,) per number of the state; unit: mm or rad."""

    name: str
    type: str
    gain: Array
    unit: str


def gains_of(scenario: Scenario, dated: DatedMachine) -> tuple[CharacteristicGain, ...]:
    """Return the change of the indicated value of every characteristic that is linear in the machine. Raises UsageError where there is none."""
    model = build(replace(scenario, machine=_in_task(scenario, dated)).task())
    state = _gain(model, model.gradient(), dated)
    out = tuple(
        CharacteristicGain(c.name, c.type, g, "rad" if c.type == "angle" else "mm")
        for c, g in zip(model.characteristics, state)
        if c.type in LINEAR
    )
    if not out:
        raise UsageError(
            f"the task has no characteristic whose shift follows from the machine ({', '.join(LINEAR)})"
        )
    return out


def limits_of(texts: Sequence[str], scenario: Scenario, dated: DatedMachine) -> tuple[TaskLimit, ...]:
    """Return the limits of texts such as "bore distance = 2 um". Raises UsageError for unknown names, wrong values and unsuitable types."""
    model = build(replace(scenario, machine=_in_task(scenario, dated)).task())
    names, out = [c.name for c in model.characteristics], []
    gradient = model.gradient()
    state, rest = _gain(model, gradient, dated), _rest(model, gradient)
    for text in texts:
        match = re.fullmatch(r"\s*(.+?)\s*=\s*(.+?)\s*", text)
        if not match or match[1] not in names:
            raise UsageError(
                f'--limit "{text}": write the name of a characteristic and U, such as "{names[0]} = 2 um".{choose_from(match[1] if match else text, names)}'
            )
        i = names.index(match[1])
        kind = model.characteristics[i].type
        if kind not in LINEAR:
            raise UsageError(
                f'--limit "{text}": {kind} is an extreme of many points and no linear function of the machine; a limit can be kept for '
                f"{', '.join(LINEAR)}"
            )
        unit = "rad" if kind == "angle" else "mm"
        value = quantity(
            match[2], *(("angle", "--limit", "20 urad") if kind == "angle" else ("length", "--limit", "2 um"))
        )
        if value <= 0:
            raise UsageError(
                f'--limit "{text}": a limit of U is larger than zero; write for example "{match[1]} = 2 um"'
            )
        out.append(TaskLimit(match[1], value, state[i], float(rest[i]), unit))
    return tuple(out)


def _in_task(scenario: Scenario, dated: DatedMachine) -> Machine:
    """Return the machine of the day with the effects of part and room of the scenario. Raises UsageError where the task is for another machine."""
    machine, given, now = dated.history.tracked.machine, scenario.machine, as_machine(dated)
    if machine.chain.structure != given.chain.structure or machine.axes.keys() != given.axes.keys():
        raise UsageError(
            f'the task is one of the machine "{given.name}" ({given.chain.structure}), and "{machine.name}" ({machine.chain.structure}) is followed; '
            "give a scenario whose machine is that one"
        )
    effect_ids, input_ids = {e.id for e in machine.effects}, {i.id for i in machine.inputs}
    effects = [e for e in given.effects if e.id not in effect_ids and not isinstance(e, CalibrationModes)]
    inputs = [
        i
        for i in given.inputs
        if i.id not in input_ids and not i.id.startswith(STATE) and i.effect != CalibrationModes.name
    ]
    return replace(now, effects=(*now.effects, *effects), inputs=(*now.inputs, *inputs))


def _gain(model: LinearModel, gradient: Array, dated: DatedMachine) -> Array:
    """Return the change of the characteristics per number of the state, as (C, n)."""
    whole = np.zeros((len(gradient), dated.history.tracked.factor.shape[0]))
    influence = next((f for f in model.influences if f.input.id.startswith(STATE)), None)
    if influence is None:
        return whole @ dated.history.ways
    rows = dated.history.tracked.rows
    numbers = np.concatenate([np.arange(rows[q.id].start, rows[q.id].stop) for q in dated.uncertain])
    whole[:, numbers] = gradient @ model.operator @ model.along_normal(influence)
    return whole @ dated.history.ways


def _rest(model: LinearModel, gradient: Array) -> Array:
    """Return (C,): u of everything but the state of the machine."""
    square = np.zeros(len(gradient))
    for influence in model.influences:
        if influence.input.id in (STATE, f"{STATE} by {SINCE}"):
            continue
        term = model.term(influence)
        u = np.ravel(np.asarray(term.law.u, dtype=float))
        square += ((gradient @ term.gain * u) ** 2).sum(axis=1)
    return np.sqrt(square)
