"""State of a Sinumerik control beyond the state common to all languages, and the words of one block."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

from vcmm.program.cycle_tables import Cycle, Values, in_units
from vcmm.program.expressions import number
from vcmm.program.facing import EndFace
from vcmm.program.faults import BlockFault
from vcmm.program.frames import AffineMap
from vcmm.program.moves import ORIGIN, Point
from vcmm.program.radius import SINUMERIK, Style
from vcmm.program.recorder import UNMOVED, Recorder
from vcmm.program.setup import Tool
from vcmm.program.sinumerik.blocks import Item, SinumerikBlock
from vcmm.program.sinumerik.flow import SinumerikRunner

AXES, ROTARY, CENTRES = "XYZ", "ABC", "IJK"


@dataclass(eq=False)
class SinumerikModes:
    """Modal state beyond that of the recorder."""

    feed_unit: float = 1.0  # mm per unit of F
    style: Style = SINUMERIK
    next_tool: Tool | None = None
    next_name: str = ""
    by_m6: bool = False
    cycle: Item | None = None
    cycle_line: int = 0  # where it is defined
    calling: bool = False  # it is being executed
    rnd: float = 0.0  # RNDM
    swivel: AffineMap = UNMOVED  # of CYCLE800, outside the frame that the program programs
    frame: AffineMap = UNMOVED
    fine: Point = ORIGIN  # the part of the shift of `frame` that G59 and ATRANS have added, mm
    turns: Point = ORIGIN  # shift of the rotary axes by TRANS, rad
    by_axes: bool = False  # PTP is on
    face: EndFace | None = None  # TRANSMIT is on
    last_face: EndFace | None = None  # the last one
    master: int = 1  # the spindle of S and M3 without a number (SETMS)
    turning: dict[int, tuple[int, float]] = field(
        default_factory=dict
    )  # sense and speed of the other spindles
    pole: Point = ORIGIN  # G110 to G112, mm


@dataclass(eq=False)
class SinumerikWords:
    """The words of one block, taken as they are used; words left over at the end are refused."""

    runner: SinumerikRunner
    block: SinumerikBlock
    g: dict[str, int] = field(default_factory=dict)  # G functions and their columns
    m: list[int] = field(default_factory=list)
    items: dict[str, Item] = field(default_factory=dict)
    commands: list[Item] = field(default_factory=list)
    by_itself: bool = False  # POS[X]=: an axis on its own, at rapid

    def has(self, *names: str) -> bool:
        return not self.items.keys().isdisjoint(names)

    def take(self, name: str) -> float | None:
        item = self.items.pop(name, None)
        return None if item is None else self.number(item)

    def number(self, item: Item) -> float:
        if item.value is None:
            raise BlockFault(item.first, f"{item.name} takes a number, as in {item.name}=12.5")
        return number(item.value, self.runner)


SAVED_MODES = (
    "motion",
    "plane",
    "unit",
    "absolute",
    "feed_mode",
    "offset",
    "compensation",
    "exact_stop",
    "tolerance",
    "diameter",
)


class SinumerikControl:
    """Recorder and modes. `column`: of the function being executed, for messages."""

    def __init__(self, recorder: Recorder, by_m6: bool) -> None:
        self.r, self.modes = recorder, SinumerikModes(by_m6=by_m6)
        self.column = 1

    def values(
        self, row: Cycle[Any], arguments: Sequence[float | None] | Mapping[str, float], name: str = ""
    ) -> Values:
        """Return the inputs of a cycle of a table: arguments in their order, or numbers by name. Those behind the last known one are noted."""
        named = arguments if isinstance(arguments, Mapping) else row.by_name(arguments)
        count = len(row.parameters)
        if not isinstance(arguments, Mapping) and name and any(arguments[count:]):
            numbers = ", ".join(f"{v:g}" for v in arguments[count:] if v)
            self.r.assume(
                f"arguments of {name} behind number {count} ({numbers})", "passed over", matters=False
            )
        return row.read(named, in_units(self.r.unit, self.modes.feed_unit))

    def frames(self, frame: AffineMap, swivel: AffineMap | None = None) -> None:
        """Set the frame of the program, and that of CYCLE800 around it."""
        self.modes.frame = frame
        self.modes.swivel = self.modes.swivel if swivel is None else swivel
        self.r.set_frame(self.modes.swivel.then(frame))

    def modal_state(self) -> tuple[object, ...]:
        """Return the modal G functions and frames, for PROC ... SAVE."""
        return (*(getattr(self.r, name) for name in SAVED_MODES), self.modes.frame, self.modes.swivel)

    def restore(self, before: tuple[object, ...]) -> None:
        """Restore the modal G functions and frames of the caller."""
        for name, value in zip(SAVED_MODES, before):
            setattr(self.r, name, value)
        if before[-2:] != (self.modes.frame, self.modes.swivel):
            self.frames(before[-2], before[-1])  # type: ignore[arg-type]
        self.r.refresh()


def written_word(words: SinumerikWords, item: Item) -> str:
    """Return the word of an item that is left over: K-2, CR=5; its name alone where it has no number."""
    if item.value is None:
        return item.name
    number = f"{words.number(item):g}"
    return f"{item.name}{number}" if len(item.name) == 1 else f"{item.name}={number}"
