"""Cutter radius compensation: the hook through which the moves of the programmed contour become those of the centre path."""

from __future__ import annotations

from collections.abc import Sequence

from vcmm.errors import ModelLimit
from vcmm.nc.control import Compensation
from vcmm.nc.moves import Move


def resolve_compensation(moves: Sequence[Move], sides: Sequence[Compensation | None]) -> list[Move]:
    """Moves of the centre path. `sides`: what is in force on each move, None where nothing is."""
    first = next(i for i, side in enumerate(sides) if side is not None)
    if all(side is None or side.radius == 0.0 for side in sides):
        return list(moves)
    source = moves[first].source
    raise ModelLimit(
        f"line {source.line}: cutter radius compensation (G41, G42) is not resolved by this version; post the program for the "
        "centre of the tool, or remove G41 and G42"
    )
