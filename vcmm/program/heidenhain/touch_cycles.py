"""TCH PROBE 400, 401, 408 to 414, 416 to 419 (datum, basic rotation) and 420 to 427 (results in Q parameters).

Source: HEIDENHAIN, TNC 640 User's Manual, "Programming of Measuring Cycles for Workpieces and Tools". A measured angle turns, a measured
datum shifts the preset of Q305 (0: that in force; 1 to 6: G54 to G59 of the set-up), so that the datum reads Q331 and Q332 (Q405, Q333).
Between its touches the probe goes over the clearance height Q260 wherever it is given. The measuring height Q261 is that of the middle of the ball
("coordinate of the ball tip center"), the clearance height that of its lowest point.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import NamedTuple

from vcmm.program.cutter import Flat
from vcmm.program.cycle_tables import Cycle, cycle, in_units
from vcmm.program.heidenhain.probing import CLEARANCE, FEED
from vcmm.program.measuring import Findings, MeasuringCycle, circle, rectangle, width
from vcmm.program.moves import Point
from vcmm.program.probing import at, correct_turn, correct_zero, measuring_cycle, meeting
from vcmm.program.recorder import Recorder

PRESETS = 6
FARTHEST = 130.0  # mm that a touch goes without an answer: DIST of the touch probe table, whose value is the machine's


@dataclass(eq=False)
class TouchCycle(MeasuringCycle):
    """One cycle. parameters: its parameters as programmed; values: Q parameters of the program, where results go."""

    values: dict[str, float]
    number: int
    parameters: Mapping[str, float]

    # -- ways --
    def leave(self) -> None:
        """Move to the clearance height, where there is one."""
        if self.v.has("over"):
            self.go(at(self.r.p, 2, self.v["over"]))

    def stand(self, x: float, y: float, height: float | None = None) -> None:
        """Move the lowest point of the ball to `height` at a place; without a height its middle to the measuring height Q261."""
        self.leave()
        self.go((x, y, self.r.p[2]))
        self.go(at(self.r.p, 2, self.v["height"] - self.feeler.radius if height is None else height))

    def approach(self, over: Point, ray: Flat, half: float, inside: bool) -> None:
        """Approach: in a feature that is too narrow for the set-up clearance it begins at the middle (manual, 408 and 412)."""
        reach = max(half - self.before(), 0.0) if inside else half + self.before()
        self.stand(over[0] + reach * ray[0], over[1] + reach * ray[1])

    def back(self, over: Point) -> None:
        """Move back: the tool stays beside the surface."""

    def finish(self, start: Point) -> None:
        self.leave()

    def before(self) -> float:
        """Return the mm between the middle of the ball and the surface from where probing begins."""
        return CLEARANCE + self.v["clear"] + self.feeler.radius

    # -- touches --
    def side(self, expected: Flat, axis: int, sense: float) -> Point:
        """Return the tip position at the touch of a surface expected at (x, y), along X or Y; the ball then is beside it."""
        start = list(expected)
        start[axis] -= sense * self.before()
        self.stand(start[0], start[1])
        self.feeler.surface(axis, expected[axis], sense)
        return self.r.skip or self.r.p

    def coordinate(self, expected: Flat, axis: int, sense: float) -> float:
        """Measure the coordinate of a surface that is expected at (x, y), along X or Y."""
        return self.side(expected, axis, sense)[axis] + sense * self.feeler.radius

    def top(self, x: float, y: float, expected: float, sense: float = -1.0) -> float:
        """Measure the height of a surface square to Z, from above."""
        self.stand(x, y, expected - sense * (CLEARANCE + self.v["clear"]))
        reads = self.feeler.surface(2, expected, sense)
        self.leave()
        return reads

    def angles(self) -> list[float]:
        """Return the angles of the touches of a circle, rad: four, or Q423 = 3, from Q325 on, Q247 apart."""
        count = round(self.v.without("points", 4.0))
        if count not in (3, 4):
            self.r.fault(f"TCH PROBE {self.number}: Q423 = {count} must be 3 or 4 points", self.column)
        step = self.v.without("step", 90.0) or 360.0 / count
        return [math.radians(self.v["first"] + k * step) for k in range(count)]

    def hole(self, x: float, y: float) -> tuple[float, float]:
        """Measure the middle of a hole of unknown size: by four points from its expected place."""
        r, tips = self.r, []
        self.stand(x, y)
        for k in range(4):
            angle = k * math.pi / 2.0
            tips.append(self.feeler.until((math.cos(angle), math.sin(angle), 0.0), FARTHEST))
            if tips[-1] is None:
                r.fault(
                    f"TCH PROBE {self.number} finds no hole at X {x:g}, Y {y:g} (mm), and the cycle does not say how large it is; state it in the set-up file, as "
                    f'[[surfaces]] with point = "{x:g} {y:g} 0 mm", diameter and inside = true',
                    self.column,
                )
        self.leave()
        fit = self.feeler.circle([t for t in tips if t is not None], True)
        return fit.x, fit.y

    # -- what the machine sets --
    def preset(self) -> str:
        """Return the work offset of Q305; '' for one that the set-up has not."""
        r, number = self.r, self.v.number("preset")
        if number > PRESETS:
            r.assume(
                f"preset {number}", "not written: the set-up has 1 to 6, which are G54 to G59",
                f"TCH PROBE {self.number} writes preset {number} (Q305), which the set-up has not; 1 to 6 are G54 to G59 there, 0 is the one in force",
            )  # fmt: skip
            return ""
        return r.offset if number == 0 else f"G{53 + number}"

    def datum(self, reads: Sequence[float | None], should: Sequence[float | None]) -> None:
        """Set the datum: the found values read so from here on, and the touch probe axis too where Q381 = 1 asks for it."""
        actual, wanted = [*reads], [*should]
        if self.v["also_z"]:
            self.check("Q382", "Q383", "Q384")
            actual[2], wanted[2] = self.top(self.v["z_x"], self.v["z_y"], self.v["z_z"]), self.v["new_z"]
        name = self.preset()
        if name:
            correct_zero(self.r, name, actual, wanted)
            self.r.refresh()

    def turn(self, degrees: float) -> None:
        """Turn by a basic rotation: the found angle reads Q307 from here on."""
        name = self.preset()
        if name:
            correct_turn(self.r, name, math.radians(degrees - self.v["new_angle"]))
            self.r.refresh()

    # -- remarks --
    def check(self, *needed: str) -> None:
        missing = next((name for name in needed if name not in self.parameters), None)
        if missing:
            self.r.fault(f"TCH PROBE {self.number} needs {missing}; add it", self.column)

    def axis(self, most: int) -> int:
        """Return the axis of Q272."""
        if self.v["axis"] not in range(1, most + 1):
            self.r.fault(
                f"TCH PROBE {self.number}: Q272 = {self.v['axis']:g} must be {'1, 2 or 3' if most == 3 else '1 or 2'}, the axis along which it measures",
                self.column,
            )
        return self.v.number("axis") - 1

    def sense(self) -> float:
        """Return the sense of Q267."""
        if self.v["sense"] not in (-1.0, 1.0):
            self.r.fault(
                f"TCH PROBE {self.number}: Q267 = {self.v['sense']:g} must be -1 or +1, the way to the surface",
                self.column,
            )
        return self.v["sense"]


class TouchRow(NamedTuple):
    """A row; results, as in "Q151=x Q161=-x" (-: less what was expected); what the machine sets by them."""

    row: Cycle[Callable[[TouchCycle], Findings]]
    results: str
    then: Callable[[TouchCycle, Findings], None] = lambda c, findings: None


def touch_cycle(
    r: Recorder, values: dict[str, float], number: int, parameters: Mapping[str, float], column: int
) -> None:
    """Run a cycle of CYCLES with its parameters in the unit of the program. Raises ProgramFault."""
    row, results, then = CYCLES[number]
    c = TouchCycle(r, row.read(parameters, in_units(r.unit, r.unit)), column, values, number, parameters)
    with measuring_cycle(r, f"TCH PROBE {number}", FEED):
        c.check(*row.required_names)
        if parameters.get("Q301") == 0 and c.v.has("over"):
            r.remark(
                "Q301 = 0: between its touches the probe goes over Q260 here, where the machine stays at the measuring height", column
            )  # fmt: skip
        findings = row.primitive(c)
        for name, _, meaning in (word.partition("=") for word in results.split()):
            should, reads = findings[meaning.lstrip("-")]
            value = reads - should if meaning.startswith("-") else reads
            values[name] = value if meaning == "angle" else value / r.unit
        then(c, findings)


# -- what is measured -----------------------------------------------------------------------------------------------------
def _slope(c: TouchCycle) -> Findings:
    """Return the Angle in degrees of the line through two touches from its main axis, counter-clockwise."""
    axis, sense, first, second = c.axis(2), c.sense(), (c.v["x"], c.v["y"]), (c.v["x2"], c.v["y2"])
    if first[1 - axis] == second[1 - axis]:
        c.r.fault(
            f"TCH PROBE {c.number}: both points lie at one place along the surface; set them apart", c.column
        )
    a, b = c.side(first, axis, sense), c.side(second, axis, sense)
    c.leave()
    lean = (b[axis] - a[axis]) / (b[1 - axis] - a[1 - axis])
    return {"angle": (0.0, math.degrees(math.atan(lean if axis == 1 else -lean)))}


def _from_main_axis(c: TouchCycle) -> Findings:
    """Return the angle of a line from the main axis of the plane."""
    angle = _slope(c)["angle"][1] + (90.0 if c.axis(2) == 0 else 0.0)
    return {"angle": (0.0, angle)}


def _two_holes(c: TouchCycle) -> Findings:
    """Return the line through the middles of two holes."""
    if c.v["table"]:
        c.r.fault(
            "TCH PROBE 401: Q402 = 1 turns the rotary table, which is not understood; with Q402 = 0 the preset is turned",
            c.column,
        )
    (x1, y1), (x2, y2) = (c.hole(c.v[f"x{k}"], c.v[f"y{k}"]) for k in (1, 2))
    return {"angle": (0.0, math.degrees(math.atan2(y2 - y1, x2 - x1)))}


def _middle(c: TouchCycle, inside: bool) -> Findings:
    """Return the findings of a slot, a ridge."""
    findings = width(c, inside, c.axis(2), c.v["size"])
    return {**findings, "middle": findings["xy"[c.axis(2)]]}


def _corner(c: TouchCycle) -> Findings:
    """Return an outer corner by two points of the edge along X (Q263, Q264 and Q326 further) and two of that along Y (Q296, Q297; Q327)."""
    (x1, y1), (x3, y3) = (c.v["x"], c.v["y"]), (c.v["x3"], c.v["y3"])
    sense = (math.copysign(1.0, x1 - x3), math.copysign(1.0, y3 - y1))
    lower = [c.side((x1 + k * sense[0] * c.v["further_x"], y1), 1, sense[1]) for k in (0, 1)]
    left = [c.side((x3, y3 + k * sense[1] * c.v["further_y"]), 0, sense[0]) for k in (0, 1)]
    c.leave()
    x, y, angles = meeting([lower, left], sense, c.feeler.radius)
    return {"x": (0.0, x), "y": (0.0, y), "turn": (0.0, angles[0])}


def _pitch_circle(c: TouchCycle) -> Findings:
    """Return the middle of the circle through three holes at the angles Q291, Q292, Q293."""
    middles, half = [], c.v["size"] / 2.0
    for angle in (math.radians(c.v[name]) for name in ("one", "two", "three")):
        middles.append((*c.hole(c.v["x"] + half * math.cos(angle), c.v["y"] + half * math.sin(angle)), 0.0))
    made = c.feeler.circle(middles, True)
    return {"x": (0.0, made.x), "y": (0.0, made.y), "size": (0.0, made.diameter - 2.0 * c.feeler.radius)}


def _four_holes(c: TouchCycle) -> Findings:
    """Return where the lines through holes 1 and 3, and through 2 and 4 cross."""
    first, second, third, fourth = (c.hole(c.v[f"x{k}"], c.v[f"y{k}"]) for k in (1, 2, 3, 4))
    (ax, ay), (bx, by) = (
        (third[0] - first[0], third[1] - first[1]),
        (fourth[0] - second[0], fourth[1] - second[1]),
    )
    det = ax * by - ay * bx
    if abs(det) < 1e-9:
        c.r.fault(
            "TCH PROBE 418: the lines through holes 1 and 3 and through 2 and 4 are parallel; check the order of the holes",
            c.column,
        )
    t = ((second[0] - first[0]) * by - (second[1] - first[1]) * bx) / det
    return {"x": (0.0, first[0] + t * ax), "y": (0.0, first[1] + t * ay)}


def _height(c: TouchCycle) -> Findings:
    return {"z": (c.v["z"], c.top(c.v["x"], c.v["y"], c.v["z"]))}


def _along(c: TouchCycle) -> Findings:
    """Return a surface along Q272 in sense Q267, at Q263, Q264 and the height Q261."""
    axis, sense, spot = c.axis(3), c.sense(), (c.v["x"], c.v["y"])
    reads = c.top(*spot, c.v["height"], sense) if axis == 2 else c.coordinate(spot, axis, sense)
    c.leave()
    return {"place": (0.0, reads)}


def _slot(c: TouchCycle) -> Findings:
    """Return a width from inside, the second side Q310 further along it."""
    axis, size, ends = c.axis(2), c.v["size"], []
    for side in (1.0, -1.0):
        expected = [c.v["x"], c.v["y"]]
        expected[axis] += side * size / 2.0
        expected[1 - axis] += c.v["further"] if side < 0.0 else 0.0
        ends.append(c.coordinate((expected[0], expected[1]), axis, side))
    return _width_of(c, ends[1], ends[0])


def _ridge(c: TouchCycle) -> Findings:
    """Return a width from outside, by a point of either side."""
    axis, first, second = c.axis(2), (c.v["x"], c.v["y"]), (c.v["x2"], c.v["y2"])
    sense = math.copysign(1.0, second[axis] - first[axis])
    low, high = sorted((c.coordinate(first, axis, sense), c.coordinate(second, axis, -sense)))
    return _width_of(c, low, high)


def _width_of(c: TouchCycle, low: float, high: float) -> Findings:
    c.leave()
    return {"size": (c.v["size"], high - low), "middle": (0.0, (high + low) / 2.0)}


# -- what the machine sets by it ------------------------------------------------------------------------------------------
def _set_datum(c: TouchCycle, findings: Findings) -> None:
    c.datum([findings["x"][1], findings["y"][1], None], [c.v["new_x"], c.v["new_y"], None])


def _set_axis(c: TouchCycle, findings: Findings) -> None:
    """Set the measured axis; it then reads Q405 (slot, ridge), Q333."""
    (reads,) = (findings[k][1] for k in ("middle", "place", "z") if k in findings)
    axis = 2 if "z" in findings else c.axis(3)
    new = c.v["new"] if "middle" in findings else c.v["new_z"]
    c.datum([reads if k == axis else None for k in range(3)], [new if k == axis else None for k in range(3)])


def _set_turn(c: TouchCycle, findings: Findings) -> None:
    c.turn(findings["angle"][1])


def _set_corner(c: TouchCycle, findings: Findings) -> None:
    """Set the datum, and a basic rotation before it where Q304 = 1 asks for it."""
    spot: Flat = (findings["x"][1], findings["y"][1])
    if c.v["turns"]:
        here = c.r.world.apply((*spot, c.r.p[2]))
        c.values["Q150"] = findings["turn"][1]
        c.turn(findings["turn"][1])
        spot = c.r.world.undo(here)[:2]
    c.datum([*spot, None], [c.v["new_x"], c.v["new_y"], None])


_LINE, _AXIS = "Q263=x mm!, Q264=y mm!, Q265=x2 mm!, Q266=y2 mm!", "Q272=axis plain!"
_OVER, _WAYS = "Q320=clear mm, Q260=over mm?", "Q261=height mm!, Q320=clear mm, Q260=over mm?"
_TURN = "Q305=preset plain, Q307=new_angle plain"
_Z = "Q305=preset plain, Q381=also_z plain, Q382=z_x mm, Q383=z_y mm, Q384=z_z mm, Q333=new_z mm"
_DATUM = f"Q331=new_x mm, Q332=new_y mm, {_Z}"
_BOX, _ROUND = "Q321=x mm!, Q322=y mm!", "Q325=first plain, Q247=step plain?, Q423=points plain?"
_HOLES = "Q268=x1 mm!, Q269=y1 mm!, Q270=x2 mm!, Q271=y2 mm!"
_BESIDE = f"Q263=x mm!, Q264=y mm!, {_WAYS}, {_AXIS}, Q267=sense plain!"
_SLOT, _DATUM_BOX = (
    f"{_BOX}, Q311=size mm!, {_WAYS}, {_AXIS}, Q405=new mm, {_Z}",
    f"{_BOX}, Q323=length mm!, Q324=width mm!, {_WAYS}, {_DATUM}",
)
_DATUM_ROUND, _MEASURED_ROUND = (
    f"{_BOX}, Q262=size mm!, {_WAYS}, {_ROUND}, {_DATUM}",
    f"Q273=x mm!, Q274=y mm!, Q262=size mm!, {_WAYS}, {_ROUND}",
)
_MEASURED_BOX = f"Q273=x mm!, Q274=y mm!, Q282=length mm!, Q283=width mm!, {_WAYS}"
_XY, _SIDES = "Q151=x Q152=y", "Q154=length Q155=width"
_ROUND_OFF, _BOX_OFF, _WIDE = (
    f"{_XY} Q153=size Q161=-x Q162=-y Q163=-size",
    f"{_XY} {_SIDES} Q161=-x Q162=-y Q164=-length Q165=-width",
    "Q156=size Q157=middle Q166=-size",
)
CYCLES: Mapping[int, TouchRow] = {
    400: TouchRow(cycle(f"{_LINE}, {_WAYS}, {_AXIS}, Q267=sense plain!, {_TURN}", _slope), "Q150=angle", _set_turn),
    401: TouchRow(cycle(f"{_HOLES}, {_WAYS}, Q402=table plain, {_TURN}", _two_holes), "Q150=angle", _set_turn),
    408: TouchRow(cycle(_SLOT, lambda c: _middle(c, True)), "Q157=middle Q166=size", _set_axis),
    409: TouchRow(cycle(_SLOT, lambda c: _middle(c, False)), "Q157=middle Q166=size", _set_axis),
    410: TouchRow(cycle(_DATUM_BOX, lambda c: rectangle(c, True)), f"{_XY} {_SIDES}", _set_datum),
    411: TouchRow(cycle(_DATUM_BOX, lambda c: rectangle(c, False)), f"{_XY} {_SIDES}", _set_datum),
    412: TouchRow(cycle(_DATUM_ROUND, lambda c: circle(c, True, c.angles())), f"{_XY} Q153=size", _set_datum),
    413: TouchRow(cycle(_DATUM_ROUND, lambda c: circle(c, False, c.angles())), f"{_XY} Q153=size", _set_datum),
    414: TouchRow(cycle(f"Q263=x mm!, Q264=y mm!, Q326=further_x size!, Q296=x3 mm!, Q297=y3 mm!, Q327=further_y size!, {_WAYS}, Q304=turns plain, Q307=new_angle plain, {_DATUM}", _corner), _XY, _set_corner),
    416: TouchRow(cycle(f"Q273=x mm!, Q274=y mm!, Q262=size mm!, Q291=one plain!, Q292=two plain!, Q293=three plain!, {_WAYS}, {_DATUM}", _pitch_circle), f"{_XY} Q153=size", _set_datum),
    417: TouchRow(cycle(f"Q263=x mm!, Q264=y mm!, Q294=z mm!, {_OVER}, Q305=preset plain, Q333=new_z mm", _height), "Q160=z", _set_axis),
    418: TouchRow(cycle(f"{_HOLES}, Q316=x3 mm!, Q317=y3 mm!, Q318=x4 mm!, Q319=y4 mm!, {_WAYS}, {_DATUM}", _four_holes), _XY, _set_datum),
    419: TouchRow(cycle(f"{_BESIDE}, Q305=preset plain, Q333=new_z mm", _along), "", _set_axis),
    420: TouchRow(cycle(f"{_LINE}, {_WAYS}, {_AXIS}, Q267=sense plain!", _from_main_axis), "Q150=angle"),
    421: TouchRow(cycle(_MEASURED_ROUND, lambda c: circle(c, True, c.angles())), _ROUND_OFF),
    422: TouchRow(cycle(_MEASURED_ROUND, lambda c: circle(c, False, c.angles())), _ROUND_OFF),
    423: TouchRow(cycle(_MEASURED_BOX, lambda c: rectangle(c, True)), _BOX_OFF),
    424: TouchRow(cycle(_MEASURED_BOX, lambda c: rectangle(c, False)), _BOX_OFF),
    425: TouchRow(cycle(f"Q328=x mm!, Q329=y mm!, Q311=size mm!, {_WAYS}, {_AXIS}, Q310=further mm", _slot), _WIDE),
    426: TouchRow(cycle(f"{_LINE}, Q311=size mm!, {_WAYS}, {_AXIS}", _ridge), _WIDE),
    427: TouchRow(cycle(_BESIDE, _along), "Q160=place"),
}  # fmt: skip
LATER: Mapping[int, str] = {
    402: "it turns by two studs", 403: "it turns a rotary axis", 404: "it sets a rotation", 405: "it turns the C axis", 415: "its first point is that of a wall in one version of the control, "
    "of the corner in another", 430: "a bolt circle", 431: "a plane", 441: "fast probing", 444: "probing in space",
}  # fmt: skip
