"""Temperatures that errors of the machine depend on and the set-up does not state: 20 degC, with a remark."""

from __future__ import annotations

from collections.abc import Mapping

from vcmm.core.effect import required
from vcmm.core.machine import Machine
from vcmm.core.run import T0_DEG_C
from vcmm.program.setup import Setup


def with_temperatures(
    machine: Machine, setup: Setup, stated: Mapping[str, float]
) -> tuple[dict[str, float], tuple[str, ...]]:
    """Return the stated columns with temp_<sensor>_C at 20 degC for sensors that neither the set-up nor its log states, and a note about it."""
    logged = setup.log.sensors if setup.log is not None else {}
    open_: dict[str, list[str]] = {}
    for effect in machine.effects:
        for column in required(effect):
            sensor = column.removeprefix("temp_").removesuffix("_C")
            if column == f"temp_{sensor}_C" and column not in stated and sensor not in logged:
                open_.setdefault(sensor, []).append(effect.id)
    if not open_:
        return dict(stated), ()
    first, *_ = open_
    message = (
        f"{', '.join(dict.fromkeys(e for effects in open_.values() for e in effects))} of the machine file go with the temperature of {', '.join(open_)}, which the set-up does not "
        f'state: taken as 20 degC; write [temperature] {first} = "22 degC" into it where it is another'
    )
    return {**stated, **{f"temp_{s}_C": T0_DEG_C for s in open_}}, (message,)
