"""Recorder: what the front-ends for Sinumerik and Klartext have in common. State of the control in, canonical moves out.

Lengths are mm, feeds mm/min. Three positions of one point: `p` as programmed (inside all frames), the tip in machine
coordinates = work offset (frame (p)), and `q`, the position of the axes = tip + tool offset. q is what stays when tool
or frame change without motion. Corner rounding and radius compensation act on the whole list at the end, because a
control looks ahead.
"""

from __future__ import annotations

import math
from collections.abc import Callable
from dataclasses import dataclass, field
from typing import NamedTuple, NoReturn

from vcmm.nc.faults import ProgramFault
from vcmm.nc.frames import ZERO, Frame, in_plane, rotation, translation
from vcmm.nc.moves import NO_ROTARY, PLANES, Move, Point, Program, Remark, Source
from vcmm.nc.radius import SINUMERIK, Style, centre_path
from vcmm.nc.rounding import Corner, round_corners
from vcmm.nc.setup import Setup, Tool
from vcmm.nc.trace import Tracing

LEAST, SHARE = 0.01, 0.001  # mm and part of the radius by which the radii at the ends of an arc may differ
NO_TOOL = Tool(0)
START, PLAIN = Source(1, 1, 1), Frame()


class Side(NamedTuple):
    """Radius compensation in force: "left" or "right", radius of the tool in mm."""

    side: str | None
    radius: float
    style: Style


NO_SIDE = Side(None, 0.0, SINUMERIK)
Finish = Callable[[list[Move], list[Side]], tuple[list[Move], list[Side]]]


@dataclass(eq=False)
class Recorder:
    """State and the moves so far. `where` is the source of the block being executed."""

    file: str
    setup: Setup
    dialect: str
    source: Source = START
    plane: str = "XY"
    offset: str = "G54"
    frame: Frame = PLAIN
    world: Frame = PLAIN  # work offset and frame together
    q: Point = ZERO
    p: Point = ZERO
    rotary: Point = NO_ROTARY
    feed: float | None = None
    feed_mode: str = "G94"
    speed: float = 0.0
    speed_limit: float = math.inf
    surface: bool = False  # G96: speed is m/min
    sense: int = 0
    tool: int = 0
    data: Tool = NO_TOOL
    tool_offset: Point = ZERO
    tool_axis: int = 2
    side: Side = NO_SIDE
    exact_stop: bool = False
    exact_once: bool = False
    tolerance: float | None = None
    moves: list[Move] = field(default_factory=list)
    sides: list[Side] = field(default_factory=list)
    corners: list[Corner] = field(default_factory=list)
    remarks: list[Remark] = field(default_factory=list)
    tools: dict[int, str] = field(default_factory=dict)
    finishes: list[Finish] = field(default_factory=list)
    marker: str = ""  # the cycle being expanded
    markers: list[str] = field(default_factory=list)
    tracer: Tracing | None = None

    def __post_init__(self) -> None:
        self.refresh()

    # -- messages --
    def fault(self, text: str, column: int | None = None) -> NoReturn:
        raise ProgramFault(self.file, self.source.line, self.source.first if column is None else column, text)

    def remark(self, text: str, column: int | None = None) -> None:
        """A remark; the same text is made once."""
        if all(text != r.text for r in self.remarks):
            self.remarks.append(
                Remark(self.source.line, self.source.first if column is None else column, text)
            )

    # -- positions --
    def whole(self) -> Frame:
        """Programmed point -> tip in machine coordinates."""
        return self.world

    def refresh(self) -> None:
        """The programmed point that belongs to q, after frame, offset or tool have changed."""
        outer = translation(self.setup.offsets.get(self.offset, ZERO))
        angle = self.setup.rotations.get(self.offset, 0.0)
        self.world = (outer.then(rotation(2, angle)) if angle else outer).then(self.frame)
        self.p = self.world.undo(self.tip())

    def tip(self) -> Point:
        q, o = self.q, self.tool_offset
        return q[0] - o[0], q[1] - o[1], q[2] - o[2]

    def set_frame(self, frame: Frame) -> None:
        self.free("a frame (shift, rotation, mirror, scale) changes")
        self.frame = frame
        self.refresh()

    def set_offset(self, name: str) -> None:
        self.free("the work offset changes")
        if name not in self.setup.offsets and self.setup.offsets:
            self.remark(
                f"the set-up has no {name}; zero is taken for it, state [offsets] {name} to change that"
            )
        self.offset = name
        self.refresh()

    def free(self, what: str) -> None:
        """Refuses a change that radius compensation forbids."""
        if self.side.side is not None:
            self.fault(f"{what} while radius compensation is on; cancel it first")

    # -- tools --
    def change_tool(self, tool: Tool, called: str) -> None:
        self.free("the tool changes")
        self.tool, self.data = tool.number, tool
        if tool.number:
            self.tools[tool.number] = called
        self.set_length(tool.offset)

    def set_length(self, offset: Point) -> None:
        """Tool offset in force. The axes stay; the length is along the tool axis, Z unless the program says otherwise."""
        if self.tool_axis != 2 and self.data.shape != "turning":
            offset = (0.0, offset[2], 0.0) if self.tool_axis == 1 else (offset[2], 0.0, 0.0)
        self.tool_offset = offset
        self.refresh()

    def compensate(self, side: str | None, style: Style, extra: float = 0.0) -> None:
        """Radius compensation on ("left", "right") or off; extra mm on the radius (DR)."""
        if side is None:
            self.side = NO_SIDE
            return
        radius = self.data.radius
        if radius is None:
            what = f"tool {self.tool}" if self.tool else "no tool in the spindle, and it"
            self.fault(
                f"radius compensation is switched on, but {what} has no known radius; state its diameter in the set-up file under [tools.{self.tool}]"
            )
        self.side = Side(side, radius + extra, style)

    # -- motion --
    def spindle(self, start: Point, end: Point) -> float:
        """Turns per minute, signed; constant surface speed at the middle of the move, X from the work zero, mm."""
        if not self.surface or not self.sense:
            return self.sense * self.speed
        x = abs((start[0] + end[0]) / 2 - self.world.apply(ZERO)[0])
        turns = min(1000.0 * self.speed / (2 * math.pi * x) if x else math.inf, self.speed_limit)
        if not math.isfinite(turns):
            self.fault("constant surface speed at X 0 has no limit of the spindle speed; add LIMS=")
        return self.sense * turns

    def rate(self, length: float, spindle: float) -> float:
        """mm/min along the path."""
        if self.feed is None or self.feed <= 0:
            self.fault("no feed has been programmed for this cutting move; add F, for example F200")
        if self.feed_mode == "G95":
            if not spindle:
                self.fault(
                    "the feed is per turn, but the spindle stands still; start it with S and M3 or M4 before"
                )
            return self.feed * abs(spindle)
        return self.feed * length if self.feed_mode == "G93" else self.feed

    def line(self, end: Point, rapid: bool, rotary: Point | None = None) -> None:
        """Straight to a programmed point."""
        self._line(self.world.apply(end), rapid, rotary)
        self.p = end

    def to_machine(self, tip: Point, rapid: bool) -> None:
        """Straight to a tip position in machine coordinates, such as SUPA, G53 or M91: never rewritten."""
        self.free("a move in machine coordinates is programmed")
        self._line(tip, rapid, None, rewritable=False)
        self.refresh()

    def _line(self, end: Point, rapid: bool, rotary: Point | None, rewritable: bool = True) -> None:
        start, turned = self.tip(), self.rotary if rotary is None else rotary
        spindle = self.spindle(start, end)
        length = math.dist(start, end) or math.degrees(math.dist(self.rotary, turned))
        feed = None if rapid else self.rate(length, spindle)
        self.emit("rapid" if rapid else "line", start, end, feed, spindle, turned, rewritable=rewritable)
        self.rotary = turned

    def arc(
        self, end: Point, centre: Point, clockwise: bool, turns: int = 1, plane: str | None = None
    ) -> None:
        """Arc in the plane to a programmed point; start and end within 1e-9 mm in the plane are a full circle."""
        plane = plane or self.plane
        one, two, normal = PLANES[plane]
        self._check_radii(plane, end, centre)
        whole = self.world
        kept = in_plane(whole, plane)
        if kept is None:
            self.fault(
                f"an arc of the plane {plane} under a rotation out of that plane or a scale that differs between its axes is not understood; program it in the plane"
            )
        clockwise = clockwise != kept[1]
        start, target = self.tip(), whole.apply(end)
        lifted = [centre[0], centre[1], centre[2]]
        lifted[normal] = self.p[normal]
        middle = whole.apply((lifted[0], lifted[1], lifted[2]))
        spindle = self.spindle(start, target)
        radius = math.hypot(start[one] - middle[one], start[two] - middle[two])
        length = math.hypot(
            radius * _angle(start, target, middle, plane, clockwise, turns), target[normal] - start[normal]
        )
        self.emit(
            "arc", start, target, self.rate(length, spindle), spindle, self.rotary, plane=plane, centre=middle, clockwise=clockwise, turns=turns
        )  # fmt: skip
        self.p = end

    def _check_radii(self, plane: str, end: Point, centre: Point) -> None:
        one, two, _ = PLANES[plane]
        r1 = math.hypot(self.p[one] - centre[one], self.p[two] - centre[two])
        r2 = math.hypot(end[one] - centre[one], end[two] - centre[two])
        if r1 < 1e-9 or r2 < 1e-9:
            self.fault(
                "the centre of the arc lies on its start or end: an arc of radius zero; check the centre"
            )
        if abs(r1 - r2) > max(LEAST, SHARE * max(r1, r2)):
            self.fault(
                f"the arc does not fit: radius {r1:.4f} mm at its start, {r2:.4f} mm at its end; correct the end point or the centre"
            )

    def dwell(self, seconds: float) -> None:
        if seconds < 0:
            self.fault("a dwell cannot be negative; correct its time")
        here = self.tip()
        self.emit("dwell", here, here, None, self.spindle(here, here), self.rotary)
        self.moves[-1] = self.moves[-1]._replace(seconds=seconds)

    def emit(
        self, kind: str, start: Point, end: Point, feed: float | None, spindle: float, rotary: Point, plane: str | None = None,
        centre: Point | None = None, clockwise: bool | None = None, turns: int = 1, rewritable: bool = True,
    ) -> None:  # fmt: skip
        """One move in machine coordinates."""
        stop = self.exact_stop or self.exact_once
        self.moves.append(
            Move(
                kind, self.source, start, end, self.rotary, rotary, plane or self.plane, centre, turns, clockwise, feed,
                spindle, self.tool, self.tool_offset, None, 0.0, stop, None if stop else self.tolerance, self.offset, rewritable,
            )
        )  # fmt: skip
        side = self.side
        if side.side is not None:
            kept = in_plane(self.world, self.plane)
            if kept is not None and kept[1]:  # a mirror image is cut with the tool on the other side
                side = side._replace(side="right" if side.side == "left" else "left")
        self.sides.append(side)
        self.markers.append(self.marker)
        o = self.tool_offset
        self.q = (end[0] + o[0], end[1] + o[1], end[2] + o[2])

    def corner(self, size: float, kind: str, feed: float | None = None) -> None:
        """Round ("round", radius) or cut ("chamfer", mm along each side; "width", mm across) the corner after the last move."""
        if not self.moves:
            self.fault("there is no move before this rounding or chamfer; place it between two moves")
        self.corners.append(Corner(len(self.moves) - 1, kind, size, self.source, feed))

    # -- result --
    def program(self) -> Program:
        """Everything together: rounded corners, approaches, centre path."""
        traces, steps = ((), ()) if self.tracer is None else self.tracer.result(self)
        moves, sides = list(self.moves), list(self.sides)
        moves, sides = round_corners(moves, sides, self.corners, self.file)
        for finish in self.finishes:
            moves, sides = finish(moves, sides)
        path = centre_path(
            moves,
            [s.side for s in sides],
            [s.radius for s in sides],
            [s.style for s in sides],
            file=self.file,
        )
        return Program(self.dialect, tuple(path), tuple(self.remarks), dict(self.tools), traces, steps)


def _angle(start: Point, end: Point, centre: Point, plane: str, clockwise: bool, turns: int) -> float:
    from vcmm.nc.offsetting import sweep_of

    one, two, _ = PLANES[plane]
    a, b, c = ((p[one], p[two]) for p in (start, end, centre))
    return abs(sweep_of(a, b, c, clockwise, turns))


def radius_centre(start: Point, end: Point, radius: float, clockwise: bool, plane: str) -> Point | None:
    """Centre of the arc of a radius (negative: the long way round); None where the radius is too small."""
    one, two, _ = PLANES[plane]
    dx, dy = end[one] - start[one], end[two] - start[two]
    chord = math.hypot(dx, dy)
    if chord < 1e-9 or chord / 2 - abs(radius) > 1e-3:
        return None
    height = math.sqrt(max(radius**2 - chord**2 / 4, 0.0))
    side = (1.0 if clockwise else -1.0) * (1.0 if radius > 0 else -1.0)
    centre = list(start)
    centre[one] += dx / 2 + side * height * dy / chord
    centre[two] += dy / 2 - side * height * dx / chord
    return centre[0], centre[1], centre[2]
