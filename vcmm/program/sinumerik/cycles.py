"""The cycles of Sinumerik, and the module of each; hole patterns as a table: HOLES1 HOLES2 CYCLE801 CYCLE802.

Source: Siemens, Programming Manual Cycles; SINUMERIK 840D sl / 828D, Programming Manual Cycles (HMI), "Drilling patterns".
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence

from vcmm.program.cutter import CycleCutter, Flat
from vcmm.program.cycle_tables import Cycle, Values, cycle
from vcmm.program.drilling import whole_count
from vcmm.program.expressions import evaluate
from vcmm.program.hole_patterns import hole_circle, hole_grid, hole_line
from vcmm.program.sinumerik.blocks import Item
from vcmm.program.sinumerik.drilling import DRILLING, drill
from vcmm.program.sinumerik.flow import SinumerikRunner
from vcmm.program.sinumerik.measuring import MEASURED, measure
from vcmm.program.sinumerik.milling import MILLING, mill
from vcmm.program.sinumerik.paths import SinumerikPaths
from vcmm.program.sinumerik.swivelling import swivel
from vcmm.program.sinumerik.traces import cycle_words
from vcmm.program.sinumerik.turning import TURNING, turn

Pattern = Callable[[SinumerikPaths, Values], list[Flat]]


def row(i: SinumerikPaths, v: Values) -> list[Flat]:
    """Return the places of HOLES1: on a line, from the end that is nearer to the tool."""
    distances = [v["FDIS"] + k * v["DBH"] for k in range(whole_count(v["NUM"]))]
    out, here = hole_line((v["SPCA"], v["SPCO"]), v["STA1"], distances), CycleCutter(i.r).here()
    return out[::-1] if out and math.dist(out[-1], here) < math.dist(out[0], here) else out


def circle(i: SinumerikPaths, v: Values) -> list[Flat]:
    """Return the places of HOLES2: INDA 0 spreads them evenly."""
    step = v["INDA"] or 360.0 / max(v["NUM"], 1.0)
    angles = [math.radians(v["STA1"] + k * step) for k in range(whole_count(v["NUM"]))]
    return hole_circle((v["CPA"], v["CPO"]), v["RAD"], angles)


def rows(i: SinumerikPaths, v: Values) -> list[Flat]:
    """Return the places of CYCLE801: along the shorter of the two distances."""
    counts = whole_count(abs(v["NUM1"])), whole_count(abs(v["NUM2"]))
    along = v["DIS1"] <= v["DIS2"]
    return hole_grid((v["SPCA"], v["SPCO"]), v["STA"], counts, (v["DIS1"], v["DIS2"]), along)


def list_spots(i: SinumerikPaths, v: Values) -> list[Flat]:
    """Return the places of CYCLE802: X0 and Y0 as they are; 9 points at most."""
    count = math.ceil(sum(v.has(name) for k in range(9) for name in (f"X{k}", f"Y{k}")) / 2)
    return [(v[f"X{k}"], v[f"Y{k}"]) for k in range(count)]


PATTERNS: Mapping[str, Cycle[Pattern]] = {
    "HOLES1": cycle("SPCA mm, SPCO mm, STA1 deg, FDIS mm, DBH mm, NUM count", row),
    "HOLES2": cycle("CPA mm, CPO mm, RAD size, STA1 plain, INDA plain, NUM count", circle),
    "CYCLE801": cycle("SPCA mm, SPCO mm, STA deg, DIS1 size, DIS2 size, NUM1 count, NUM2 count", rows),
    "CYCLE802": cycle("XA count, YA count, " + ", ".join(f"X{k} mm?, Y{k} mm?" for k in range(9)), list_spots),
}  # fmt: skip


def visit(i: SinumerikPaths, runner: SinumerikRunner, item: Item, arguments: Sequence[float | None]) -> None:
    """Visit each point at rapid; the modal cycle at each."""
    row = PATTERNS[item.name]
    for a, b in row.primitive(i, i.values(row, arguments, item.name)):
        CycleCutter(i.r).to((a, b), None, True)
        if i.modes.cycle is not None:
            i.command(runner, i.modes.cycle, 1)


MODAL_ONLY = (*PATTERNS, "CYCLE800", "CYCLE832")  # their moves are no cycle's
CycleRun = Callable[[SinumerikPaths, SinumerikRunner, Item, Sequence[float | None]], None]


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


CYCLES: Mapping[str, CycleRun] = {
    **dict.fromkeys(DRILLING, drill), "CYCLE832": tolerance, "CYCLE800": lambda i, runner, item, arguments: swivel(i, item, arguments),
    **dict.fromkeys(PATTERNS, visit), **dict.fromkeys(MILLING, mill), **dict.fromkeys(TURNING, turn), **dict.fromkeys(MEASURED, measure),
}  # fmt: skip
