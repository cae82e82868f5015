"""State of a control of the G-code family beyond the state common to all languages."""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import dataclass, field
from typing import Any, ClassVar, NoReturn

from vcmm.program.dialects import Dialect
from vcmm.program.faults import BlockFault
from vcmm.program.frames import AffineMap, rotation, stretch, translation
from vcmm.program.iso.expressions import Parameters
from vcmm.program.iso.misfits import ArcMisfit
from vcmm.program.moves import ORIGIN, PLANES, Point
from vcmm.program.recorder import UNMOVED, Recorder
from vcmm.program.setup import Setup, Tool

AXES = "XYZ"
_NO_FEED = Recorder.NO_FEED["G94"]


@dataclass(slots=True)
class PolarWords:
    """G16: the words of the plane are radius (mm) and angle (rad); pole: mm, in the plane."""

    radius: float = 0.0
    angle: float = 0.0
    pole: tuple[float, float] = (0.0, 0.0)


def about(centre: Point, turned: AffineMap) -> AffineMap:
    """Return a turn, mirror or scale about a point."""
    return translation(centre).then(turned).then(translation((-centre[0], -centre[1], -centre[2])))


@dataclass(slots=True, eq=False)
class IsoControl(Recorder):
    """Recorder, registers, shifts and cycles. Functions of the other modules work on it; BlockFault says the column."""

    NO_FEED: ClassVar[Mapping[str, str]] = {
        "G93": "G93 (inverse time) needs a positive F in every block that cuts; add F", "G94": _NO_FEED, "G95": _NO_FEED,
    }  # fmt: skip
    NO_TURNS: ClassVar[str] = (
        "the feed is per turn (G95), but the spindle has no speed; add S before this block"
    )

    language: Dialect = field(kw_only=True)
    next_tool: int = 0
    lead: float | None = None  # of the last thread: F of Fanuc, K of LinuxCNC; mm
    turning_feed: float | None = None  # F as written: degrees per minute where rotary axes alone move
    length_word: int = 0  # H in force
    radius_word: int | None = None  # D in force
    misfits: list[ArcMisfit] = field(default_factory=list)
    g92: Point = ORIGIN
    g92_kept: Point = ORIGIN
    g52: Point = ORIGIN
    turn: tuple[str, Point, float] | None = None  # G68: plane, centre, angle
    scale: tuple[Point, Point] | None = None  # G51: centre, factors
    mirrors: dict[int, float] = field(default_factory=dict)  # G51.1: axis -> where its mirror stands
    tilt: AffineMap = UNMOVED  # G68.2
    is_tilt_given: bool = False
    plane_words: dict[int, tuple[Point, Point, float]] = field(
        default_factory=dict
    )  # of G68.2 P2, P3 so far: X Y Z, I J K, R
    vectors: bool = False  # G43.5: I J K of a line are the direction of the tool
    polar: PolarWords | None = None  # G16
    winding: Any = None  # G12.1, G7.1: vcmm.program.iso.winding.Winding
    wound_from: Any = None  # the last one of polar interpolation
    base_motion: str = "G0"  # what G80 leaves in force, where cycles are a group of their own
    unit_said: bool = False  # G20 or G21 has been read
    turning_words: dict[str, dict[str, float]] = field(
        default_factory=dict
    )  # of the first of two blocks of G71 to G76, by kind, mm
    c_turns: bool = False  # the program moves an axis C
    points_written: bool = False  # all coordinates of the program have a decimal point
    leaving: tuple[Point, tuple[float, float]] | None = None  # end of the last G5, and its P and Q
    arcs_seen: bool = False  # an arc has been read: how its centre counts is settled
    tools: dict[int, Tool] = field(default_factory=dict)
    lengths: dict[int, float] = field(default_factory=dict)  # length registers set by G10
    radii: dict[int, float] = field(default_factory=dict)
    home: Point = ORIGIN
    home2: Point = ORIGIN
    between: dict[int, float] = field(default_factory=dict)  # by axis XYZABC: where G28 has gone by, for G29
    cycle: dict[str, float] = field(default_factory=dict)
    cycle_level: float | None = None  # initial level of a series of cycles
    counted_on: frozenset[str] = frozenset()  # of R and Z (the depth) of the cycle: those given under G91
    has_contact: bool = False  # whether the last probing move met anything
    has_ended: bool = False
    state_of_m70: tuple[object, ...] | None = None  # M70
    states_of_m73: list[tuple[object, ...] | None] = field(
        default_factory=list
    )  # M73, for each subprogram under way
    parameters: Parameters = field(init=False)  # set by parameters.attach

    # -- what this family does in its own way --
    def fault(self, text: str, column: int | None = None) -> NoReturn:
        """Raises BlockFault: the reader adds file and line."""
        raise BlockFault(column or self.column, text)

    def speed_at_centre(self) -> float:
        """Return the spindle speed at the centre: with constant surface speed and no limit the spindle is taken to be at rest."""
        return 0.0

    def surface_speed(self) -> float:
        """Return the surface speed in mm/min, from m/min or, in inches, ft/min."""
        return self.speed * (304.8 if self.unit > 1.0 else 1000.0)

    def feeding(self, x: float) -> float:
        """Turns per minute that a feed per turn counts, at radius x: the spindle need not have been started."""
        turns = self.turns(x)
        return turns if math.isfinite(turns) else 0.0

    def line_feed(self, start: Point, end: Point, rotary: Point) -> float | None:
        """Return the feed in mm/min; degrees per minute, whatever the unit of length, where rotary axes alone move."""
        distance = math.dist(start, end) or self.turn_angle(rotary)
        feed = self.rate(distance, self.feeding((start[0] + end[0]) / 2.0 - self.world.shift[0]))
        alone = start == end and rotary != self.rotary and self.feed_mode == "G94"
        if not alone or feed is None:
            return feed
        return feed / self.unit if self.turning_feed is None else self.turning_feed

    def rebuild(self) -> None:
        """Rebuild the program's frame G92 + G52 + turn of G68, after one of them or a work offset has changed."""
        shift = [self.g92[i] + self.g52[i] for i in range(3)]
        frame = translation((shift[0], shift[1], shift[2])).then(self.tilt)
        if self.turn is not None:
            plane, centre, angle = self.turn
            frame = frame.then(about(centre, rotation(PLANES[plane][2], angle)))
        if self.scale is not None:
            frame = frame.then(about(self.scale[0], stretch(self.scale[1])))
        for axis, at in self.mirrors.items():
            centre = (at if axis == 0 else 0.0, at if axis == 1 else 0.0, at if axis == 2 else 0.0)
            factors = tuple(-1.0 if i == axis else 1.0 for i in range(3))
            frame = frame.then(about(centre, stretch((factors[0], factors[1], factors[2]))))
        self.frame = frame
        self.refresh()

    def set_unit(self, unit: float) -> None:
        """Set the mm per unit of the program; the feed counts in it too."""
        self.unit = self.feed_scale = unit


def mirrored_for(c: IsoControl, spindle: int) -> None:
    """Mirror for a spindle. Haas lathes: G14 gives the words to the second spindle and mirrors Z; G15 ends both (lathe operator's manual,
    G14 and G15)."""
    c.mirrors = {axis: at for axis, at in c.mirrors.items() if axis != 2} | ({2: 0.0} if spindle == 2 else {})
    c.rebuild()


def new_control(name: str, language: Dialect, setup: Setup) -> IsoControl:
    """Return the state at the start of a program: metric, G17, G90, G94, first work offset, axes at machine zero."""
    c = IsoControl(file=name, dialect=language.name, setup=setup, language=language)
    c.tools = dict(setup.tools)
    c.home, c.home2 = setup.reference, setup.second_reference
    c.motion, c.absolute = language.default_motion, language.absolute
    c.arc_absolute = language.arc_centre == "absolute"
    c.retract = "G98" if language.cycles_apart else "G99"  # as the controls wake up
    if language.lathe:
        c.plane, c.diameter, c.feed_mode = "ZX", "always", "G95"
    if setup.unit is not None:
        c.set_unit(setup.unit)
        c.unit_said = True
    c.rebuild()
    return c
