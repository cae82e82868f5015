"""Cutter radius compensation: from what the interpreter has recorded to the moves of the centre path (vcmm.nc.radius)."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

from vcmm.nc.control import Compensation
from vcmm.nc.moves import NO_ROTARY as NO_SHIFT
from vcmm.nc.moves import Move, Point
from vcmm.nc.radius import FANUC_B, LINUXCNC, centre_path

# Orientation of a turning tool, 1 to 9: where its imaginary tip lies as seen from the centre of the nose, in X and Z.
# 0 and 9 are the centre itself. Source: Fanuc, "imaginary tool nose"; LinuxCNC, "lathe tool orientation".
FANUC_TIPS: dict[int, tuple[int, int]] = {
    1: (1, 1), 2: (1, -1), 3: (-1, -1), 4: (-1, 1), 5: (0, 1), 6: (1, 0), 7: (0, -1), 8: (-1, 0), 9: (0, 0),
}  # fmt: skip
LINUXCNC_TIPS: dict[int, tuple[int, int]] = {
    1: (-1, 1), 2: (-1, -1), 3: (1, -1), 4: (1, 1), 5: (0, 1), 6: (-1, 0), 7: (0, -1), 8: (1, 0), 9: (0, 0),
}  # fmt: skip


def resolve_compensation(
    moves: Sequence[Move], sides: Sequence[Compensation | None], words: str, file: str
) -> list[Move]:
    """Moves of the centre path. `sides`: what is in force on each move, None where nothing is. Raises ModelLimit."""
    style, tips = (LINUXCNC, LINUXCNC_TIPS) if words == "o" else (FANUC_B, FANUC_TIPS)
    names = [None if s is None else s.side for s in sides]
    radii = [0.0 if s is None else s.radius for s in sides]
    shifts = [_shift(s, tips) if m.plane == "ZX" else NO_SHIFT for s, m in zip(sides, moves)]
    return centre_path(moves, names, radii, style, shifts, file)


def _shift(side: Compensation | None, tips: Mapping[int, tuple[int, int]]) -> Point:
    """From the centre of the nose to the imaginary tip that the offsets of a turning tool are measured at."""
    if side is None or not side.orientation:
        return NO_SHIFT
    x, z = tips[side.orientation]
    return (x * abs(side.radius), 0.0, z * abs(side.radius))
