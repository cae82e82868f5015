"""What a Sinumerik control remembers beyond the state that all languages share, and the words of one block."""

from __future__ import annotations

from dataclasses import dataclass, field

from vcmm.nc.expressions import number
from vcmm.nc.faults import BlockFault
from vcmm.nc.moves import Point
from vcmm.nc.radius import SINUMERIK, Style
from vcmm.nc.recorder import Recorder
from vcmm.nc.setup import Tool
from vcmm.nc.sinumerik.blocks import Item, SinumerikBlock
from vcmm.nc.sinumerik.flow import SinumerikRunner

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
    rnd: float = 0.0  # RNDM


@dataclass(eq=False)
class SinumerikWords:
    """The words of one block, taken as they are used; what is left over at the end is refused."""

    runner: SinumerikRunner
    block: SinumerikBlock
    g: dict[str, int] = field(default_factory=dict)  # G functions and their columns
    m: list[int] = field(default_factory=list)
    items: dict[str, Item] = field(default_factory=dict)
    commands: list[Item] = field(default_factory=list)

    def has(self, *names: str) -> bool:
        return any(n in self.items for n in names)

    def take(self, name: str) -> float | None:
        item = self.items.pop(name, None)
        return None if item is None else self.number(item)

    def number(self, item: Item) -> float:
        if item.value is None:
            raise BlockFault(item.first, f"{item.name} takes a number, as in {item.name}=12.5")
        return number(item.value, self.runner)


class SinumerikControl:
    """Recorder and modes. `column`: of the function being executed, for messages."""

    def __init__(self, recorder: Recorder, by_m6: bool) -> None:
        self.r, self.modes = recorder, SinumerikModes(by_m6=by_m6)
        self.column = 1


def point_of(values: list[float]) -> Point:
    return values[0], values[1], values[2]
