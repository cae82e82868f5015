"""Recorder: the state of a control, and the moves made so far. The readers of all languages feed it.

mm, mm/min. A point is `p` as programmed (inside all frames); `world`(p), the tip in machine coordinates = work offset, its rotation, the
program's own frame; `q`, the axes = tip + tool offset, which stays when tool or frame change. Corners and radius compensation come last.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from dataclasses import dataclass, field
from typing import ClassVar, NoReturn

from vcmm.program.faults import ProgramFault
from vcmm.program.frames import AffineMap, in_plane, rotation, translation
from vcmm.program.leading import leading, let_go, unit, unmoved_axes_after
from vcmm.program.levels import Assumption, SetupEntry, UnusedWord, tell_unknown_axes
from vcmm.program.moves import ORIGIN, PLANES, Move, Point, Program, Remark, Source
from vcmm.program.offsetting import sweep_of
from vcmm.program.radius import RadiusCompensation, Style, centre_path
from vcmm.program.repeating import RepeatedStates
from vcmm.program.rounding import RoundedCorner, round_corners
from vcmm.program.setup import Setup, Tool, imaginary_nose
from vcmm.program.state import ModalState
from vcmm.program.touching import ProbeContact
from vcmm.program.trace import Tracing

ARC_TOLERANCE_MM, ARC_TOLERANCE_SHARE = (
    0.01,
    0.001,
)  # mm and part of the radius by which the radii at the ends of an arc may differ
NO_TOOL, START, UNMOVED = Tool(0), Source(1, 1, 1), AffineMap()
Sides = list[RadiusCompensation | None]  # in force on each move, None where there is none
Finish = Callable[[list[Move], Sides], tuple[list[Move], Sides]]
_NO_FEED = "no feed has been programmed for this cutting move; add F, for example F200"


@dataclass(slots=True, eq=False)
class Recorder(ModalState):
    """State and moves. `source` is the block being executed, `column` the place in it that a message names (0: its first)."""

    NO_FEED: ClassVar[Mapping[str, str]] = {"G93": _NO_FEED, "G94": _NO_FEED, "G95": _NO_FEED}
    NO_TURNS: ClassVar[str] = (
        "the feed is per turn, but the spindle is at rest; start it with S and M3 or M4 before"
    )

    file: str = ""
    dialect: str = ""
    setup: Setup = field(default_factory=Setup)
    source: Source = START
    column: int = 0
    offsets: dict[str, Point] = field(default_factory=dict)
    rotations: dict[str, float] = field(default_factory=dict)
    common: Point = ORIGIN  # a shift of all work offsets
    frame: AffineMap = UNMOVED  # the program's own
    world: AffineMap = UNMOVED  # all together: programmed point -> tip in machine coordinates
    p: Point = ORIGIN
    q: Point = ORIGIN
    rotary: Point = ORIGIN
    last_aim: Point | None = None  # tool axis at the end of the last move
    tool_data: Tool = NO_TOOL
    tool_axis: int = 2
    moves: list[Move] = field(default_factory=list)
    sides: Sides = field(default_factory=list)
    corners: list[RoundedCorner] = field(default_factory=list)
    finishes: list[Finish] = field(default_factory=list)
    remarks: list[Remark] = field(default_factory=list)
    remark_keys: set[str] = field(default_factory=set)
    assumptions: dict[str, Assumption] = field(default_factory=dict)  # by what it is
    unused_words: dict[tuple[int, str], UnusedWord] = field(default_factory=dict)
    work_offsets: dict[str, Source] = field(
        default_factory=dict
    )  # work offsets, and where they are first named
    tool_names: dict[int, str] = field(default_factory=dict)  # tools, and what the program calls them
    touches: list[ProbeContact] = field(default_factory=list)
    skip: Point | None = None  # where the last probing move stopped, as programmed
    skip_axes: Point = ORIGIN  # and where the axes stood
    marker: str = ""  # the cycle being expanded
    markers: list[str] = field(default_factory=list)
    tracer: Tracing | None = None
    states: RepeatedStates = field(default_factory=RepeatedStates)  # at jumps backwards

    def __post_init__(self) -> None:
        self.offsets, self.rotations = dict(self.setup.offsets), dict(self.setup.rotations)
        self.refresh()

    # -- messages --
    @property
    def line(self) -> int:
        """Line of the block being executed."""
        return self.source.line

    def fault(self, text: str, column: int | None = None) -> NoReturn:
        """Raises ProgramFault at the block being executed."""
        raise ProgramFault(self.file, self.line, column or self.column or self.source.first, text)

    def remark(self, text: str, column: int | None = None, kind: str = "", every: bool = False) -> None:
        """Add a remark at the block being executed; one of each kind (where none is named: of each text), or `every` one."""
        if not every:
            if (kind or text) in self.remark_keys:
                return
            self.remark_keys.add(kind or text)
        self.remarks.append(Remark(self.line, self.source.first if column is None else column, text))

    def assume(
        self, what: str, value: str, otherwise: str = "", *, blank: SetupEntry | None = None, column: int | None = None,
        matters: bool = True,
    ) -> None:  # fmt: skip
        """Assume `value` for data that the program lacks and the machine would know, with one remark for each `what`.

        The caller goes on with the value: this only adds the remark. Strict: refused with the sentence `otherwise`; where there is none,
        both levels go on, strict with a remark. blank: how the set-up file gives it. matters: whether the path depends on it.
        """
        if self.setup.strict and otherwise:
            self.fault(otherwise, column)
        if self.setup.strict:  # nothing is assumed here: what both levels know is a remark
            self.remark(f"{what}: {value}")
            return
        self.assumptions.setdefault(what, Assumption(self.line, what, value, blank, matters, otherwise))

    # -- positions --
    def refresh(self) -> None:
        """Refresh `world`, and the programmed point of the tool, after frame, offset or tool have changed."""
        base, angle = self.offsets.get(self.offset, ORIGIN), self.rotations.get(self.offset, 0.0)
        outer = translation((base[0] + self.common[0], base[1] + self.common[1], base[2] + self.common[2]))
        self.world = (outer.then(rotation(2, angle)) if angle else outer).then(self.frame)
        self.locate()

    def locate(self) -> None:
        """Compute the programmed point that belongs to q."""
        self.p = self.world.undo(self.tip())

    def tip(self) -> Point:
        """Return the tip position: machine position, mm."""
        q, o = self.q, self.tool_offset
        return q[0] - o[0], q[1] - o[1], q[2] - o[2]

    def set_frame(self, frame: AffineMap) -> None:
        """Set the program's own frame."""
        self.free("a frame (shift, rotation, mirror, scale) changes")
        self.frame = frame
        self.refresh()

    def set_offset(self, name: str) -> None:
        """Set the work offset in force; zero, with a remark, where the set-up lacks it."""
        self.free("the work offset changes")
        if name not in self.setup.offsets and self.setup.offsets:
            self.remark(
                f"the set-up has no {name}; zero is taken for it, state [offsets] {name} to change that"
            )
        self.select(name)
        self.refresh()

    def select(self, name: str) -> None:
        """Select a work offset from here on."""
        self.offset = name
        if self.setup.work_spindles:
            self.hold(self.setup.work_spindles.get(name, 1))
        self.work_offsets.setdefault(name, self.source)

    def hold(self, spindle: int) -> None:
        """Set the spindle that holds the part cut from here on."""
        if spindle != self.work_spindle:
            self.remark(
                f"from here on the part in spindle {spindle} is cut; what was cut before is that of spindle {self.work_spindle}",
                every=True,
            )
        self.work_spindle = spindle

    def free(self, what: str) -> None:
        """Refuses a change that radius compensation forbids."""
        if self.compensation is not None:
            self.fault(f"{what} while radius compensation is on; cancel it first")

    # -- tools --
    def change_tool(self, tool: Tool, called: str) -> None:
        """Put a tool into the spindle, its length in force."""
        self.free("the tool changes")
        self.tool, self.tool_data = tool.number, tool
        if tool.number:
            self.tool_names[tool.number] = called
        self.set_length(tool.offset)

    def set_length(self, offset: Point) -> None:
        """Set the tool offset in force. The axes stay; the length is along the tool axis, Z unless the program says otherwise."""
        if self.tool_axis != 2 and self.tool_data.shape != "turning":
            offset = (0.0, offset[2], 0.0) if self.tool_axis == 1 else (offset[2], 0.0, 0.0)
        self.tool_offset = offset
        self.refresh()

    def compensate(self, side: str | None, style: Style, extra: float = 0.0) -> None:
        """Switch radius compensation with the tool in the spindle on ("left", "right") or off; extra mm on the radius (DR)."""
        if side is None:
            self.compensation = None
            return
        radius = self.tool_data.radius
        if radius is None:
            what = f"tool {self.tool}" if self.tool else "no tool in the spindle, and it"
            self.assume(
                f"the diameter of tool {self.tool}",
                "0 mm: the path on the programmed contour",
                f"radius compensation is switched on, but {what} has no known radius; state its diameter in the set-up file under [tools.{self.tool}]",
                blank=SetupEntry(f"tools.{self.tool}", "diameter", '"10 mm"'),
            )
            radius, extra = 0.0, 0.0
        nose = imaginary_nose(self.tool_data.orientation, radius, self.plane)
        self.compensation = RadiusCompensation(side, radius + extra, style, nose)

    # -- speed and feed --
    def spindle(self, start: Point, end: Point) -> float:
        """Turns per minute, signed; with constant surface speed that at the middle of the move, X from the work zero, mm."""
        if not self.surface or not self.sense:
            return self.sense * self.speed
        turns = self.turns((start[0] + end[0]) / 2 - self.world.apply(ORIGIN)[0])
        return self.sense * (turns if math.isfinite(turns) else self.speed_at_centre())

    def speed_at_centre(self) -> float:
        """Turns per minute with constant surface speed at the centre, where nothing limits them."""
        self.fault("constant surface speed at X 0 has no limit of the spindle speed; add LIMS=")

    def rate(self, length: float, turns: float) -> float | None:
        """Return mm/min along a path of `length` mm, at so many turns per minute; None where a survey does not know it."""
        if self.feed is None or self.feed <= 0:
            self.assume("the feed", "not known; its time is not counted", self.NO_FEED[self.feed_mode])
            return None
        if self.feed_mode == "G93":
            return self.feed * length
        if self.feed_mode == "G94":
            return self.feed * self.feed_scale
        if not turns:
            self.assume("the spindle speed", "not known; feeds per turn are not counted", self.NO_TURNS)
            return None
        return self.feed * self.feed_scale * abs(turns)

    # -- motion --
    def straight(self, end: Point, rapid: bool, rotary: Point | None = None) -> None:
        """Move straight to a programmed point; rotary axes (rad) go along."""
        self._line(self.world.apply(end), rapid, rotary)
        self.p = end

    def to_machine(self, tip: Point, rapid: bool, rotary: Point | None = None) -> None:
        """Move straight to a tip position in machine coordinates, such as SUPA, G53 or M91: never rewritten."""
        self.free("a move in machine coordinates is programmed")
        self._line(tip, rapid, rotary, rewritable=False)
        self.refresh()

    def _line(self, end: Point, rapid: bool, rotary: Point | None, rewritable: bool = True) -> None:
        start = self.tip()
        kind, feed = "rapid" if rapid else "line", None
        if not rapid:
            feed = self.line_feed(start, end, self.rotary if rotary is None else rotary)
        self.emit(kind, end, start=start, rotary=rotary, feed=feed, rewritable=rewritable)

    def line_feed(self, start: Point, end: Point, rotary: Point) -> float | None:
        """Return the mm/min of a straight cut; degrees per minute where rotary axes alone move, the meaning of F then."""
        distance = math.dist(start, end)
        return self.rate(distance or self.turn_angle(rotary), self.spindle(start, end))

    def turn_angle(self, rotary: Point) -> float:
        """Return the degrees from the rotary position to another one."""
        return math.degrees(math.dist(self.rotary, rotary))

    def arc(
        self, end: Point, centre: Point, clockwise: bool, turns: int = 1, plane: str | None = None
    ) -> None:
        """Move along an arc in the plane to a programmed point; start and end within 1e-9 mm in the plane are a full circle."""
        plane = plane or self.plane
        first, second, normal = PLANES[plane]
        self.check_radii(plane, end, centre)
        plane_map = in_plane(self.world, plane)
        if plane_map is None:
            self.fault(
                f"an arc of the plane {plane} under a rotation out of that plane or a scale that differs between its axes is not understood; program it in the plane"
            )
        clockwise = clockwise != plane_map[1]
        start, target = self.tip(), self.world.apply(end)
        lifted = [centre[0], centre[1], centre[2]]
        lifted[normal] = self.p[normal]
        middle = self.world.apply((lifted[0], lifted[1], lifted[2]))
        from_, to, about = ((x[first], x[second]) for x in (start, target, middle))
        swept = math.dist(from_, about) * abs(sweep_of(from_, to, about, clockwise, turns))
        spindle = self.spindle(start, target)
        feed = self.rate(math.hypot(swept, target[normal] - start[normal]), spindle)
        self.emit("arc", target, feed=feed, plane=plane, centre=middle, clockwise=clockwise, turns=turns)
        self.p = end

    def check_radii(self, plane: str, end: Point, centre: Point) -> None:
        first, second, _ = PLANES[plane]
        r1 = math.hypot(self.p[first] - centre[first], self.p[second] - centre[second])
        r2 = math.hypot(end[first] - centre[first], end[second] - centre[second])
        if r1 < 1e-9 or r2 < 1e-9:
            self.fault(
                "the centre of the arc lies on its start or end: an arc of radius zero; check the centre"
            )
        if abs(r1 - r2) > max(ARC_TOLERANCE_MM, ARC_TOLERANCE_SHARE * max(r1, r2)):
            self.fault(
                f"the arc does not fit: radius {r1:.4f} mm at its start, {r2:.4f} mm at its end; correct the end point or the centre"
            )

    def dwell(self, seconds: float) -> None:
        """Make the axes wait."""
        if seconds < 0:
            self.fault("a dwell cannot be negative; correct its time")
        self.emit("dwell", self.tip(), seconds=seconds)

    # -- moves --
    def move(
        self, kind: str, start: Point, end: Point, *, rotary: Point | None = None, feed: float | None = None,
        plane: str | None = None, centre: Point | None = None, clockwise: bool | None = None, turns: int = 1,
        seconds: float = 0.0, rewritable: bool = True,
    ) -> Move:  # fmt: skip
        """Return a move with all values in force. Its `compensation` is set for the computation of the centre path."""
        stop = self.exact_stop or self.exact_once
        return Move(
            kind=kind, source=self.source, start=start, end=end, rotary_start=self.rotary,
            rotary_end=self.rotary if rotary is None else rotary, plane=plane or self.plane, centre=centre, turns=turns,
            clockwise=clockwise, feed=feed, spindle=self.spindle(start, end), tool=self.tool, tool_offset=self.tool_offset,
            compensation=None, seconds=seconds, exact_stop=stop, tolerance=None if stop else self.tolerance,
            offset=self.offset, rewritable=rewritable, work_spindle=self.work_spindle, **leading(self, rewritable), unmoved_axes=self.unmoved_axes,
        )  # fmt: skip

    def point_to(self, direction: Point) -> None:
        """Point the tool along a direction of the workpiece, from its tip to the spindle."""
        self.aim = unit(direction)
        if self.aim is None:
            self.fault("the direction of the tool has no length; give a vector, as in I0 J0 K1")

    def emit(
        self, kind: str, end: Point, *, start: Point | None = None, rotary: Point | None = None, feed: float | None = None,
        plane: str | None = None, centre: Point | None = None, clockwise: bool | None = None, turns: int = 1,
        seconds: float = 0.0, rewritable: bool = True,
    ) -> None:  # fmt: skip
        """Make a move from where the tip is (or `start`) and note where the axes now are. Machine coordinates."""
        if self.is_plane_tilted and rotary is not None and math.dist(rotary, self.rotary) > 1e-9:
            wording = "a rotary axis in a tilted plane, which has turned them"
            self.assume(wording, "passed over", f"{wording}, is not understood; end the plane before")
        if self.unmoved_axes:
            let_go(self, self.tip() if start is None else start, end, rotary)
        self.moves.append(
            self.move(
                kind, self.tip() if start is None else start, end, rotary=rotary, feed=feed, plane=plane, centre=centre,
                clockwise=clockwise, turns=turns, seconds=seconds, rewritable=rewritable,
            )
        )  # fmt: skip
        self.sides.append(self.side_on(rewritable))
        if self.tracer is not None:
            self.markers.append(self.marker)
        o = self.tool_offset
        self.q = (end[0] + o[0], end[1] + o[1], end[2] + o[2])
        if rotary is not None:
            tell_unknown_axes(self, self.rotary, rotary)
            self.rotary = rotary
        self.last_aim, self.unmoved_axes = self.aim, unmoved_axes_after(self.moves[-1], self.unmoved_axes)

    def side_on(self, rewritable: bool) -> RadiusCompensation | None:
        """Return the compensation of a move; a mirror image is cut with the tool on the other side."""
        side = self.compensation if rewritable else None
        plane_map = None if side is None else in_plane(self.world, self.plane)
        if side is None or plane_map is None or not plane_map[1]:
            return side
        return side._replace(side="right" if side.side == "left" else "left")

    def corner(self, size: float, kind: str, feed: float | None = None) -> None:
        """Round ("round", radius) or cut ("chamfer", mm along each side; "width", mm across) the corner after the last move."""
        if not self.moves:
            self.fault("there is no move before this rounding or chamfer; place it between two moves")
        self.corners.append(RoundedCorner(len(self.moves) - 1, kind, size, self.source, feed))

    # -- result --
    def program(self, file: str = "") -> Program:
        """Return the program with all parts: rounded corners, approaches, centre path. file: the first file of the program, for messages."""
        traces, steps = ((), ()) if self.tracer is None else self.tracer.result(self)
        moves, sides = self.moves, self.sides
        if self.corners:
            moves, sides = round_corners(moves, sides, self.corners, file or self.file)
        for finish in self.finishes:
            moves, sides = finish(moves, sides)
        if any(side is not None for side in sides):
            moves = centre_path(moves, sides, file or self.file)
        return Program(
            self.dialect, tuple(moves), tuple(self.remarks), tools=dict(self.tool_names), offsets=dict(self.work_offsets), traces=traces, steps=steps,
            assumed=tuple(sorted(self.assumptions.values(), key=lambda a: a.line)), touches=tuple(self.touches), unused=tuple(sorted(self.unused_words.values())),
        )  # fmt: skip


def radius_centre(start: Point, end: Point, radius: float, clockwise: bool, plane: str) -> Point | None:
    """Return the centre of the arc of a radius (negative: the long way round); None where the radius is too small."""
    first, second, _ = PLANES[plane]
    dx, dy = end[first] - start[first], end[second] - start[second]
    chord = math.hypot(dx, dy)
    if chord < 1e-9 or chord / 2 - abs(radius) > 1e-3:
        return None
    height = math.sqrt(max(radius**2 - chord**2 / 4, 0.0))
    side = (1.0 if clockwise else -1.0) * (1.0 if radius > 0 else -1.0)
    centre = list(start)
    centre[first] += dx / 2 + side * height * dy / chord
    centre[second] += dy / 2 - side * height * dx / chord
    return centre[0], centre[1], centre[2]
