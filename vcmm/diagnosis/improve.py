"""The improved machine: what was found, as effects with numbers and as Inputs with their covariance.

Random copies (a shift per event) and changes without a single component have no crisp number; they are not added.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.diagnosis.candidates import linear_parameters
from vcmm.diagnosis.select import Selection
from vcmm.effect import Effect, with_parameter
from vcmm.inputs import Input
from vcmm.laws import MultivariateNormal, Normal
from vcmm.machine import Machine
from vcmm.run import Array

EVIDENCE = "diagnosis of a recording"


def fitted(selection: Selection, i: int) -> tuple[Effect | None, tuple[Input, ...]]:
    """Term i as an effect (a departure is added to the machine's own value) and what is known of its parameters."""
    assert selection.fit is not None
    option, part = selection.terms[i].option, selection.span(i)
    if option.effect is None or any("@" in label for label in option.labels):
        return None, ()
    mean = selection.fit.mean[part] * option.unit
    covariance = selection.fit.covariance[part, part] * np.outer(option.unit, option.unit)
    return _with_numbers(option.effect, mean), _inputs(option.effect, covariance)


def _with_numbers(effect: Effect, mean: Array) -> Effect:
    at = 0
    for name in linear_parameters(effect):
        old = np.asarray(getattr(effect, name), dtype=float)
        new = old + np.reshape(mean[at : at + old.size], old.shape)
        effect = with_parameter(effect, name, float(new) if old.ndim == 0 else new)
        at += old.size
    return effect


def _inputs(effect: Effect, covariance: Array) -> tuple[Input, ...]:
    """One Input per parameter; correlation between parameters of one effect is not kept, that within an array is."""
    out, at = [], 0
    for name in linear_parameters(effect):
        value = np.asarray(getattr(effect, name))
        block = covariance[at : at + value.size, at : at + value.size]
        law = Normal(float(np.sqrt(block[0, 0]))) if value.ndim == 0 else MultivariateNormal(block)
        out.append(Input(effect.name, effect.where, name, law, "machine", EVIDENCE))
        at += value.size
    return tuple(out)


def improved(machine: Machine, found: tuple[tuple[Effect | None, tuple[Input, ...]], ...]) -> Machine:
    """A copy of the machine with the fitted effects in place of its own of the same id, and their Inputs."""
    for effect, inputs in found:
        if effect is None:
            continue
        kept = tuple(e for e in machine.effects if e.id != effect.id)
        names = {i.id for i in inputs}
        known = tuple(i for i in machine.inputs if i.id not in names)
        machine = replace(machine, effects=(*kept, effect), inputs=(*known, *inputs))
    return machine
