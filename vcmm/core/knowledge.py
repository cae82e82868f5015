"""Add effects and Inputs to a machine: every caller uses `add_knowledge`.

The error tables and lists of a machine file, the part, the environment and the lists of a scenario, the setting up of a
cut, and styli that were qualified: all go through `add_knowledge`, which adds up effects of one name and place and refuses a
quantity that would be drawn twice. That an effect acts on an axis of the machine is checked by Machine itself, that a run
has the columns it needs by `Machine.check_columns`.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import fields, replace

import numpy as np

from vcmm.core.effect import Effect, parameter_fields, required
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.inputs import EVERY, Input
from vcmm.core.laws import Law
from vcmm.core.machine import Machine


def add_knowledge(machine: Machine, effects: Sequence[Effect] = (), inputs: Sequence[Input] = ()) -> Machine:
    """Return the machine with further effects and Inputs.

    Raises UsageError for a quantity with two Inputs, and for an effect on an axis that the machine lacks.
    """
    inputs_before: list[Input] = []
    for item in (*machine.inputs, *inputs):
        twice = duplicate_text(item, inputs_before)
        if twice:
            raise UsageError(twice)
        inputs_before.append(item)
    return replace(
        machine, effects=tuple(merge_effects([*machine.effects, *effects])), inputs=tuple(inputs_before)
    )


def duplicate_text(quantity: Input, others: Sequence[Input]) -> str:
    """Return the error text for a quantity that already has an Input: it would be sampled twice from one stream. '' where it has none."""
    mine = {m.id for m in _single_quantities(quantity)}
    for other in others:
        name = next((m.id for m in _single_quantities(other) if m.id in mine), None)
        if name is not None:
            evidence = f" ({other.evidence})" if other.evidence else ""
            return f"{name} has an input already{evidence}; keep one of the two"
    return ""


def _single_quantities(quantity: Input) -> tuple[Input, ...]:
    """Return the quantities whose whole uncertainty an Input states; a common cause is one quantity beside theirs."""
    return (quantity,) if not quantity.members or isinstance(quantity.law, Law) else quantity.members


def merge_effects(effects: Sequence[Effect]) -> list[Effect]:
    """Add effects of one name and place into one where they differ only in numbers in which they are linear.

    An Input names an effect by name and place: two of them (a table and a further known effect) would count twice.
    """
    out: list[Effect] = []
    for effect in effects:
        match = next((i for i, e in enumerate(out) if e.id == effect.id and addable(e, effect)), None)
        if match is None:
            out.append(effect)
            continue
        linear = [f.name for f in parameter_fields(effect) if not f.metadata["scan"]]
        sums = {n: getattr(out[match], n) + getattr(effect, n) for n in linear}
        out[match] = replace(out[match], **sums)
    return out


def addable(first: Effect, second: Effect) -> bool:
    """Return whether two effects of one id differ in nothing but numbers in which they are linear."""
    linear = {f.name for f in parameter_fields(first) if not f.metadata["scan"]}
    rest = [f.name for f in fields(first) if f.name not in linear]
    return all(np.array_equal(getattr(first, n), getattr(second, n)) for n in rest)


def targets(machine: Machine, quantity: Input) -> list[Effect]:
    """Return the effects an Input acts on. Raises UsageError when there is none."""
    hit = [e for e in machine.effects if e.name == quantity.effect and quantity.where in (EVERY, e.where)]
    if not hit:
        ids = sorted({e.id for e in machine.effects})
        raise UsageError(
            f"{quantity.id}: the machine has no such effect.{choose_from(f'{quantity.effect}[{quantity.where}]', ids)}"
        )
    if quantity.where != EVERY and len(hit) > 1:
        raise UsageError(
            f"{quantity.id} acts on {len(hit)} effects of that name; make them one effect, or tell them apart by their place"
        )
    return hit


def acted_on(machine: Machine, quantity: Input) -> tuple[Effect, ...]:
    """Return the effects that a single quantity changes: those that need a column, those that have a parameter; or none."""
    if quantity.is_channel:
        return tuple(e for e in machine.effects if quantity.parameter in required(e))
    has_effect = any(
        e.name == quantity.effect and quantity.where in (EVERY, e.where) for e in machine.effects
    )
    return tuple(targets(machine, quantity)) if has_effect else ()
