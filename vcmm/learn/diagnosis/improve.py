"""The improved machine: the findings as effects with numbers and as Inputs with their covariance, and stored tables without the mistake that was found in them.

Random copies (a shift per event) and changes without a single component have no crisp number; they are not added.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace
from typing import Any, cast

import numpy as np

from vcmm.core.effect import Effect, parameter_fields, with_parameter
from vcmm.core.errors import UsageError
from vcmm.core.inputs import Input
from vcmm.core.knowledge import addable
from vcmm.core.laws import MultivariateNormal, Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import linear_parameters
from vcmm.learn.diagnosis.log_mistakes import LOG, Mistake
from vcmm.learn.diagnosis.mistakes import table_nodes, with_numbers_of
from vcmm.learn.diagnosis.select import Selection
from vcmm.physics.structure.abbe import AbbeCountedTwice

EVIDENCE = "diagnosis of a recording"


def fitted_effect(selection: Selection, i: int, machine: Machine) -> tuple[Effect | None, tuple[Input, ...]]:
    """Return term i as an effect (a departure is added to the machine's own value) and the Inputs of its parameters.

    Where the machine has the effect with another period or time constant the departure is an effect of its own.
    """
    assert selection.fit is not None
    option, part = selection.terms[i].option, selection.span(i)
    if option.effect is None or any("@" in label for label in option.labels):
        return None, ()
    mean = selection.fit.mean[part] * option.unit
    covariance = selection.fit.covariance[part, part] * np.outer(option.unit, option.unit)
    effect = separate_effect(option.effect, machine)
    return _with_numbers(effect, mean), _inputs(effect, covariance)


def separate_effect(effect: Effect, machine: Machine) -> Effect:
    """Return the effect as it is, or, beside the machine's own with another period, under a name of its own and from zero.

    A wave of period p is harmonic h of the period h p: with an unused h its Inputs can be told apart by place.
    """
    present = next((e for e in machine.effects if e.id == effect.id), None)
    if present is None or type(present) is not type(effect) or is_same_shape(present, effect):
        return effect
    blank = {n: np.zeros_like(getattr(effect, n)) * 1.0 for n in linear_parameters(effect)}
    effect = replace(effect, **{n: float(v) if np.ndim(v) == 0 else v for n, v in blank.items()})
    taken = {e.id for e in machine.effects}
    if {"harmonic", "period"} <= {f.name for f in fields(effect)}:
        for k in range(2, 30):
            h, period = int(getattr(effect, "harmonic")) * k, float(getattr(effect, "period")) * k  # noqa: B009
            other = replace(effect, **cast(Any, {"harmonic": h, "period": period}))
            if other.id not in taken:
                return other
    return effect


def is_same_shape(first: Effect, second: Effect) -> bool:
    """Return whether two effects of one place differ in linear parameters only."""
    linear = set(linear_parameters(first))
    return all(
        np.array_equal(getattr(first, f.name), getattr(second, f.name))
        for f in fields(first)
        if f.name not in linear
    )


def _with_numbers(effect: Effect, mean: Array) -> Effect:
    at = 0
    for name in linear_parameters(effect):
        old = np.asarray(getattr(effect, name), dtype=float)
        new = old + np.reshape(mean[at : at + old.size], old.shape)
        effect = with_parameter(effect, name, float(new) if old.ndim == 0 else new)
        at += old.size
    return effect


def _inputs(effect: Effect, covariance: Array) -> tuple[Input, ...]:
    """Return one Input per parameter; correlation between parameters of one effect is not kept, that within an array is."""
    out, at = [], 0
    for name in linear_parameters(effect):
        value = np.asarray(getattr(effect, name))
        block = covariance[at : at + value.size, at : at + value.size]
        law = Normal(float(np.sqrt(block[0, 0]))) if value.ndim == 0 else MultivariateNormal(block)
        out.append(Input(effect.name, effect.where, name, law, "machine", EVIDENCE))
        at += value.size
    return tuple(out)


def improve_machine(machine: Machine, found: tuple[tuple[Effect | None, tuple[Input, ...]], ...]) -> Machine:
    """Return a copy of the machine with the fitted effects in place of its own of the same id, and their Inputs."""
    for effect, inputs in found:
        if effect is None:
            continue
        kept = tuple(e for e in machine.effects if e.id != effect.id or not is_same_shape(e, effect))
        if any(e.id == effect.id for e in kept):
            inputs = ()  # two effects of one name and place: an Input could not say which
        names = {i.id for i in inputs}
        kept_inputs = tuple(i for i in machine.inputs if i.id not in names)
        machine = replace(machine, effects=(*kept, effect), inputs=(*kept_inputs, *inputs))
    return machine


def departure_from(effect: Effect, machine: Machine) -> Effect:
    """Return a fitted effect less what the machine has of it."""
    present = next((e for e in machine.effects if e.id == effect.id), None)
    if present is None or not addable(present, effect):
        return effect
    linear = [f.name for f in parameter_fields(effect) if not f.metadata["scan"]]
    return replace(effect, **{n: getattr(effect, n) - getattr(present, n) for n in linear})


def repair_machine(machine: Machine, mistake: Mistake | None) -> Machine:
    """Return a copy of the machine whose tables agree with the recording. Raises UsageError where that has no table."""
    if mistake is None or mistake.effect == LOG:  # the log is to be corrected, not the machine
        return machine
    return replace(machine, effects=repaired_effects(machine.effects, mistake, _arm(machine, mistake)))


def _arm(machine: Machine, mistake: Mistake) -> Array | None:
    axis = machine.axes.get(mistake.component)
    return None if axis is None or axis.measured_at is None else np.asarray(axis.measured_at, dtype=float)


def repaired_effects(
    effects: Sequence[Effect], mistake: Mistake, arm: Array | None = None
) -> tuple[Effect, ...]:
    """Return the same effects with the tables concerned corrected; arm (3,): measured_at of the axis, for an Abbe error."""
    if mistake.effect == LOG:
        raise UsageError(f"{mistake.component}: the log is mistaken, no table")
    if mistake.effect == AbbeCountedTwice.name:
        return _without_abbe(effects, mistake, arm)
    if mistake.source:
        pairs = {mistake.component: mistake.source}
        if mistake.both:
            pairs[mistake.source] = mistake.component
        by_place = {e.where: e for e in effects if e.about.table_parameter}
        return tuple(
            with_numbers_of(e, by_place[pairs[e.where]])
            if e.about.table_parameter and e.where in pairs
            else e
            for e in effects
        )
    return tuple(_times(e, mistake.factor) if _is_affected(e, mistake) else e for e in effects)


def _is_affected(effect: Effect, mistake: Mistake) -> bool:
    return bool(effect.about.table_parameter) and mistake.component in ("all", effect.where)


def _times(effect: Effect, factor: float) -> Effect:
    value = np.asarray(getattr(effect, effect.about.table_parameter), dtype=float) * factor
    return with_parameter(effect, effect.about.table_parameter, float(value) if value.ndim == 0 else value)


def _without_abbe(effects: Sequence[Effect], mistake: Mistake, arm: Array | None) -> tuple[Effect, ...]:
    """Return translations of the axis with the Abbe error subtracted (or added): minus or plus rotation x arm at their nodes."""
    if arm is None:
        raise UsageError(f"axis {mistake.component} has no measured_at; its Abbe error has no arm")
    abbe = AbbeCountedTwice.from_tables(mistake.component, effects, [float(v) for v in arm])
    moved = np.asarray(abbe.deviation, dtype=float)
    out = []
    for e in effects:
        component = str(getattr(e, "component", ""))
        if e.about.table_parameter and component[1:] in {f"{d}{mistake.component}" for d in "XYZ"}:
            if len(abbe.grids) != 1:
                raise UsageError(
                    "the rotation tables have several arguments; the corrected table must be made by hand"
                )
            extra = np.interp(table_nodes(e), abbe.grids[0], moved[:, "XYZ".index(component[1])])
            values = np.asarray(getattr(e, "values"), dtype=float)  # noqa: B009
            e = with_parameter(e, "values", values - mistake.factor * extra)
        out.append(e)
    return tuple(out)
