"""TCH PROBE 400, 401, 408 to 414, 416 to 419 (datum, basic rotation) and 420 to 427 (results in Q parameters).

Source: HEIDENHAIN, TNC 640 User's Manual, "Programming of Measuring Cycles for Workpieces and Tools". A measured angle turns, a measured
datum shifts the preset of Q305 (0: that in force; 1 to 6: G54 to G59 of the set-up), so that the datum reads Q331 and Q332 (Q405, Q333).
Between its touches the probe goes over the clearance height Q260 wherever it is given. The measuring height Q261 is that of the middle of the ball
("coordinate of the ball tip center"), the clearance height that of its lowest point.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping

from vcmm.program.heidenhain.probing import FEED
from vcmm.program.heidenhain.touches import TouchCycle
from vcmm.program.probing import measuring_cycle, meeting
from vcmm.program.recorder import Recorder

LENGTHS_NOT = frozenset(
    (
        "Q247",
        "Q267",
        "Q272",
        "Q291",
        "Q292",
        "Q293",
        "Q301",
        "Q303",
        "Q304",
        "Q305",
        "Q307",
        "Q325",
        "Q381",
        "Q402",
        "Q423",
    )
)


def touch_cycle(
    r: Recorder, values: dict[str, float], number: int, given: Mapping[str, float], column: int
) -> None:
    """Runs a cycle of CYCLES with its parameters in the unit of the program. Raises ProgramFault."""
    q = {name: v if name in LENGTHS_NOT else v * r.unit for name, v in given.items()}
    cycle = TouchCycle(r, values, number, q, column)
    needed, action = CYCLES[number]
    with measuring_cycle(r, f"TCH PROBE {number}", FEED):
        cycle.check(*needed)
        action(cycle)


def _slope(c: TouchCycle) -> float:
    """Degrees by which the line through two touches leans from the axis along which it runs, counter-clockwise."""
    axis, sense, one, two = c.axis(2), c.sense(), c.point("Q263", "Q264"), c.point("Q265", "Q266")
    if one[1 - axis] == two[1 - axis]:
        c.recorder.fault(
            f"TCH PROBE {c.number}: both points lie at one place along the surface; set them apart", c.column
        )
    a, b = c.side(one, axis, sense), c.side(two, axis, sense)
    c.leave()
    lean = (b[axis] - a[axis]) / (b[1 - axis] - a[1 - axis])
    return math.degrees(math.atan(lean if axis == 1 else -lean))


def _rotation(c: TouchCycle) -> None:
    """400: by a line through two points."""
    found = _slope(c)
    c.angle(found)
    c.turn(found)


def _two_holes(c: TouchCycle) -> None:
    """401: by the line through the middles of two holes."""
    if c.value("Q402"):
        c.recorder.fault(
            "TCH PROBE 401: Q402 = 1 turns the rotary table, which is not understood; with Q402 = 0 the preset is turned",
            c.column,
        )
    (x1, y1), (x2, y2) = c.hole(*c.point("Q268", "Q269")), c.hole(*c.point("Q270", "Q271"))
    found = math.degrees(math.atan2(y2 - y1, x2 - x1))
    c.angle(found)
    c.turn(found)


def _middle(c: TouchCycle) -> None:
    """408, 409: the middle of a slot, of a ridge."""
    axis = c.axis(2)
    middle, width = c.width(c.point("Q321", "Q322"), axis, c.q["Q311"], c.number == 408)
    c.result(Q157=middle, Q166=width)
    reads: list[float | None] = [middle if k == axis else None for k in range(3)]
    should: list[float | None] = [c.value("Q405") if k == axis else None for k in range(3)]
    if c.value("Q381"):
        c.check("Q382", "Q383", "Q384")
        reads[2], should[2] = c.top(*c.point("Q382", "Q383", "Q384")), c.value("Q333")
    c.shift(reads, should)


def _rectangle(
    c: TouchCycle, middle: tuple[float, ...], sizes: tuple[float, ...], inside: bool
) -> tuple[float, float]:
    x, one = c.width(middle, 0, sizes[0], inside)
    y, two = c.width((x, middle[1]), 1, sizes[1], inside)
    c.result(Q151=x, Q152=y, Q154=one, Q155=two)
    return x, y


def _rectangle_datum(c: TouchCycle) -> None:
    """410, 411."""
    c.datum([*_rectangle(c, c.point("Q321", "Q322"), c.point("Q323", "Q324"), c.number == 410), None])


def _circle_datum(c: TouchCycle) -> None:
    """412, 413."""
    x, y, size = c.circle(c.point("Q321", "Q322", "Q262"), c.number == 412)
    c.result(Q151=x, Q152=y, Q153=size)
    c.datum([x, y, None])


def _corner(c: TouchCycle) -> None:
    """414: an outer corner by two points of the edge along X (Q263, Q264 and Q326 further) and two of that along Y (Q296, Q297; Q327)."""
    (x1, y1), (x3, y3) = c.point("Q263", "Q264"), c.point("Q296", "Q297")
    sense = (math.copysign(1.0, x1 - x3), math.copysign(1.0, y3 - y1))
    lower = [c.side((x1 + k * sense[0] * abs(c.q["Q326"]), y1), 1, sense[1]) for k in (0, 1)]
    left = [c.side((x3, y3 + k * sense[1] * abs(c.q["Q327"])), 0, sense[0]) for k in (0, 1)]
    c.leave()
    x, y, angles = meeting([lower, left], sense, c.feeler.radius)
    c.result(Q151=x, Q152=y)
    here = c.recorder.world.apply((x, y, c.recorder.p[2]))
    if c.value("Q304"):
        c.angle(angles[0])
        c.turn(angles[0])
        x, y, _ = c.recorder.world.undo(here)
    c.datum([x, y, None])


def _pitch_circle(c: TouchCycle) -> None:
    """416: the middle of the circle through three holes at the angles Q291, Q292, Q293."""
    x, y = c.point("Q273", "Q274")
    found = []
    for name in ("Q291", "Q292", "Q293"):
        angle = math.radians(c.q[name])
        found.append(
            (*c.hole(x + c.q["Q262"] / 2.0 * math.cos(angle), y + c.q["Q262"] / 2.0 * math.sin(angle)), 0.0)
        )
    made = c.feeler.circle(found, True)
    c.result(Q151=made.x, Q152=made.y, Q153=made.diameter - 2.0 * c.feeler.radius)
    c.datum([made.x, made.y, None])


def _height(c: TouchCycle) -> None:
    """417: a datum in the touch probe axis."""
    found = c.top(*c.point("Q263", "Q264", "Q294"))
    c.result(Q160=found)
    c.shift([None, None, found], [None, None, c.value("Q333")])


def _four_holes(c: TouchCycle) -> None:
    """418: where the lines through holes 1 and 3, and through 2 and 4 cross."""
    names = (("Q268", "Q269"), ("Q270", "Q271"), ("Q316", "Q317"), ("Q318", "Q319"))
    one, two, three, four = (c.hole(*c.point(*pair)) for pair in names)
    (ax, ay), (bx, by) = (three[0] - one[0], three[1] - one[1]), (four[0] - two[0], four[1] - two[1])
    det = ax * by - ay * bx
    if abs(det) < 1e-9:
        c.recorder.fault(
            "TCH PROBE 418: the lines through holes 1 and 3 and through 2 and 4 are parallel; check the order of the holes",
            c.column,
        )
    t = ((two[0] - one[0]) * by - (two[1] - one[1]) * bx) / det
    x, y = one[0] + t * ax, one[1] + t * ay
    c.result(Q151=x, Q152=y)
    c.datum([x, y, None])


def _one_axis(c: TouchCycle) -> None:
    """419: a datum in one axis; it then reads Q333."""
    axis = c.axis(3)
    found = _along(c)
    c.shift(
        [found if k == axis else None for k in range(3)],
        [c.value("Q333") if k == axis else None for k in range(3)],
    )


def _along(c: TouchCycle) -> float:
    """Coordinate of a surface along Q272 in sense Q267, at Q263, Q264 and the height Q261."""
    axis, sense = c.axis(3), c.sense()
    x, y, z = c.point("Q263", "Q264", "Q261")
    if axis == 2:
        return c.top(x, y, z, sense)
    found = c.coordinate((x, y), axis, sense)
    c.leave()
    return found


def _measured_angle(c: TouchCycle) -> None:
    """420: the angle of a line from the main axis of the plane."""
    c.angle(_slope(c) + (90.0 if c.axis(2) == 0 else 0.0))


def _measured_circle(c: TouchCycle) -> None:
    """421, 422."""
    nominal = c.point("Q273", "Q274", "Q262")
    x, y, size = c.circle(nominal, c.number == 421)
    c.result(Q151=x, Q152=y, Q153=size, Q161=x - nominal[0], Q162=y - nominal[1], Q163=size - nominal[2])


def _measured_rectangle(c: TouchCycle) -> None:
    """423, 424."""
    middle, sizes = c.point("Q273", "Q274"), c.point("Q282", "Q283")
    x, y = _rectangle(c, middle, sizes, c.number == 423)
    unit = c.recorder.unit
    found = (c.values["Q154"] * unit, c.values["Q155"] * unit)
    c.result(Q161=x - middle[0], Q162=y - middle[1], Q164=found[0] - sizes[0], Q165=found[1] - sizes[1])


def _measured_slot(c: TouchCycle) -> None:
    """425: a width from inside, the second side Q310 further along it."""
    axis, start, size = c.axis(2), c.point("Q328", "Q329"), c.q["Q311"]
    ends = []
    for side in (1.0, -1.0):
        expected = list(start)
        expected[axis] += side * size / 2.0
        expected[1 - axis] += c.value("Q310") if side < 0.0 else 0.0
        ends.append(c.coordinate(expected, axis, side))
    c.leave()
    _width_results(c, ends[1], ends[0])


def _measured_ridge(c: TouchCycle) -> None:
    """426: a width from outside, by a point of either side."""
    axis, one, two = c.axis(2), c.point("Q263", "Q264"), c.point("Q265", "Q266")
    sense = math.copysign(1.0, two[axis] - one[axis])
    ends = sorted((c.coordinate(one, axis, sense), c.coordinate(two, axis, -sense)))
    c.leave()
    _width_results(c, ends[0], ends[1])


def _width_results(c: TouchCycle, low: float, high: float) -> None:
    c.result(Q156=high - low, Q157=(high + low) / 2.0, Q166=high - low - c.q["Q311"])


def _measured_coordinate(c: TouchCycle) -> None:
    """427."""
    c.result(Q160=_along(c))


LINE = ("Q263", "Q264", "Q265", "Q266", "Q261")
BESIDE = ("Q263", "Q264", "Q261", "Q272", "Q267")
CYCLES: Mapping[int, tuple[tuple[str, ...], Callable[[TouchCycle], None]]] = {
    400: (LINE, _rotation), 401: (("Q268", "Q269", "Q270", "Q271", "Q261"), _two_holes), 408: (("Q321", "Q322", "Q311", "Q261"), _middle),
    409: (("Q321", "Q322", "Q311", "Q261"), _middle), 410: (("Q321", "Q322", "Q323", "Q324", "Q261"), _rectangle_datum),
    411: (("Q321", "Q322", "Q323", "Q324", "Q261"), _rectangle_datum), 412: (("Q321", "Q322", "Q262", "Q261"), _circle_datum),
    413: (("Q321", "Q322", "Q262", "Q261"), _circle_datum), 414: (("Q263", "Q264", "Q326", "Q296", "Q297", "Q327", "Q261"), _corner),
    416: (("Q273", "Q274", "Q262", "Q291", "Q292", "Q293", "Q261"), _pitch_circle), 417: (("Q263", "Q264", "Q294"), _height),
    418: (("Q268", "Q269", "Q270", "Q271", "Q316", "Q317", "Q318", "Q319", "Q261"), _four_holes), 419: (BESIDE, _one_axis),
    420: (LINE, _measured_angle), 421: (("Q273", "Q274", "Q262", "Q261"), _measured_circle), 422: (("Q273", "Q274", "Q262", "Q261"), _measured_circle),
    423: (("Q273", "Q274", "Q282", "Q283", "Q261"), _measured_rectangle), 424: (("Q273", "Q274", "Q282", "Q283", "Q261"), _measured_rectangle),
    425: (("Q328", "Q329", "Q311", "Q261"), _measured_slot), 426: (("Q263", "Q264", "Q265", "Q266", "Q311", "Q261"), _measured_ridge),
    427: (BESIDE, _measured_coordinate),
}  # fmt: skip
LATER: Mapping[int, str] = {
    402: "it turns by two studs", 403: "it turns a rotary axis", 404: "it sets a rotation", 405: "it turns the C axis", 415: "its first point is that of a wall in one version of the control, "
    "of the corner in another", 430: "a bolt circle", 431: "a plane", 441: "fast probing", 444: "probing in space",
}  # fmt: skip
