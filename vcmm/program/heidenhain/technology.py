"""Words of a Klartext block beside its coordinates: feed, side of the tool, M functions.

Source: HEIDENHAIN, TNC 640 User's Manual Klartext Programming, "Feed rate F", "Tool compensation", "Miscellaneous functions".
"""

from __future__ import annotations

from dataclasses import dataclass, field

from vcmm.program.frames import in_plane
from vcmm.program.heidenhain import codes
from vcmm.program.heidenhain.approach import ApproachBlock
from vcmm.program.heidenhain.cycles import KlartextCycles
from vcmm.program.heidenhain.words import BESIDE, KlartextWords
from vcmm.program.leading import name_axes
from vcmm.program.levels import SetupEntry, pass_over
from vcmm.program.offsetting import Vec
from vcmm.program.radius import HEIDENHAIN
from vcmm.program.recorder import Recorder
from vcmm.program.setup import Tool


@dataclass(eq=False)
class KlartextTechnology:
    """Recorder, cycles, and what holds from block to block in Klartext alone."""

    r: Recorder
    cycles: KlartextCycles
    pole: list[float] = field(default_factory=lambda: [0.0, 0.0, 0.0])
    has_pole: bool = False  # a CC was programmed
    tangent: Vec | None = None  # direction of the last element at its end, as programmed
    last_rapid: bool = False
    modal_call: bool = False
    auto_feed: float | None = None
    extra_radius: float = 0.0
    approach_blocks: list[ApproachBlock] = field(default_factory=list)
    definitions: dict[int, Tool] = field(default_factory=dict)  # by TOOL DEF
    moved_axes: set[int] = field(default_factory=set)  # axes that have been sent somewhere
    shortest: bool = False  # M126
    per_turn: bool = False  # M136
    spatial: list[float] | None = (
        None  # TCPM AXIS SPAT: A B C are spatial angles, deg; those that no block has said yet are nan
    )
    machine: dict[int, float] = field(default_factory=dict)  # last position given with M91, mm

    # -- what precedes a motion --
    def technology(self, words: KlartextWords) -> bool:
        """Execute feed, side and M functions that act before the motion. True where the motion is at rapid."""
        name_axes(self.r, "".join("XYZ" if n[-2:] in ("PR", "PA") else n[-1] for n in words.values))
        self.feed_words(words)
        self.beside(words)
        if words.has_side:
            self.side(words)
        for m in words.m:
            if m in (3, 4, 13, 14):
                self.r.sense = 1 if m in (3, 13) else -1
            elif m in (codes.SHORTEST, codes.LONGEST):
                self.shortest = m == codes.SHORTEST
            elif m in (codes.TURN_FEED, codes.MINUTE_FEED):
                self.per_turn = m == codes.TURN_FEED
                self.r.feed_mode = "G95" if self.per_turn else "G94"
            elif m in (codes.TIP, codes.TIP_OFF):
                self.tip(m == codes.TIP, words.columns[f"M{m}"])
            elif m == codes.NO_ROTATION:
                self.r.free("the basic rotation is deleted")
                self.r.rotations[self.r.offset] = 0.0
                self.r.refresh()
            elif m not in (5, *codes.READ, codes.RETRACT, *codes.IDLE_M):
                codes.strange(self.r, m, words.columns[f"M{m}"])
        return words.rapid

    def feed_words(self, words: KlartextWords) -> None:
        """Read the feed: F, FU, FZ, F AUTO."""
        r = self.r
        if words.feed_kind == "AUTO":
            if self.auto_feed is None:
                r.assume(
                    "the feed of TOOL CALL, for F AUTO", "not known; its time is not counted",
                    "F AUTO takes the feed of TOOL CALL, which has none; add F there",
                )  # fmt: skip
            r.feed, r.feed_mode = self.auto_feed, "G94"
        elif words.feed is not None:
            turning = words.feed_kind in ("FU", "FZ") or self.per_turn
            r.feed = self.feed_of(words.feed, words.feed_kind) * (
                self.teeth() if words.feed_kind == "FZ" else 1.0
            )
            r.feed_mode = "G95" if turning else "G94"

    def teeth(self) -> float:
        """Return the number of teeth of the tool, for a feed per tooth."""
        tool = self.r.tool_data
        if tool.teeth is None:
            self.r.assume(
                f"the teeth of tool {tool.number}", "1",
                "FZ (feed per tooth) needs the number of teeth; state teeth of the tool in the set-up, or write F in mm/min",
                blank=SetupEntry(f"tools.{tool.number}", "teeth", "4"), matters=False,
            )  # fmt: skip
        return float(tool.teeth or 1)

    def side(self, words: KlartextWords) -> None:
        """Set the side, R0 RL RR; in a plane that is tilted the contour itself is the path."""
        if words.side and in_plane(self.r.world, self.r.plane) is None:
            what = "radius compensation in a tilted plane"
            self.r.assume(
                what,
                "none: the path on the programmed contour",
                f"{what} is not understood; program the path of the tool",
            )
            self.r.compensate(None, HEIDENHAIN)
            return
        self.r.compensate(words.side, HEIDENHAIN, self.extra_radius)

    def tip(self, on: bool, column: int | None = None) -> None:
        """Switch on or off M128, FUNCTION TCPM: the tip keeps to the programmed points while rotary axes turn."""
        self.cycles.frames.lead(on)
        if on:
            self.r.assume(
                "M128 or TCPM (the tip is led while rotary axes turn)", "the points of the tip as programmed",
                column=column, matters=False,
            )  # fmt: skip
        else:
            self.r.aim, self.spatial, self.r.sweeps = None, None, False
            self.r.assume(
                "the end of M128 (M129)", "passed over", column=column, matters=False,
            )  # fmt: skip

    def beside(self, words: KlartextWords) -> None:
        """Read the parallel axes U, V and W."""
        for name in (*BESIDE, *(f"I{a}" for a in BESIDE)):
            if words.take(name) is not None:
                self.r.assume(
                    f"the axis {name[-1]}", "its motion is passed over",
                    f"{name[-1]} is not understood in this block; rewrite it with L, C, CR and plain coordinates", column=words.columns[name],
                )  # fmt: skip

    def feed_of(self, value: float, kind: str) -> float:
        """Return the feed in mm/min or mm per turn. In INCH programs F counts 0.1 inch/min, FU inch per turn."""
        if self.r.unit > 1.0 and kind == "F" and not self.per_turn:
            self.r.remark("F in an INCH program is read as 0.1 inch/min, as TNC controls do")
        per_turn = kind in ("FU", "FZ") or self.per_turn
        return value * ((25.4 if per_turn else 2.54) if self.r.unit > 1.0 else 1.0)

    def after(self, words: KlartextWords) -> bool:
        """Execute M functions that act after the motion. True at the end of the program."""
        if 89 in words.m:
            self.modal_call = True
            if words.has_moved:
                self.r.assume(
                    "whether M89 calls the cycle in its own block", 'it does: "program the first cycle call with M89" (TNC 640); in the technical '
                    "manual of the TNC 306 every following positioning block does",
                )  # fmt: skip
        if 99 in words.m or (self.modal_call and words.has_moved):
            self.cycles.call()
        if 99 in words.m:
            self.modal_call = False
        if 5 in words.m:
            self.r.sense = 0
        self.leftover(words)
        return 2 in words.m or 30 in words.m

    def leftover(self, words: KlartextWords) -> None:
        """Note words without use in the block, such as a rotary axis in an arc."""
        for name in list(words.values):
            value = words.take(name)
            pass_over(self.r, f"{name}{value:+g}", words.columns[name], name=name)
