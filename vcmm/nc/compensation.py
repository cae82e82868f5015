"""Cutter radius compensation: from what the interpreter has recorded to the moves of the centre path (vcmm.nc.radius)."""

from __future__ import annotations

import math
from collections.abc import Sequence

from vcmm.nc.control import Compensation
from vcmm.nc.moves import Move, Point
from vcmm.nc.radius import FANUC_B, LINUXCNC, centre_path

# Orientation of a turning tool (1 to 9, its imaginary tip as seen from the nose centre): direction in X and Z.
# LinuxCNC and Fanuc count alike: 1 to 4 the corners, 5 to 8 the sides, 0 and 9 the centre of the nose itself.
TIPS: dict[int, tuple[int, int]] = {
    1: (1, 1), 2: (1, -1), 3: (-1, -1), 4: (-1, 1), 5: (0, 1), 6: (1, 0), 7: (0, -1), 8: (-1, 0), 0: (0, 0), 9: (0, 0),
}  # fmt: skip


def resolve_compensation(
    moves: Sequence[Move], sides: Sequence[Compensation | None], words: str, file: str
) -> list[Move]:
    """Moves of the centre path. `sides`: what is in force on each move, None where nothing is. Raises ModelLimit."""
    style = LINUXCNC if words == "o" else FANUC_B
    names = [None if s is None else s.side for s in sides]
    radii = [0.0 if s is None else s.radius for s in sides]
    shifts = [_shift(s) for s in sides]
    return centre_path(moves, names, radii, style, shifts, file)


def _shift(side: Compensation | None) -> Point:
    """From the centre of the nose to the imaginary tip that the offsets of a turning tool are measured at."""
    if side is None or not side.orientation or math.isnan(side.radius):
        return (0.0, 0.0, 0.0)
    x, z = TIPS[side.orientation]
    return (x * abs(side.radius), 0.0, z * abs(side.radius))
