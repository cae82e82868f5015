"""Which cycles of Sinumerik there are, and who makes each. Source: Siemens, Programming Manual Cycles."""

from __future__ import annotations

from collections.abc import Callable

from vcmm.program.expressions import evaluate
from vcmm.program.sinumerik.blocks import Item
from vcmm.program.sinumerik.flow import SinumerikRunner
from vcmm.program.sinumerik.state import SinumerikControl
from vcmm.program.sinumerik.traces import cycle_words

MODAL_ONLY = (
    "HOLES1",
    "HOLES2",
    "CYCLE801",
    "CYCLE802",
    "CYCLE800",
    "CYCLE832",
)  # their moves are no cycle's
Cycle = Callable[[SinumerikControl, SinumerikRunner, Item], None]


def arguments_of(runner: SinumerikRunner, item: Item) -> list[float | None]:
    """The arguments of a cycle now."""
    values = [None if a is None else evaluate(a, runner) for a in item.arguments or ()]
    return [None if isinstance(v, str) else v for v in values]


def drill(i: SinumerikControl, runner: SinumerikRunner, item: Item) -> None:
    """CYCLE81 to CYCLE89, CYCLE840."""
    from vcmm.program.sinumerik.drilling import drill

    drill(i, item, arguments_of(runner, item))


def swivel(i: SinumerikControl, runner: SinumerikRunner, item: Item) -> None:
    """CYCLE800."""
    from vcmm.program.sinumerik.swivelling import swivel

    swivel(i, item, arguments_of(runner, item))


def pattern(i: SinumerikControl, runner: SinumerikRunner, item: Item) -> None:
    """HOLES1, HOLES2, CYCLE801, CYCLE802."""
    from vcmm.program.sinumerik.patterns import visit

    visit(i, runner, item, arguments_of(runner, item))  # type: ignore[arg-type]


def mill(i: SinumerikControl, runner: SinumerikRunner, item: Item) -> None:
    """POCKET1 to POCKET4, CYCLE61, CYCLE71, CYCLE72, CYCLE90, SLOT1, LONGHOLE."""
    from vcmm.program.sinumerik.milling import mill

    mill(i, runner, item, arguments_of(runner, item))  # type: ignore[arg-type]


def turn_contour(i: SinumerikControl, runner: SinumerikRunner, item: Item) -> None:
    """CYCLE95, CYCLE97."""
    from vcmm.program.sinumerik.turning import turn

    turn(i, runner, item, arguments_of(runner, item))  # type: ignore[arg-type]


def measure(i: SinumerikControl, runner: SinumerikRunner, item: Item) -> None:
    """CYCLE976 to CYCLE979, CYCLE998."""
    from vcmm.program.sinumerik.measuring import measure

    measure(i, runner, item, arguments_of(runner, item))


def tolerance(i: SinumerikControl, runner: SinumerikRunner, item: Item) -> None:
    """CYCLE832(tolerance, mode): the contour tolerance, mm; mode 0 switches it off."""
    given = arguments_of(runner, item)
    value = given[0] if given else None
    off = value is None or (len(given) > 1 and given[1] == 0)
    i.r.tolerance = None if off or value is None else value * i.r.unit


def run(i: SinumerikControl, runner: SinumerikRunner, item: Item, line: int = 0) -> None:
    """A cycle, its moves marked with its name. line: where it is defined, 0 for the block under way."""
    tracer = i.r.tracer
    if tracer is not None:
        at = line or i.r.line
        tracer.cycle = cycle_words(item, tracer.lines[at - 1], at)
    i.r.marker = "" if item.name in MODAL_ONLY else item.name
    CYCLES[item.name](i, runner, item)
    i.r.marker = ""


CYCLES: dict[str, Cycle] = {
    "CYCLE81": drill, "CYCLE82": drill, "CYCLE83": drill, "CYCLE84": drill, "CYCLE840": drill, "CYCLE85": drill, "CYCLE86": drill, "CYCLE87": drill,
    "CYCLE88": drill, "CYCLE89": drill, "CYCLE832": tolerance, "CYCLE800": swivel, "HOLES1": pattern, "HOLES2": pattern, "CYCLE801": pattern,
    "CYCLE802": pattern, "POCKET1": mill, "POCKET2": mill, "POCKET3": mill, "POCKET4": mill, "CYCLE71": mill,
    "CYCLE61": mill, "CYCLE72": mill, "CYCLE90": mill, "SLOT1": mill, "LONGHOLE": mill,
    "CYCLE95": turn_contour, "CYCLE97": turn_contour, "CYCLE976": measure, "CYCLE977": measure, "CYCLE978": measure, "CYCLE979": measure,
    "CYCLE998": measure,
}  # fmt: skip
