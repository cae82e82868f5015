"""Control: everything a numerical control remembers between blocks, and what it has produced so far.

Lengths are mm, angles rad, whatever the program uses. Three positions of one point:

    p     programmed point: work coordinates, before rotation and shifts
    tip   machine position of the tool tip = m (p + shifts) + work offset      (`to_tip`)
    q     machine position of the axes     = tip + tool offset in force

q is what stays when a code changes offsets without motion; p is computed anew from it.
"""

from __future__ import annotations

import math
from dataclasses import dataclass, field
from typing import NamedTuple

from vcmm.nc.dialects import Dialect
from vcmm.nc.expressions import Parameters
from vcmm.nc.faults import BlockFault, ProgramFault
from vcmm.nc.moves import NO_ROTARY, Move, Point, Remark, Source
from vcmm.nc.setup import Setup, Tool

Matrix = tuple[Point, Point, Point]
IDENTITY: Matrix = ((1.0, 0.0, 0.0), (0.0, 1.0, 0.0), (0.0, 0.0, 1.0))
AXES = "XYZ"


class Modal(NamedTuple):
    """The modal state that a rewriter must keep: a snapshot, made only when something has changed."""

    motion: str | None
    plane: str
    unit: float  # mm per unit of the program
    absolute: bool
    arc_absolute: bool
    feed_mode: str
    feed: float  # as programmed, in program units
    spindle_mode: str
    speed: float
    offset: str
    side: str | None
    retract: str
    tool: int
    tool_offset: Point
    exact_stop: bool
    tolerance: float | None
    diameter: bool


class Affine(NamedTuple):
    """Programmed point p (mm) to tip point: matrix @ p + shift."""

    matrix: Matrix
    shift: Point


class Compensation(NamedTuple):
    """Cutter radius compensation in force: side "left" or "right", radius in mm (a negative one changes the side)."""

    side: str
    radius: float
    orientation: int = 0


@dataclass(slots=True, eq=False)
class Control:
    """The state, and the moves made so far. Functions of the other modules work on it."""

    name: str
    dialect: Dialect
    setup: Setup
    motion: str | None = None
    plane: str = "XY"
    unit: float = 1.0
    absolute: bool = True
    arc_absolute: bool = False
    feed_mode: str = "G94"
    feed: float | None = None  # program units per minute, per turn, or 1/min
    spindle_mode: str = "G97"
    speed: float = 0.0
    speed_limit: float | None = None
    sense: int = 0  # of the spindle: +1 M3, -1 M4
    retract: str = "G98"
    offset: str = "G54"
    exact: bool = False
    exact_once: bool = False
    tolerance: float | None = None
    compensation: Compensation | None = None
    tool: int = 0
    next_tool: int = 0
    tool_offset: Point = NO_ROTARY
    length_word: int = 0  # H in force
    diameter: bool = False
    p: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    q: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    rotary: Point = NO_ROTARY
    offsets: dict[str, Point] = field(default_factory=dict)
    rotations: dict[str, float] = field(default_factory=dict)
    common: Point = NO_ROTARY
    g92: Point = NO_ROTARY
    g92_kept: Point = NO_ROTARY
    g52: Point = NO_ROTARY
    turn: tuple[str, Point, float] | None = None  # G68: plane, centre, angle
    matrix: Matrix | None = None  # None: no rotation
    shift: Point = NO_ROTARY
    tools: dict[int, Tool] = field(default_factory=dict)
    lengths: dict[int, float] = field(default_factory=dict)  # length registers set by G10
    radii: dict[int, float] = field(default_factory=dict)
    home: Point = NO_ROTARY
    home2: Point = NO_ROTARY
    cycle: dict[str, float] = field(default_factory=dict)
    cycle_level: float | None = None  # initial level of a series of cycles
    moves: list[Move] = field(default_factory=list)
    sides: list[Compensation | None] = field(default_factory=list)
    remarks: list[Remark] = field(default_factory=list)
    remarked: set[str] = field(default_factory=set)
    called: dict[int, str] = field(default_factory=dict)
    source: Source = field(default_factory=lambda: Source(1, 1, 1))
    line: int = 1
    ended: bool = False
    saved: tuple[object, ...] | None = None  # M70
    parameters: Parameters = None  # type: ignore[assignment]  # set by parameters.attach
    marker: str = ""  # cycle being expanded, for traces
    markers: list[str] | None = None

    # -- positions ------------------------------------------------------------------------------------------------
    def rebuild(self) -> None:
        """Work out matrix and shift after an offset has changed, and the programmed point at which the tool now is."""
        self.matrix, self.shift = transformation(self)
        self.recompute()

    def recompute(self) -> None:
        """Programmed point from the position of the axes."""
        tip = self.tip()
        d = [tip[i] - self.shift[i] for i in range(3)]
        m = self.matrix
        self.p = d if m is None else [m[0][i] * d[0] + m[1][i] * d[1] + m[2][i] * d[2] for i in range(3)]

    def tip(self) -> Point:
        """Where the tip is: machine position, mm."""
        q, o = self.q, self.tool_offset
        return (q[0] - o[0], q[1] - o[1], q[2] - o[2])

    def to_tip(self, p: list[float] | Point) -> Point:
        """Machine position of the tip at a programmed point."""
        s, m = self.shift, self.matrix
        if m is None:
            return (p[0] + s[0], p[1] + s[1], p[2] + s[2])
        a, b, c = m
        return (
            a[0] * p[0] + a[1] * p[1] + a[2] * p[2] + s[0],
            b[0] * p[0] + b[1] * p[1] + b[2] * p[2] + s[1],
            c[0] * p[0] + c[1] * p[1] + c[2] * p[2] + s[2],
        )

    def arrive(self, p: list[float], tip: Point) -> None:
        """The move has ended: programmed point and axes."""
        o = self.tool_offset
        self.p = list(p)
        self.q = [tip[0] + o[0], tip[1] + o[1], tip[2] + o[2]]

    # -- output ---------------------------------------------------------------------------------------------------
    def emit(self, move: Move) -> None:
        self.moves.append(move)
        self.sides.append(self.compensation if move.rewritable else None)
        if self.markers is not None:
            self.markers.append(self.marker)

    def remark(self, text: str, column: int = 1, once: str = "") -> None:
        """A remark at the current block; `once`: only the first of its kind."""
        if once:
            if once in self.remarked:
                return
            self.remarked.add(once)
        self.remarks.append(Remark(self.line, column, text))

    def fault(self, column: int, text: str) -> BlockFault:
        return BlockFault(column, text)

    def program_fault(self, line: int, column: int, text: str) -> ProgramFault:
        return ProgramFault(self.name, line, max(column, 1), text)

    def modal(self) -> Modal:
        """Snapshot of the modal state."""
        return Modal(
            self.motion, self.plane, self.unit, self.absolute, self.arc_absolute, self.feed_mode, self.feed or 0.0,
            self.spindle_mode, self.speed, self.offset, self.compensation.side if self.compensation else None,
            self.retract, self.tool, self.tool_offset, self.exact, self.tolerance, self.diameter,
        )  # fmt: skip


def rotation_about(plane: str, angle: float) -> Matrix:
    """Matrix of a turn in a plane, counter-clockwise seen against its normal."""
    from vcmm.nc.moves import PLANES

    a, b, n = PLANES[plane]
    rows = [[0.0] * 3 for _ in range(3)]
    c, s = math.cos(angle), math.sin(angle)
    rows[a][a], rows[a][b], rows[b][a], rows[b][b], rows[n][n] = c, -s, s, c, 1.0
    return ((*rows[0],), (*rows[1],), (*rows[2],))  # type: ignore[return-value]


def apply(matrix: Matrix, p: Point) -> Point:
    x, y, z = p
    r = [row[0] * x + row[1] * y + row[2] * z for row in matrix]
    return (r[0], r[1], r[2])


def transformation(c: Control) -> tuple[Matrix | None, Point]:
    """Matrix and shift of programmed point -> tip: work offset + common + Rz(rotation of the offset) (G92 + G52 + G68(p))."""
    base = c.offsets.get(c.offset, NO_ROTARY)
    inner = [c.g92[i] + c.g52[i] for i in range(3)]
    matrix: Matrix | None = None
    if c.turn is not None:
        plane, centre, angle = c.turn
        matrix = rotation_about(plane, angle)
        turned = apply(matrix, centre)
        inner = [inner[i] + centre[i] - turned[i] for i in range(3)]
    angle = c.rotations.get(c.offset, 0.0)
    shift = (inner[0], inner[1], inner[2])
    if angle:
        outer = rotation_about("XY", angle)
        shift = apply(outer, shift)
        matrix = outer if matrix is None else multiply(outer, matrix)
    return matrix, (
        base[0] + c.common[0] + shift[0],
        base[1] + c.common[1] + shift[1],
        base[2] + c.common[2] + shift[2],
    )


def multiply(a: Matrix, b: Matrix) -> Matrix:
    rows = [[sum(a[i][k] * b[k][j] for k in range(3)) for j in range(3)] for i in range(3)]
    return ((*rows[0],), (*rows[1],), (*rows[2],))  # type: ignore[return-value]


def new_control(name: str, dialect: Dialect, setup: Setup) -> Control:
    """The state at the start of a program: metric, G17, G90, G94, first work offset, axes at machine zero."""
    c = Control(name, dialect, setup)
    c.offsets, c.rotations = dict(setup.offsets), dict(setup.rotations)
    c.tools = dict(setup.tools)
    c.home, c.home2 = setup.reference, setup.second_reference
    c.motion = dialect.default_motion
    c.arc_absolute = dialect.arc_centre == "absolute"
    c.retract = "G99" if dialect.words == "o" else "G98"  # as the controls wake up
    if dialect.lathe:
        c.plane, c.diameter, c.feed_mode = "ZX", True, "G95"
    c.rebuild()
    return c
