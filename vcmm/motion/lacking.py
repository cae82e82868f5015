"""No machine turns an axis that it lacks: a program that asks for one is refused with its line, in whatever language it is written."""

from __future__ import annotations

from collections.abc import Sequence

from vcmm.core.axes import ROTARY
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.nc.moves import Move

STILL = 1e-9  # rad


def check_axes(moves: Sequence[Move], machine: Machine, name: str) -> None:
    """Raises UsageError at the first move that turns a rotary axis which the machine has not."""
    lacked = [i for i, a in enumerate(ROTARY) if a not in machine.axes]
    if not lacked:
        return
    for m in moves:
        for i in lacked:
            if abs(m.rotary_end[i] - m.rotary_start[i]) > STILL:
                has = ", ".join(a for a in machine.axes if a[0] in ROTARY) or "none"
                raise UsageError(
                    f"{name}:{m.source.line}: this turns axis {ROTARY[i]}, which {machine.name} lacks (its rotary axes: {has}); take the word "
                    "out, name another machine in the set-up, or add the axis to structure and [axes] of the machine file"
                )
