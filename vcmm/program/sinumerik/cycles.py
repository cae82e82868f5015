"""The cycles of Sinumerik, and the module of each. Source: Siemens, Programming Manual Cycles."""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence

from vcmm.program.expressions import evaluate
from vcmm.program.sinumerik.blocks import Item
from vcmm.program.sinumerik.drilling import DRILLING, drill
from vcmm.program.sinumerik.flow import SinumerikRunner
from vcmm.program.sinumerik.measuring import MEASURED, measure
from vcmm.program.sinumerik.milling import MILLING, mill
from vcmm.program.sinumerik.paths import SinumerikPaths
from vcmm.program.sinumerik.patterns import PATTERNS, visit
from vcmm.program.sinumerik.swivelling import swivel
from vcmm.program.sinumerik.traces import cycle_words
from vcmm.program.sinumerik.turning import TURNING, turn

MODAL_ONLY = (*PATTERNS, "CYCLE800", "CYCLE832")  # their moves are no cycle's
Cycle = Callable[[SinumerikPaths, SinumerikRunner, Item, Sequence[float | None]], None]


def arguments_of(runner: SinumerikRunner, item: Item) -> list[float | None]:
    """Return the arguments of a cycle now."""
    values = [None if a is None else evaluate(a, runner) for a in item.arguments or ()]
    return [None if isinstance(v, str) else v for v in values]


def tolerance(
    i: SinumerikPaths, runner: SinumerikRunner, item: Item, arguments: Sequence[float | None]
) -> None:
    """Read CYCLE832(tolerance, mode): the contour tolerance, mm; mode 0 switches it off."""
    value = arguments[0] if arguments else None
    off = value is None or (len(arguments) > 1 and arguments[1] == 0)
    i.r.tolerance = None if off or value is None else value * i.r.unit


def run(i: SinumerikPaths, runner: SinumerikRunner, item: Item, line: int = 0) -> None:
    """Run a cycle, its moves marked with its name. line: where it is defined, 0 for the block under way."""
    tracer = i.r.tracer
    if tracer is not None:
        at = line or i.r.line
        tracer.cycle = cycle_words(item, tracer.lines[at - 1], at)
    i.r.marker = "" if item.name in MODAL_ONLY else item.name
    CYCLES[item.name](i, runner, item, arguments_of(runner, item))
    i.r.marker = ""


CYCLES: Mapping[str, Cycle] = {
    **dict.fromkeys(DRILLING, drill), "CYCLE832": tolerance, "CYCLE800": lambda i, runner, item, arguments: swivel(i, item, arguments),
    **dict.fromkeys(PATTERNS, visit), **dict.fromkeys(MILLING, mill), **dict.fromkeys(TURNING, turn), **dict.fromkeys(MEASURED, measure),
}  # fmt: skip
