"""CYCLE800: swivelled planes of Sinumerik.

CYCLE800(FR, TC, ST, MODE, X0, Y0, Z0, A, B, C, X1, Y1, Z1, DIR, FR_I, ...): shift, rotations, shift; without rotation and shift it ends them.

    MODE   bits 0-1, 2-3, 4-5: the axes (1 X, 2 Y, 3 Z) that A, B, C turn about; bits 6-7 how they count:
           00  axis by axis: about the first, the new second, the new third
           01  solid angle (64): A about Z, then B about the new Y
           10  projection angles (128): how the plane cuts the planes of the first two axes, then a turn about the third
           11  the rotary axes themselves (192): refused; how X and Y then lie, the manual leaves to a trial at the machine
    DIR    1, -1: the larger, smaller value of the axis that the builder has chosen as reference, rotary axis 1 in the editor;
           0: only the coordinates turn, the rotary axes stay
    FR     retraction of Z before swivelling, to a place of the machine builder: told

Source: Siemens, SINUMERIK 840D sl and 828D, operating manual Milling, "Swiveling (CYCLE800)"; Programming Manual Cycles; projection
angles: SINUMERIK 828D operating manual Turning 6FC5398-8CP40-5BA2, page 559 ("the new X-axis lies in the old ZX plane", and in turn).
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from vcmm.program.faults import BlockFault
from vcmm.program.frames import AffineMap, plane_through_angles, rotation, translation
from vcmm.program.moves import Posture
from vcmm.program.sinumerik.blocks import Item
from vcmm.program.sinumerik.state import SinumerikControl

BY_AXES, SOLID, PROJECTED, DIRECT = range(4)
OF_AXES = "the rotary axes themselves (MODE 192) of CYCLE800"
DIRECTION = 13  # number of the argument DIR


def swivel(i: SinumerikControl, item: Item, arguments: Sequence[float | None]) -> None:
    """Execute one CYCLE800. arguments: None where one is left out."""
    v = [x or 0.0 for x in (*arguments, *[None] * DIRECTION)][:DIRECTION]
    u, mode = i.r.unit, round(v[3]) or 57
    made = (
        translation((v[4] * u, v[5] * u, v[6] * u))
        .then(_rotation(i, item, mode, v[7:10]))
        .then(translation((v[10] * u, v[11] * u, v[12] * u)))
    )
    if made != AffineMap():
        i.r.assume(
            "how the machine tilts (CYCLE800)", "points lie in the tilted plane of the workpiece, the tool square to it",
            column=item.first, matters=False,
        )  # fmt: skip
        if round(v[0]):
            i.r.assume(
                f"FR = {v[0]:g} of CYCLE800 (retraction before swivelling)", "none: where to, the machine builder has set",
                column=item.first, matters=False,
            )  # fmt: skip
    additive = round(v[2]) % 10 == 1
    i.frames(i.modes.frame, i.modes.swivel.then(made) if additive else made)
    _set_direction(i, item, arguments[DIRECTION] if len(arguments) > DIRECTION else None)


def _rotation(i: SinumerikControl, item: Item, mode: int, angles: Sequence[float]) -> AffineMap:
    """Return the rotations of a mode; angles: A, B, C in deg."""
    kind = mode >> 6 & 3
    if kind == DIRECT and any(angles):
        i.r.assume(
            OF_AXES, "no plane: passed over",
            f"{OF_AXES} are not understood: how X and Y of the plane then lie is not stated; swivel axis by axis (MODE 57) or by solid angle (MODE 64)",
            column=item.first,
        )  # fmt: skip
        return AffineMap()
    if kind == PROJECTED and any(angles):
        return _rotation_by_projection(item, mode, angles)
    if kind == SOLID:
        if angles[2]:
            raise BlockFault(item.first, "CYCLE800 by solid angle takes A (about Z) and B (about Y); C is 0")
        return rotation(2, math.radians(angles[0])).then(rotation(1, math.radians(angles[1])))
    turned = AffineMap()
    for k in range(3):
        axis = (mode >> (2 * k) & 3) or k + 1
        turned = turned.then(rotation(axis - 1, math.radians(angles[k])))
    return turned


def _rotation_by_projection(item: Item, mode: int, angles: Sequence[float]) -> AffineMap:
    """Return the projection angles: angles a about the first and b about the second axis, as they are seen in the planes square to these, then a
    turn about the new third. With the axes X, Y: (0, cos a, sin a) and the new X (cos b, 0, -sin b) lie in the plane; others in turn.
    """
    first, second = mode & 3 or 1, mode >> 2 & 3 or 2
    if first == second:
        raise BlockFault(
            item.first, f"CYCLE800: MODE {mode} projects twice along one axis; give two different axes"
        )
    third = ({1, 2, 3} - {first, second}).pop()
    if (mode >> 4 & 3) not in (0, third):
        raise BlockFault(
            item.first, f"CYCLE800: MODE {mode} turns about an axis that it projects along already"
        )
    of_axis = dict(zip((first, second), (math.radians(angles[0]), math.radians(angles[1]))))
    in_plane = (
        third % 3 + 1
    )  # X of XY and YX, Y of YZ and ZY, Z of ZX and XZ: lies in the plane square to the other
    tilted = plane_through_angles(in_plane - 1, of_axis[in_plane], of_axis[in_plane % 3 + 1])
    if tilted is None:
        raise BlockFault(
            item.first, "the projection angles of CYCLE800 make no plane; keep them below 90 deg"
        )
    return tilted.then(rotation(third - 1, math.radians(angles[2])))


def _set_direction(i: SinumerikControl, item: Item, direction: float | None) -> None:
    """Set the position of the rotary axes, or none where only the coordinates turn."""
    r, is_plane = i.r, i.modes.swivel != AffineMap()
    r.is_plane_tilted, r.posture = is_plane, None
    if not is_plane:
        return
    if direction is None:
        r.assume(
            "DIR of CYCLE800, which is missing",
            "the nearest position of the rotary axes",
            column=item.first,
            matters=False,
        )
    elif direction == 0.0:
        r.assume(
            "DIR = 0 of CYCLE800 (the rotary axes stay)", "the coordinates turn, the tool stays as it is",
            "DIR = 0 of CYCLE800 turns the coordinates and leaves the rotary axes where they are, which is not understood; give DIR 1 or -1",
            column=item.first,
        )  # fmt: skip
        r.is_plane_tilted = False
    elif abs(direction) == 1.0:
        sense = round(direction)
        r.posture = Posture("first", larger=sense, binding=False, words=f"DIR = {sense} of CYCLE800")
        what = f"DIR = {sense} of CYCLE800"
        value = f"the {'larger' if sense > 0 else 'smaller'} value of rotary axis 1, the one of the head, else the one nearer to the bed"
        r.assume(what, value, column=item.first, matters=False)
    else:
        raise BlockFault(item.first, f"CYCLE800: DIR is -1, 0 or 1, found {direction:g}")
