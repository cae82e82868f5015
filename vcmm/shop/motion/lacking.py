"""No machine turns an axis that it lacks: a program that asks for one is refused with its line, in whatever language it is written."""

from __future__ import annotations

from collections.abc import Sequence

from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.program.moves import Move
from vcmm.program.sensible import lacking, without_axis


def check_axes(moves: Sequence[Move], machine: Machine, name: str) -> None:
    """Raises UsageError at the first move that turns a rotary axis which the machine has not."""
    found = without_axis(moves, machine.axes)
    if found is not None:
        move, axis = found
        raise UsageError(f"{name}:{move.source.line}: {lacking(machine.axes, axis)}")
