"""Tilted working planes of the G-code family: G68.2 and what belongs to it.

    G68.2 [P0] X Y Z I J K   origin, Euler angles: about Z, the new X, the new Z
    G68.2 P1 Q123 ...        I, J, K about X, Y, Z that stand still, one after another in the order of the digits of Q (123)
    G68.2 P2 Q0 ... Q3       Q1, Q2, Q3: three points, the first the origin, the second along X, the third on the side of +Y;
                             Q0 X Y Z R: a shift inside the plane and a turn about its normal
    G68.2 P3 Q1 X Y Z I J K, P3 Q2 I J K     origin and direction of X, direction of Z
    G53.1, G53.6 [P1, P2]    the rotary axes turn the tool square to the plane; G53.6 [H R] leads the tip meanwhile
    G69                      the plane ends, the rotary axes stay

Until G53.1 the points lie in the plane and the rotary axes stand. Sources: FANUC Series 30i user's manual B-63944EN and B-64304EN,
"tilted working plane command"; Yamazaki Mazak, "inclined-plane machining" (order of rotations of G68.2 P1); Haas: G268 with its Q, G253, G269.
"""

from __future__ import annotations

import math

from vcmm.program.faults import BlockFault
from vcmm.program.frames import AffineMap, rotation, translation, with_axes
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import AXES, IsoControl
from vcmm.program.iso.lengths import length
from vcmm.program.iso.motion import CENTRE_WORDS
from vcmm.program.moves import Point, Posture

DEFINES, SQUARES = ("G68.2", "G268"), ("G53.1", "G53.6", "G253")
LATER = "describe the plane by Euler angles, G68.2 X Y Z I J K"


def tilt_plane(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """Execute one block of a tilted plane. Raises BlockFault."""
    if code in DEFINES:
        _define(c, w, code, column)
    elif code in SQUARES:
        square(c, w, code, column)
    elif code in ("G269", "G255"):
        ends(c)
    else:
        what = f"{code}, a tilted working plane"
        refusal = f"{what} that depends on the position of the machine is not understood; {LATER}"
        c.assume(what, "passed over: the plane in force before", refusal, column=column)
        w.used |= set("XYZABCIJKPQRH")


def ends(c: IsoControl) -> None:
    """End the tilted plane, G69: coordinates as before; the rotary axes keep their angles until they are moved."""
    c.tilt, c.is_plane_tilted, c.posture, c.is_tilt_given = AffineMap(), False, None, False
    c.plane_words.clear()
    c.rebuild()


def square(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    """Turn the tool square to the plane by the rotary axes, before the next motion. P1, P2: with the first rotary axis positive, negative."""
    if c.tilt == AffineMap() and not c.is_tilt_given:
        c.assume(
            f"{code} without a plane",
            "passed over",
            f"{code} turns the tool square to the plane of G68.2, which is missing before it",
            column=column,
        )
        w.used |= set("PQRH")
        return
    number = w.whole("P", column) or 0
    if number not in (0, 1, 2):
        c.assume(f"P{number} of {code}", "the nearest position", f"{code} takes P0, P1 or P2", column=column)
        number = 0
    sign = {1: 1, 2: -1}.get(number, 0)
    c.posture = Posture(
        "first", sign=sign, keeps_tip=code == "G53.6", words=f"{code} P{number}" if sign else "", by_axis=not c.language.haas,
    )  # fmt: skip
    what = f"{code}, the tool square to the plane"
    if sign:
        wording = f"the position whose first rotary axis is {'positive' if sign > 0 else 'negative'}, as postprocessors count"
        c.assume(f"P{number} of {code}", wording, column=column, matters=False)
    c.assume(what, "the rotary axes turn before the next motion", column=column, matters=False)
    if code == "G53.6":
        _kept_point(c, w)
    c.is_plane_tilted = True
    c.rebuild()


def _kept_point(c: IsoControl, w: IsoWords) -> None:
    """Read H and R of G53.6: H is the length of the tool whose tip is kept; R the distance from it to the kept point, along the tool."""
    number, away = w.take("H"), w.take("R")
    if number and round(number) != c.tool:
        c.assume(
            f"H{number:g} of G53.6, which is no register of tool {c.tool}", "the tip of the tool in the spindle is fixed",
            f"G53.6 H{number:g} leads the tip of another length than that of tool {c.tool}; write H{c.tool}", column=w.column("H"),
        )  # fmt: skip
    if away:
        c.assume(
            f"R{away:g} of G53.6 (the fixed point of the tool)", "its tip",
            f"R{away:g} of G53.6 leads a point beside the tip, which is not understood; leave R out, so that the tip is fixed", column=w.column("R"),
        )  # fmt: skip


def _define(c: IsoControl, w: IsoWords, code: str, column: int) -> None:
    what = f"{code}, a tilted working plane"
    c.assume(
        what, "the path in the tilted plane, the tool square to it behind G53.1", column=column, matters=False
    )
    kind = w.whole("P", column) or 0
    if code == "G268" and not w.has("Q"):
        c.assume(
            "the order of the angles of G268",
            "Euler angles",
            "G268 without Q: state the order of its rotations, as in Q123",
            column=column,
        )
    made: AffineMap | None
    if kind == 0 and (code == "G68.2" or not w.has("Q")):
        made = _origin(c, w).then(_turns(((2, _angle(w, "I")), (0, _angle(w, "J")), (2, _angle(w, "K")))))
        if code == "G68.2" and w.has("Q"):
            _refuse(c, w, f"Q of {code} without P", "passed over", column)
    elif kind == 1 or code == "G268":
        made = _origin(c, w).then(_rotation_about_fixed_axes(w, column))
    elif kind in (2, 3):
        made = _in_parts(c, w, kind, column)
        if made is None:
            return
    else:
        _refuse(c, w, f"{code} P{kind}", "Euler angles", column)
        made = _origin(c, w).then(_turns(((2, _angle(w, "I")), (0, _angle(w, "J")), (2, _angle(w, "K")))))
    if w.has("R"):
        made = made.then(rotation(2, _angle(w, "R")))
    c.tilt, c.is_plane_tilted, c.posture, c.is_tilt_given = made, False, None, True
    c.rebuild()


def _refuse(c: IsoControl, w: IsoWords, what: str, value: str, column: int) -> None:
    c.assume(what, value, f"{what} is not understood; {LATER}", column=column)
    w.used |= set("PQR")


def _origin(c: IsoControl, w: IsoWords) -> AffineMap:
    return translation(_point([0.0 if (n := w.take(a)) is None else length(c, w, a, n) for a in AXES]))


def _angle(w: IsoWords, letter: str) -> float:
    return math.radians(w.take(letter) or 0.0)


def _turns(steps: tuple[tuple[int, float], ...]) -> AffineMap:
    made = AffineMap()
    for axis, angle in steps:
        made = made.then(rotation(axis, angle))
    return made


def _rotation_about_fixed_axes(w: IsoWords, column: int) -> AffineMap:
    """Return the rotation I about X, J about Y, K about Z, fixed axes; Q: their order, the first digit first."""
    order = str(w.whole("Q", column) or 123)
    if sorted(order) != ["1", "2", "3"]:
        raise BlockFault(
            w.column("Q"),
            f"Q{order} is no order of rotations; it holds 1, 2 and 3, as in Q123 (about X, then Y, then Z)",
        )
    angles = [_angle(w, k) for k in CENTRE_WORDS]
    return _turns(tuple((int(k) - 1, angles[int(k) - 1]) for k in reversed(order)))


def _in_parts(c: IsoControl, w: IsoWords, kind: int, column: int) -> AffineMap | None:
    """Return the plane of G68.2 P2, P3: given in blocks, Q0 to Q3 and Q1, Q2; None until the last one."""
    number = w.whole("Q", column)
    numbers = (0, 1, 2, 3) if kind == 2 else (1, 2)
    if number is None or number not in numbers:
        raise BlockFault(
            column, f"G68.2 P{kind} takes Q{', Q'.join(map(str, numbers))}, the number of its block"
        )
    parts = c.plane_words
    if number == min(numbers) or (number == 1 and kind == 2 and 0 not in parts):
        parts.clear()
    point = _point([0.0 if (n := w.take(a)) is None else length(c, w, a, n) for a in AXES])
    way = _point([w.take(k) or 0.0 for k in CENTRE_WORDS])
    parts[number] = (point, way, _angle(w, "R"))
    last = 3 if kind == 2 else 2
    if number != last:
        return None
    if any(k not in parts for k in range(1, last + 1)):
        raise BlockFault(column, f"G68.2 P{kind} needs its blocks Q1 to Q{last}, one after another")
    origin = parts[1][0]
    if kind == 2:
        x, side = _way(origin, parts[2][0]), _way(origin, parts[3][0])
        z = _cross(x, side)
    else:
        x, z = parts[1][1], parts[2][1]
    plane = with_axes(x, z)
    if plane is None:
        raise BlockFault(
            column, f"the directions of G68.2 P{kind} are parallel or zero; correct its points or vectors"
        )
    shift, _, turn = parts.get(0, ((0.0, 0.0, 0.0), (0.0, 0.0, 0.0), 0.0))
    parts.clear()
    return translation(origin).then(plane).then(translation(shift)).then(rotation(2, turn))


def _way(start: Point, end: Point) -> Point:
    return end[0] - start[0], end[1] - start[1], end[2] - start[2]


def _cross(u: Point, v: Point) -> Point:
    return u[1] * v[2] - u[2] * v[1], u[2] * v[0] - u[0] * v[2], u[0] * v[1] - u[1] * v[0]


def _point(values: list[float]) -> Point:
    return values[0], values[1], values[2]
