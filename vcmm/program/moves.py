"""Move: the canonical motion that every dialect of NC program is turned into. Time law, cutting and rewriting see only this.

Points are tool-tip positions (x, y, z) in mm, machine axes, the tool length taken off: work offset plus programmed point.
The position of an axis is the point plus the tool offset in force (`tool_offset`). For a primed axis both are in the
tool-relative sense in which the axis is commanded (conventions: motion sense of workpiece axes).
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any, ClassVar, NamedTuple

from vcmm.program.levels import Assumption, UnusedWord

Point = tuple[float, float, float]
PLANES = {"XY": (0, 1, 2), "ZX": (2, 0, 1), "YZ": (1, 2, 0)}  # first axis, second axis, normal: right-handed
ORIGIN: Point = (0.0, 0.0, 0.0)


class Source(NamedTuple):
    """Place of a move in the text: line from 1, columns from 1 (first, one past the last)."""

    line: int
    first: int
    last: int


class Posture(NamedTuple):
    """Choice among the positions of the rotary axes with the same tool direction; without one it is the nearest.

    sign: of the angle of that axis (PLANE SEQ+, G53.1 P1). larger: its larger (+1) or smaller (-1) value of the
    two (PLANE SYM+, CYCLE800). axis: "primary" (HEIDENHAIN), "first" (FANUC, Siemens): defined in vcmm.shop.motion.posture.
    binding: a position beyond the travels is refused; else the other is taken.
    along: direction of the workpiece that a free rotary axis turns along X of the machine (TABLE ROT). keeps_tip: the tip stays where
    it is on the workpiece while they turn (G53.6, MOVE), else X, Y and Z keep their positions. words: those of the program. by_axis: of several the
    one whose one axis turns least counts before the other (FANUC), else the one whose largest turn is least.
    """

    axis: str = "primary"
    sign: int = 0
    larger: int = 0
    binding: bool = True
    along: Point | None = None
    keeps_tip: bool = False
    words: str = ""
    by_axis: bool = False


class Move(NamedTuple):
    """One motion. A NamedTuple: programs have 10^5 of them.

    kind: "rapid" | "line" | "arc" | "thread" | "dwell".
    feed: mm/min along the path; None for rapids and dwells, and where a survey does not know it. Inverse time and per-turn feeds are already converted.
    turns: started turns of an arc, 1 up to a full circle; a helix has an end beside its plane. clockwise as seen
    against the normal of the plane (G2), None unless it is an arc.
    compensation: "left" | "right" while cutter radius compensation is on; the points are those of the centre path.
    is_tip_led: tool centre point control or a tilted plane: the points are those of the tip in the workpiece as it lies with the
    rotary axes at zero, the tool is long along its own axis, and the rotary axes follow their words or the tool axis.
    """

    kind: str
    source: Source
    start: Point
    end: Point
    rotary_start: Point = ORIGIN  # A, B, C in rad
    rotary_end: Point = ORIGIN
    plane: str = "XY"
    centre: Point | None = None
    turns: int = 1
    clockwise: bool | None = None
    feed: float | None = None
    spindle: float = 0.0  # turns per minute, signed: plus = clockwise seen from the spindle (M3)
    tool: int = 0
    tool_offset: Point = ORIGIN  # mm, added to a point to get the position of the axes
    compensation: str | None = None
    seconds: float = 0.0  # of a dwell
    exact_stop: bool = False  # G9, G61: speed zero at the end
    tolerance: float | None = (
        None  # mm, by which the corner at the end may be rounded (G64 P, CYCLE832); None = the control's own
    )
    offset: str = "G54"  # work offset in force
    rewritable: bool = True  # False where the axes run in machine coordinates (G28, G53): never rewritten
    is_tip_led: bool = False  # the tip is led over the workpiece: see above
    tool_axis_start: Point | None = (
        None  # unit vectors from the tip to the spindle, workpiece axes; None: as A, B, C stand
    )
    tool_axis_end: Point | None = None
    over_face: bool = False  # polar interpolation: X and C lead the tip over the end face, Y is at rest
    work_spindle: int = 1  # which spindle holds the part: 2 = the sub-spindle
    posture: Posture | None = None  # which position of the rotary axes brings the tool along its axis
    sweeps: bool = False  # the tool axis stays in the plane of its directions at both ends; else the rotary axes run in proportion
    unmoved_axes: str = ""  # axes that no word has moved since the tip was led: they stand where the control has left them, "XYABC"


class Remark(NamedTuple):
    """A remark about a program that is understood all the same."""

    line: int
    column: int
    text: str


class MoveFlow:
    """Takes the moves of a program as they come, so that a long one need not be held. count: how many have come."""

    CHUNK: ClassVar[int] = 20_000

    def __init__(self) -> None:
        self.count = 0

    def take(self, moves: Sequence[Move]) -> None:
        """Take the next moves."""
        self.count += len(moves)

    def restart(self) -> None:
        """Forget the moves so far: they were read in the wrong dialect."""
        self.count = 0


@dataclass(frozen=True, eq=False)
class Program:
    """Moves of a program with its remarks and state."""

    dialect: str
    moves: tuple[Move, ...]
    warnings: tuple[Remark, ...] = ()
    tools: Mapping[int, str] = field(default_factory=dict)  # numbers called and what the program calls them
    offsets: Mapping[str, Source] = field(default_factory=dict)  # work offsets that it names, and where first
    traces: tuple[Any, ...] = ()  # vcmm.program.trace.Trace of each move, on request
    steps: tuple[Any, ...] = ()  # vcmm.program.trace.Step of each executed block, with the traces
    assumed: tuple[Assumption, ...] = ()  # what the program lacks and the survey took for granted
    touches: tuple[
        Any, ...
    ] = ()  # vcmm.program.touching.ProbeContact of each probing move that met a surface, in order
    unused: tuple[UnusedWord, ...] = ()  # words that nothing uses, in order of their lines
    dialect_reason: str = ""  # why this dialect was taken, where it was guessed
