"""Drilling cycles of Sinumerik: CYCLE81 CYCLE82 CYCLE83, and CYCLE832. Source: Siemens, Programming Manual Cycles."""

from __future__ import annotations

from collections.abc import Callable

from vcmm.nc.faults import BlockFault
from vcmm.nc.moves import PLANES, Point
from vcmm.nc.sinumerik.blocks import Item
from vcmm.nc.sinumerik.flow import Runner
from vcmm.nc.sinumerik.state import Control
from vcmm.nc.sinumerik.traces import cycle_words

CHIP_BREAK = 1.0  # mm of retraction with VARI=0
Cycle = Callable[[Control, Runner, Item], None]


class Hole:
    """The common arguments RTP, RFP, SDIS, DP, DPR: retract plane, reference plane, safety distance, depth; mm."""

    def __init__(self, i: Control, runner: Runner, item: Item) -> None:
        self.i, self.item = i, item
        unit = i.modes.unit
        given = [None if a is None else a(runner) for a in item.arguments or ()]
        self.given: list[float | None] = [*given, *[None] * (20 - len(given))]
        rtp, rfp, sdis, dp, dpr = self.given[:5]
        if rtp is None or rfp is None or (dp is None and dpr is None):
            raise BlockFault(
                item.first, f"{item.name} needs RTP, RFP and a depth, as in {item.name}(10, 0, 2, -15)"
            )
        self.retract, self.reference, self.safety = rtp * unit, rfp * unit, abs(sdis or 0.0) * unit
        self.depth = dp * unit if dp is not None else self.reference - abs(dpr or 0.0) * unit
        if self.depth >= self.reference or self.retract < self.reference:
            raise BlockFault(
                item.first,
                f"{item.name}: the depth must lie below RFP and RTP not below it; correct the planes",
            )

    def value(self, k: int, otherwise: float = 0.0) -> float:
        value = self.given[k]
        return otherwise if value is None else value

    def at(self, height: float) -> Point:
        point = list(self.i.r.p)
        point[PLANES[self.i.r.plane][2]] = height
        return point[0], point[1], point[2]

    def to(self, height: float, rapid: bool) -> None:
        self.i.r.line(self.at(height), rapid)

    def dwell(self, time: float) -> None:
        """Seconds; a negative time counts turns of the spindle."""
        if time < 0 and not self.i.r.speed:
            raise BlockFault(
                self.item.first,
                f"{self.item.name}: a negative dwell counts turns of the spindle, which has no speed",
            )
        if time:
            self.i.r.dwell(time if time > 0 else -time * 60.0 / self.i.r.speed)


def drill(i: Control, runner: Runner, item: Item) -> None:
    """CYCLE81, CYCLE82: rapid to the safety distance, feed to the depth, dwell (DTB), rapid out."""
    hole = Hole(i, runner, item)
    hole.to(hole.reference + hole.safety, rapid=True)
    hole.to(hole.depth, rapid=False)
    if item.name == "CYCLE82":
        hole.dwell(hole.value(5))
    hole.to(hole.retract, rapid=True)


def deep(i: Control, runner: Runner, item: Item) -> None:
    """CYCLE83 (RTP, RFP, SDIS, DP, DPR, FDEP, FDPR, DAM, DTB, DTS, FRF, VARI): strokes to FDEP, then shorter by DAM each.

    A stroke is never shorter than DAM; what is left below two strokes is halved. VARI 1: out to the safety distance after
    each stroke (dwell DTS there) and back in rapid to 0.6 mm before the depth reached (depth / 50 above 30 mm, 7 mm at
    most); VARI 0: back by 1 mm.
    """
    hole = Hole(i, runner, item)
    unit, r = i.modes.unit, i.r
    first = hole.value(5) * unit if hole.given[5] is not None else hole.reference - hole.value(6) * unit
    less, dwell, start, factor = (
        abs(hole.value(7)) * unit,
        hole.value(8),
        hole.value(9),
        hole.value(10, 1.0) or 1.0,
    )
    if not hole.depth <= first < hole.reference:
        raise BlockFault(
            item.first, "CYCLE83: the first depth FDEP must lie between RFP and the depth; correct it"
        )
    feed = r.feed
    hole.to(hole.reference + hole.safety, rapid=True)
    depths = strokes(hole.reference, first, hole.depth, less)
    total = hole.reference - hole.depth
    ahead = min(0.6 if total <= 30 else total / 50, 7.0)
    for n, depth in enumerate(depths):
        r.feed = feed * factor if n == 0 and feed is not None else feed
        hole.to(depth, rapid=False)
        hole.dwell(dwell)
        if n == len(depths) - 1:
            break
        if round(hole.value(11)) == 1:
            hole.to(hole.reference + hole.safety, rapid=True)
            hole.dwell(start)
            hole.to(depth + ahead, rapid=True)
        else:
            hole.to(depth + CHIP_BREAK, rapid=False)
    r.feed = feed
    hole.to(hole.retract, rapid=True)


def strokes(reference: float, first: float, final: float, less: float) -> list[float]:
    """Depths of the strokes of CYCLE83."""
    depths, step = [first], reference - first
    while depths[-1] - final > 1e-9:
        left = depths[-1] - final
        step = max(step - less, less) if less else step
        if left <= step + 1e-9:
            depths.append(final)
        elif left < 2 * step:
            depths += [depths[-1] - left / 2, final]
        else:
            depths.append(depths[-1] - step)
    return depths


def tolerance(i: Control, runner: Runner, item: Item) -> None:
    """CYCLE832(tolerance, mode): the contour tolerance, mm; mode 0 switches it off."""
    given = [None if a is None else a(runner) for a in item.arguments or ()]
    value = given[0] if given else None
    off = value is None or (len(given) > 1 and given[1] == 0)
    i.r.tolerance = None if off or value is None else value * i.modes.unit


def run(i: Control, runner: Runner, item: Item, line: int = 0) -> None:
    """A cycle, its moves marked with its name. line: where it is defined, 0 for the block under way."""
    tracer = i.r.tracer
    if tracer is not None:
        number = line or i.r.source.line
        tracer.cycle = cycle_words(item, tracer.lines[number - 1], number)
    i.r.marker = item.name
    CYCLES[item.name](i, runner, item)
    i.r.marker = ""


CYCLES: dict[str, Cycle] = {"CYCLE81": drill, "CYCLE82": drill, "CYCLE83": deep, "CYCLE832": tolerance}
