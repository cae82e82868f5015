"""Repair stored tables after a mistake was found in them."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.effect import Effect, own_nodes, with_parameter
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.diagnosis.log_mistakes import LOG, Mistake
from vcmm.physics.structure.abbe import AbbeCountedTwice


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
            _holding(e, by_place[pairs[e.where]]) if e.about.table_parameter and e.where in pairs else e
            for e in effects
        )
    return tuple(_times(e, mistake.factor) if _is_affected(e, mistake) else e for e in effects)


def _is_affected(effect: Effect, mistake: Mistake) -> bool:
    return bool(effect.about.table_parameter) and mistake.component in ("all", effect.where)


def _times(effect: Effect, factor: float) -> Effect:
    value = np.asarray(getattr(effect, effect.about.table_parameter), dtype=float) * factor
    return with_parameter(effect, effect.about.table_parameter, float(value) if value.ndim == 0 else value)


def _holding(effect: Effect, source: Effect) -> Effect:
    """Return the effect with the numbers of another component: node by node where the counts agree, else by position."""
    grid, other = _grid(effect), _grid(source)
    values = np.asarray(getattr(source, "values"), dtype=float)  # noqa: B009 - tables and splines have it
    if len(values) != len(grid):
        values = np.interp(grid, other, values)
    return with_parameter(effect, "values", values)


def _grid(effect: Effect) -> Array:
    nodes = own_nodes(effect)
    if nodes is None:
        raise UsageError(f"{effect.id} is no table over one axis; it cannot be exchanged")
    return nodes


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
            extra = np.interp(_grid(e), abbe.grids[0], moved[:, "XYZ".index(component[1])])
            values = np.asarray(getattr(e, "values"), dtype=float)  # noqa: B009
            e = with_parameter(e, "values", values - mistake.factor * extra)
        out.append(e)
    return tuple(out)
