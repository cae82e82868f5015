"""The improved machine: the findings as effects with numbers and as Inputs with their covariance.

Random copies (a shift per event) and changes without a single component have no crisp number; they are not added.
"""

from __future__ import annotations

from dataclasses import fields, replace
from typing import Any, cast

import numpy as np

from vcmm.core.effect import Effect, parameter_fields, with_parameter
from vcmm.core.inputs import Input
from vcmm.core.knowledge import addable
from vcmm.core.laws import MultivariateNormal, Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import linear_parameters
from vcmm.learn.diagnosis.select import Selection

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
    if present is None or type(present) is not type(effect) or same_shape(present, effect):
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


def same_shape(one: Effect, other: Effect) -> bool:
    """Return whether two effects of one place differ in linear parameters only."""
    linear = set(linear_parameters(one))
    return all(
        np.array_equal(getattr(one, f.name), getattr(other, f.name))
        for f in fields(one)
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
        kept = tuple(e for e in machine.effects if e.id != effect.id or not same_shape(e, effect))
        if any(e.id == effect.id for e in kept):
            inputs = ()  # two effects of one name and place: an Input could not say which
        names = {i.id for i in inputs}
        kept_inputs = tuple(i for i in machine.inputs if i.id not in names)
        machine = replace(machine, effects=(*kept, effect), inputs=(*kept_inputs, *inputs))
    return machine


def departure(effect: Effect, machine: Machine) -> Effect:
    """Return a fitted effect less what the machine has of it."""
    present = next((e for e in machine.effects if e.id == effect.id), None)
    if present is None or not addable(present, effect):
        return effect
    linear = [f.name for f in parameter_fields(effect) if not f.metadata["scan"]]
    return replace(effect, **{n: getattr(effect, n) - getattr(present, n) for n in linear})
