"""Correct a program for a map of the face that it cut: subtract the excess height along Z where the tool passes.

The map is fixed to the part (work coordinates, mm); the tool touches a face with its nose centre's X, so a turning
tool is looked up by the nose radius beside its imaginary tip. A flat end mill is looked up where its axis is.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence

import numpy as np

from vcmm.compensation.contours import points
from vcmm.compensation.surface import SurfaceErrors
from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.program.moves import Move
from vcmm.program.setup import FANUC_TIPS, LINUXCNC_TIPS, Setup

KNOTS = 41  # along a move that crosses the face
Height = Callable[[Array, Array], Array]  # places x, y (n,) mm of the part -> height (n,) mm that is too much


def face_errors(
    moves: Sequence[Move], setup: Setup, height: Height, *, extent: tuple[Array, Array], lathe: bool, lines: tuple[int, int] | None = None
) -> SurfaceErrors:  # fmt: skip
    """Return the errors that the feed moves over the face leave. extent: (lowest, highest) x, y of the scan; lines: of the program, first and last.

    Raises UsageError where no feed move passes over the scanned face.
    """
    values: list[Array | None] = []
    used = []
    for move in moves:
        inside, value = _along(move, setup, height, extent, lathe)
        is_in_range = lines is None or lines[0] <= move.source.line <= lines[1]
        is_used = is_in_range and inside and move.kind in ("line", "arc")
        values.append(value if is_used else None)
        used += [move.source.line] if is_used else []
    if not used:
        where = "" if lines is None else f" in lines {lines[0]} to {lines[1]}"
        raise UsageError(
            f"no feed move{where} passes over the scanned face; check work offset and scan, or name the lines"
        )
    named = ", ".join(map(str, list(dict.fromkeys(used))[:6])) + (" ..." if len(set(used)) > 6 else "")
    joined = _with_joints(values)
    knots = np.cumsum([0, *map(len, joined)])
    whole = np.concatenate(joined)
    largest = float(np.abs(whole).max())
    return SurfaceErrors(
        moves=tuple(moves), knots=knots.astype(np.intp), value=whole, effects=(), points=len(used), rest_rms=0.0, largest=largest, against=(),
        origin=f"map of the scanned face: corrected along Z by up to {largest * 1e3:.3g} um in lines {named}; held at its edge beyond the scan",
    )  # fmt: skip


def _with_joints(values: Sequence[Array | None]) -> list[Array]:
    """Return e at the knots of every move: a move that is not over the face leads from the end of the one before to the begin of the next."""
    zero = np.zeros(3)
    out = []
    for i, value in enumerate(values):
        before, after = (values[k] if 0 <= k < len(values) else None for k in (i - 1, i + 1))
        ends = [zero if before is None else before[-1], zero if after is None else after[0]]
        out.append(np.array(ends) if value is None else value)
    return out


def _along(
    move: Move, setup: Setup, height: Height, extent: tuple[Array, Array], lathe: bool
) -> tuple[bool, Array]:
    """Return whether a move passes over the face, and e (KNOTS, 3) mm along it."""
    zero = np.array(setup.offsets.get(move.offset, (0.0, 0.0, 0.0)))
    place = points(move, np.linspace(0.0, 1.0, KNOTS)) - zero
    x, y = place[:, 0] + _nose(move, setup, lathe), np.zeros(KNOTS) if lathe else place[:, 1]
    low, high = extent
    within = (x >= low[0] - 1e-9) & (x <= high[0] + 1e-9)
    if not lathe:
        within &= (y >= low[1] - 1e-9) & (y <= high[1] + 1e-9)
    out = np.zeros((KNOTS, 3))
    out[:, 2] = height(x, y)
    over = place[
        within, :2
    ]  # a pass along the very edge of the scan is over it, a move that only meets the edge is not
    return len(over) > 1 and bool(np.ptp(over, axis=0).max() > 1e-6), out


def _nose(move: Move, setup: Setup, lathe: bool) -> float:
    """Return mm along X from the imaginary tip, or the centre that compensation leads, to the point of the nose that cuts a face."""
    tool = setup.tools.get(move.tool)
    if not lathe or tool is None or not tool.nose_radius:
        return 0.0
    tips = LINUXCNC_TIPS if (setup.dialect or "").startswith("linuxcnc") else FANUC_TIPS
    return -tips.get(tool.orientation, (0, 0))[0] * tool.nose_radius
