"""Convert canonical moves to swept tools, in workpiece axes."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.program.moves import PLANES, Move
from vcmm.program.setup import Tool
from vcmm.shop.cutting import tools as shapes
from vcmm.shop.cutting.sweeps import ARC, HELIX, LINE, UP, Sweep, check_sweep
from vcmm.shop.machining.rotary import RotaryMotion
from vcmm.shop.machining.rotary_sweep import NO_TURN_RAD as STILL_TURNED
from vcmm.shop.machining.rotary_sweep import in_workpiece

MOVING = ("rapid", "line", "arc", "thread")
NO_MOTION_MM = 1e-12  # mm


def cutter(tool: Tool) -> shapes.Cutter:
    """Return the solid of revolution of a tool of the set-up. Raises UsageError where a size is missing."""
    if tool.shape == "turning":
        if not tool.nose_radius:
            raise UsageError(
                f'tool {tool.number} has no nose radius; add nose_radius = "0.8 mm" to [tools.{tool.number}] of the set-up'
            )
        return shapes.insert(tool.nose_radius)
    if not tool.diameter:
        raise UsageError(
            f'tool {tool.number} has no diameter; add diameter = "10 mm" to [tools.{tool.number}] of the set-up'
        )
    radius = tool.diameter / 2
    if tool.shape == "ball":
        return shapes.ball(radius)
    if tool.shape == "bull":
        return shapes.bull(radius, tool.corner_radius)
    return shapes.drill(radius) if tool.shape == "drill" else shapes.flat(radius)


def part_sweep(
    moves: Sequence[Move], tools: Mapping[int, Tool], machine: Machine
) -> tuple[Sweep, RotaryMotion | None]:
    """Return (all motions in workpiece axes, how they lie on the moves; None where all rotary axes stay at zero and tools along Z)."""
    base = sweep_of_moves(moves, tools)
    turned, offset, rapid = _turning_rows(moves, base)
    if not (np.abs(turned) > STILL_TURNED).any() and np.array_equal(
        base.axis, np.broadcast_to(UP, base.axis.shape)
    ):
        return base, None
    return in_workpiece(machine, base, turned, offset, rapid)


def driven_sweep(
    moves: Sequence[Move], kept: Sequence[int], tools: Mapping[int, Tool], machine: Machine
) -> tuple[Sweep, RotaryMotion]:
    """Return the motions `kept` (indices of moves) alone, in workpiece axes, and how they lie on the moves."""
    flat = sweep_of_moves([moves[i] for i in kept], tools)
    base = replace(flat, move=np.array(kept, dtype=np.intp)[flat.move])
    return in_workpiece(machine, base, *_turning_rows(moves, base))


def _turning_rows(moves: Sequence[Move], base: Sweep) -> tuple[Array, Array, np.typing.NDArray[np.bool_]]:
    """Return A, B, C (m, 2, 3) rad at both ends of the rows, tool offsets (m, 3) mm, and which (m,) are rapids."""
    kept = [moves[i] for i in base.move.tolist()]
    turned = np.array([(m.rotary_start, m.rotary_end) for m in kept], dtype=float)
    offset = np.array([m.tool_offset for m in kept], dtype=float)
    return turned, offset, np.array([m.kind == "rapid" for m in kept], dtype=bool)


def sweep_of_moves(moves: Sequence[Move], tools: Mapping[int, Tool]) -> Sweep:
    """Return all motions as a sweep, rapids too: a rapid through the part cuts it. `move` is the index of each row in `moves`.

    Tip positions of the machine, which are those of workpiece axes while all rotary axes are at zero; `part_sweep` turns
    them. Raises UsageError for tools that are not in the table.
    """
    rows = [(i, m) for i, m in enumerate(moves) if m.kind in MOVING and _travels(m) and _has_tool(m, tools)]
    if not rows:
        raise UsageError("the program moves no tool; nothing is cut")
    numbers = list(dict.fromkeys(m.tool for _, m in rows))
    solids = tuple(cutter(tools[n]) for n in numbers)
    start, end = (np.array([getattr(m, side) for _, m in rows]) for side in ("start", "end"))
    centre, normal, turn, kind = zip(*(_arc(m) for _, m in rows))
    up = np.array([tools[m.tool].direction for _, m in rows])
    return check_sweep(
        Sweep(
            start=start, end=end, centre=np.array(centre), normal=np.array(normal), turn=np.array(turn), kind=np.array(kind),
            tool=np.array([numbers.index(m.tool) for _, m in rows]), move=np.array([i for i, _ in rows]), axis=up, tools=solids,
        )
    )  # fmt: skip


def _travels(move: Move) -> bool:
    if move.centre is not None or math.dist(move.start, move.end) > NO_MOTION_MM:
        return True
    return max(abs(b - a) for a, b in zip(move.rotary_start, move.rotary_end)) > STILL_TURNED


def _has_tool(move: Move, tools: Mapping[int, Tool]) -> bool:
    """Return whether a move has a tool of the table; a rapid without one is a way to the tool changer. A probe cuts nothing."""
    if move.tool in tools:
        return tools[move.tool].shape != "probe"
    if move.kind == "rapid":
        return False
    if not move.tool:
        raise UsageError(
            f"line {move.source.line} cuts with the tool that is in the spindle, none has been called; add [tools.spindle] with length "
            "and diameter to the set-up, or the tool change (T1 M6) to the program"
        )
    numbers = [str(n) for n in tools]
    raise UsageError(
        f"line {move.source.line} cuts with tool {move.tool}, which is not in the set-up."
        f"{choose_from(str(move.tool), numbers) if numbers else ' Add [tools.1] with length, diameter and shape.'}"
    )


def _arc(move: Move) -> tuple[tuple[float, float, float], tuple[float, float, float], float, int]:
    """Return the centre, plane normal, signed turn about it and kind of one move; nan and 0 for a line."""
    nothing = (math.nan, math.nan, math.nan)
    if move.centre is None:
        return nothing, nothing, 0.0, LINE
    a, b, c = PLANES[move.plane]
    begin = math.atan2(move.start[b] - move.centre[b], move.start[a] - move.centre[a])
    stop = math.atan2(move.end[b] - move.centre[b], move.end[a] - move.centre[a])
    turn = (begin - stop if move.clockwise else stop - begin) % (2 * math.pi)
    if turn < 1e-9:  # start and end in one direction from the centre: a whole turn
        turn = 2 * math.pi
    turn += 2 * math.pi * (move.turns - 1)
    normal = tuple(1.0 if i == c else 0.0 for i in range(3))
    kind = HELIX if abs(move.end[c] - move.start[c]) > NO_MOTION_MM else ARC
    return move.centre, normal, -turn if move.clockwise else turn, kind  # type: ignore[return-value]
