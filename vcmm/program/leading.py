"""Fields of a move for a tip led over the workpiece, and for the direction of the tool.

A tilted plane may be defined before the tool is square to it (G68.2 before G53.1, PLANE ... STAY): until then points lie in the
plane, and the rotary axes stay where they are.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from typing import Any, Protocol

from vcmm.program.frames import UNITY, AffineMap
from vcmm.program.moves import Move, Point, Posture

NO_AXIS_MOTION = 1e-9  # mm or rad below which an axis does not move


class Leader(Protocol):
    """Deciding state: vcmm.program.recorder.Recorder."""

    is_tcp_on: bool
    is_plane_tilted: bool
    over_face: bool
    aim: Point | None
    last_aim: Point | None
    posture: Posture | None
    world: AffineMap
    unmoved_axes: str
    sweeps: bool
    rotary: Point

    def release(self, letter: str) -> None: ...


def unit(direction: Point) -> Point | None:
    """Return the direction with length 1; None where it has none."""
    size = math.hypot(*direction)
    return None if size < 1e-9 else (direction[0] / size, direction[1] / size, direction[2] / size)


def column(world: AffineMap, axis: int) -> Point:
    """Return the direction of an axis of the program in the workpiece."""
    x, y, z = (row[axis] for row in world.matrix)
    return unit((x, y, z)) or (0.0, 0.0, 1.0)


def leading(r: Leader, rewritable: bool) -> dict[str, Any]:
    """Return the fields of a Move. A move in machine coordinates is not led; in a tilted plane the tool is square to it there as well."""
    if r.is_plane_tilted:
        axis = column(r.world, 2)
        return {
            "is_tip_led": rewritable, "tool_axis_start": axis, "tool_axis_end": axis, "posture": r.posture,
        }  # fmt: skip
    if not rewritable or not r.is_tcp_on:
        return {}
    if r.over_face:
        return {"is_tip_led": True, "over_face": True}
    return {
        "is_tip_led": True, "tool_axis_start": r.last_aim or r.aim, "tool_axis_end": r.aim, "posture": r.posture, "sweeps": r.sweeps,
    }  # fmt: skip


def let_go(r: Leader, start: Point, end: Point, rotary: Point | None) -> None:
    """Release axes that a block moves: they leave the places to which the control has led them."""
    for k, letter in enumerate("XYZ"):
        if abs(end[k] - start[k]) > NO_AXIS_MOTION:
            r.release(letter)
    for k, letter in enumerate("ABC"):
        if rotary is not None and abs(rotary[k] - r.rotary[k]) > NO_AXIS_MOTION:
            r.release(letter)


def name_axes(r: Leader, letters: str) -> None:
    """Name the axes of a block; in a frame that is turned one word moves all three linear axes."""
    if not r.unmoved_axes:
        return
    turned = r.world.matrix is not UNITY and any(k in "XYZ" for k in letters)
    for letter in letters + ("XYZ" if turned else ""):
        r.release(letter)


def unmoved_axes_after(move: Move, axes: str) -> str:
    """Return the axes whose positions after a move only the machine knows: all that a led one has moved."""
    if not move.is_tip_led or move.over_face:
        return axes
    turned = "ABC" if move.tool_axis_end is not None else "".join(a for a in axes if a in "ABC")
    return f"XYZ{turned}"


def waits_for_words(r: Leader) -> bool:
    """Return whether the control has led a linear axis, so that a block that does not name it must not move it."""
    return not r.is_tcp_on and any(letter in "XYZ" for letter in r.unmoved_axes)


def unmoved_axes_behind(r: Leader, moves: Sequence[Move]) -> str:
    """Return the same behind the last of many moves that were made without the recorder."""
    return unmoved_axes_after(moves[-1], r.unmoved_axes) if r.is_tcp_on and moves else r.unmoved_axes
