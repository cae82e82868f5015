"""Sizes that physics does not have: outside them a name is a candidate, however well it fits.

An effect declares them where there are any (`Typical.bounds`, `one_sided`). An Abbe arm is bounded by the machine: no reference line lies
farther from the tip than the diagonal of its travels and tools. A size is outside where its whole 95 % coverage interval is.
"""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vcmm.core.effect import Effect, parameter_fields
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.core.units import in_unit
from vcmm.learn.diagnosis.estimates import Estimate

ARM = "arm"


def beyond(effect: Effect | None, found: Mapping[str, Estimate], machine: Machine, offset: Array) -> str:
    """Why a fitted effect cannot be, in words; "" where it can. offset (n, 3) mm: tips from the last frame."""
    if effect is None:
        return ""
    if effect.diagnosis.is_never_negative and _negative(effect):
        return f"{effect.name} cannot be below zero"
    back = {name: shown for shown, name in effect.about.aliases.items()}
    for spec in parameter_fields(effect):
        usual, estimate = spec.metadata["typical"], found.get(back.get(spec.name, spec.name))
        if usual is None or usual.bounds is None or estimate is None:
            continue
        low, high = (in_unit(b, estimate.unit) for b in usual.bounds)
        if estimate.interval95[1] < low or estimate.interval95[0] > high:
            return f"{spec.name} = {estimate.value:.3g} {estimate.unit} lies outside {low:.3g} to {high:.3g}: {usual.why}"
    arm = found.get(ARM)
    if effect.diagnosis.size_name == ARM and arm is not None:
        reach = in_unit(_reach(machine, offset), arm.unit)
        if arm.interval95[0] > reach:
            return f"an arm of {arm.value:.3g} {arm.unit} lies outside the machine, whose travels and tools reach {reach:.3g} {arm.unit}"
    return ""


def _negative(effect: Effect) -> bool:
    linear = [f.name for f in parameter_fields(effect) if not f.metadata["scan"]]
    return any(float(np.min(getattr(effect, name))) < 0.0 for name in linear)


def _reach(machine: Machine, offset: Array) -> float:
    """mm: the diagonal of the travels, and the longest tool."""
    travels = [float(np.ptp(a.travel)) for a in machine.axes.values() if not a.rotary]
    return float(np.linalg.norm(travels)) + float(np.linalg.norm(offset, axis=1).max(initial=0.0))
