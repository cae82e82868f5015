"""Words of a straight cut of a lathe that draw a shape: A, the angle of the line; C, I and K, a chamfer at its end.

Sources: FANUC Series 30i operator's manual for lathes B-64304EN-1, "direct drawing dimension programming" (A, an option: the line from
the last point at A degrees from +Z, with one of its ends) and "chamfering and corner R" (Z with I or C, X with K or C: both legs have that
length, and the sign says which way the next block goes; C only where it names no axis); Haas lathe operator's manual, G01: A, I, K.
"""

from __future__ import annotations

import math
import re

from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import IsoControl
from vcmm.program.moves import Point

NO_MOTION_MM = 1e-9  # mm
_C_AXIS = re.compile(
    r"G12\.1|G112|G0?7\.1|G107|G28[^\n]*[CH]|G0+(?!\d)[^\n]*C[ \t]*[-+.\d]|^[ \t]*(?:N\d+[ \t]*)?(?:G0?1[ \t]*)?[CH][ \t]*[-+.\d]",
    re.MULTILINE | re.IGNORECASE,
)
_NOTE = re.compile(r"\([^()\n]*\)")


def turns_c(text: str) -> bool:
    """Return whether a program moves an axis C: at rapid, alone in a block, home, or by polar or cylindrical interpolation."""
    return _C_AXIS.search(_NOTE.sub("", text)) is not None


def draws(c: IsoControl) -> bool:
    """Return whether such words can stand in the block."""
    return c.language.lathe and c.motion == "G1" and c.winding is None and c.language.name != "okuma"


def angle_of(c: IsoControl, w: IsoWords) -> float | None:
    """Return a beside X or Z, rad; None where there is none, or where A is an axis of the machine."""
    axes = c.setup.axes
    if not w.has("A") or not any(w.has(k) for k in "XZUW") or (axes is not None and "A" in axes):
        return None
    if c.setup.drawing_dimensions is False or (c.setup.drawing_dimensions is None and not c.language.haas):
        refusal = (
            f"A{w.words['A'].text} is the angle of the line where the control has direct drawing dimensions, an option; "
            "write drawing_dimensions = true in the set-up file where it has, or program the end point itself"
        )
        if c.setup.drawing_dimensions is False:
            raise BlockFault(w.column("A"), refusal)
        c.assume(
            "what A of a straight cut is",
            "the angle of the line (direct drawing dimensions)",
            refusal,
            column=w.column("A"),
        )
    if any(w.has(k) for k in "XU") and any(w.has(k) for k in "ZW"):
        raise BlockFault(
            w.column("A"), "A beside X and Z is a line whose start is looked for; program the corner itself"
        )
    return math.radians(w.values.pop("A"))  # no word of an axis any more


def at_angle(c: IsoControl, w: IsoWords, p: Point, angle: float) -> Point:
    """Return the end of a line from the position of the tool, at an angle from +Z towards +X, one of its coordinates given."""
    by_x = any(w.has(k) for k in "XU")
    along = math.sin(angle) if by_x else math.cos(angle)
    way = p[0] - c.p[0] if by_x else p[2] - c.p[2]
    if abs(along) < 1e-9 or way / along < 0:
        raise BlockFault(
            w.column("A"),
            f"a line at {math.degrees(angle):g} degrees does not lead there; correct A or the end point",
        )
    reach = way / along
    if by_x:
        return (p[0], p[1], c.p[2] + reach * math.cos(angle))
    return (c.p[0] + reach * math.sin(angle), p[1], p[2])


def chamfer_of(c: IsoControl, w: IsoWords) -> tuple[str, float] | None:
    """Return the word C, I or K of a straight cut: letter and number as written; None where there is none, or where C is an axis."""
    for letter in "CIK":
        beside = any(w.has(k) for k in "XZUW") and not w.has(f",{letter}")
        if not (w.has(letter) and beside) or (letter == "C" and _c_is_axis(c, w)):
            continue
        return letter, w.values.pop(letter)
    return None


def _c_is_axis(c: IsoControl, w: IsoWords) -> bool:
    if c.setup.axes is not None:
        return "C" in c.setup.axes
    if c.c_turns:
        return True
    c.assume(
        "what C of a straight cut is", 'a chamfer: no block of this program moves an axis C (a set-up with machine = "lathe.toml" settles it)',
        column=w.column("C"),
    )  # fmt: skip
    return False


def cut_corner(c: IsoControl, start: Point, letter: str, size: float, column: int) -> None:
    """Cut the chamfer at the end of the move that was made. The sign is the way of the next block: I along X, K along Z, C along the other."""
    moved = [abs(c.p[i] - start[i]) > NO_MOTION_MM for i in (0, 2)]
    if moved[0] == moved[1]:
        raise BlockFault(
            column, f"{letter} is a chamfer at the end of a cut along X alone or Z alone; write ,C for others"
        )
    other = 2 if moved[0] else 0
    if letter != "C" and other != (0 if letter == "I" else 2):
        right = "I" if letter == "K" else "K"
        raise BlockFault(
            column,
            f"a chamfer behind a cut along {'XYZ'[2 - other]} is written with {right} (or C), not {letter}",
        )
    if not size:
        return
    ahead = list(c.p)
    ahead[other] += math.copysign(1.0, size)
    here, there = c.world.apply(c.p), c.world.apply((ahead[0], ahead[1], ahead[2]))
    c.corner(abs(size), "chamfer")
    c.corners[-1] = c.corners[-1]._replace(ahead=(there[0] - here[0], there[1] - here[1], there[2] - here[2]))
