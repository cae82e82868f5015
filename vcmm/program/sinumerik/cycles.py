"""Cycles of Sinumerik: CYCLE81 to CYCLE89, CYCLE840, CYCLE800, CYCLE832. Source: Siemens, Programming Manual Cycles."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

from vcmm.program.drilling import COARSE, Hole, depths_of
from vcmm.program.expressions import evaluate
from vcmm.program.faults import BlockFault
from vcmm.program.moves import PLANES
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
CHIP_BREAK = 1.0  # mm of retraction with VARI=0
Cycle = Callable[[SinumerikControl, SinumerikRunner, Item], None]


@dataclass(frozen=True)
class DrillingData:
    """Arguments of a drilling cycle, mm: RTP retract plane, RFP reference plane, SDIS safety distance, depth; given: all as given."""

    name: str
    given: tuple[float | None, ...]
    retract: float
    reference: float
    safety: float
    depth: float

    def value(self, k: int, otherwise: float = 0.0) -> float:
        """Argument k, or what holds without it."""
        value = self.given[k]
        return otherwise if value is None else value

    def hole(self, i: SinumerikControl) -> Hole:
        """The hole where the tool stands."""
        return Hole(i.r, self.reference + self.safety, self.depth, self.retract, idle=True)


def arguments_of(runner: SinumerikRunner, item: Item) -> list[float | None]:
    """The arguments of a cycle now."""
    values = [None if a is None else evaluate(a, runner) for a in item.arguments or ()]
    return [None if isinstance(v, str) else v for v in values]


def drilling_data(i: SinumerikControl, runner: SinumerikRunner, item: Item) -> DrillingData:
    """RTP, RFP, SDIS, DP, DPR and what follows. Raises BlockFault where a height is missing or on the wrong side."""
    given = arguments_of(runner, item)
    given += [None] * (20 - len(given))
    rtp, rfp, sdis, dp, dpr = given[:5]
    if rtp is None or rfp is None or (dp is None and dpr is None):
        raise BlockFault(
            item.first, f"{item.name} needs RTP, RFP and a depth, as in {item.name}(10, 0, 2, -15)"
        )
    unit = i.r.unit
    retract, reference, safety = rtp * unit, rfp * unit, abs(sdis or 0.0) * unit
    depth = reference - abs(dpr) * unit if dpr else (dp or 0.0) * unit  # both: DPR holds
    if depth >= reference or retract < reference:
        raise BlockFault(
            item.first,
            f"{item.name}: the depth must lie below RFP and RTP not below it; correct the planes",
        )
    return DrillingData(item.name, tuple(given), retract, reference, safety, depth)


def seconds(i: SinumerikControl, item: Item, time: float) -> float:
    """Seconds of a dwell; a negative time counts turns of the spindle."""
    if time >= 0:
        return time
    if not i.r.speed:
        raise BlockFault(
            item.first, f"{item.name}: a negative dwell counts turns of the spindle, which has no speed"
        )
    return -time * 60.0 / i.r.speed


def drill(i: SinumerikControl, runner: SinumerikRunner, item: Item) -> None:
    """CYCLE81, CYCLE82: rapid to the safety distance, feed to the depth, dwell (DTB), rapid out."""
    data = drilling_data(i, runner, item)
    hole = data.hole(i)
    hole.to(hole.clearance, rapid=True)
    hole.to(hole.bottom, rapid=False)
    hole.wait(seconds(i, item, data.value(5)))
    hole.leave()


def tap(i: SinumerikControl, runner: SinumerikRunner, item: Item) -> None:
    """CYCLE84 (... DTB, SDAC, MPIT, PIT, POSS, SST, SST1 ... DAM at 16) and CYCLE840 (... DTB, SDR, SDAC, ENC, MPIT, PIT): in and out at
    pitch times speed; CYCLE84 with DAM breaks chips by DAM. MPIT is the size of a metric thread with coarse pitch."""
    data, r = drilling_data(i, runner, item), i.r
    rigid = item.name == "CYCLE84"
    size, pitch = (data.value(7), data.value(8)) if rigid else (data.value(9), data.value(10))
    lead = (abs(pitch) * r.unit) or COARSE.get(round(abs(size)), 0.0)
    speed = (data.value(10) if rigid else 0.0) or r.speed
    back = (data.value(11) if rigid else 0.0) or speed
    if not lead and r.feed_mode == "G95" and r.feed:
        lead = r.feed
    if not lead:
        raise BlockFault(
            item.first,
            f"{item.name} needs the pitch PIT, or the size MPIT of a coarse metric thread (3 to 48)",
        )
    hole, kept, mode = data.hole(i), r.feed, r.feed_mode
    hole.to(hole.clearance, rapid=True)
    r.feed_mode = "G94"
    step = abs(data.value(16)) * r.unit if rigid else 0.0
    for depth in depths_of(data.reference, data.depth, step or data.reference - data.depth):
        r.feed = lead * speed
        hole.to(depth, rapid=False)
        if depth > data.depth:
            r.feed = lead * back
            hole.to(depth + CHIP_BREAK, rapid=False)
    hole.wait(seconds(i, item, data.value(5)))
    r.feed = lead * back
    hole.to(hole.clearance, rapid=False)
    r.feed, r.feed_mode = kept, mode
    hole.leave()


def ream(i: SinumerikControl, runner: SinumerikRunner, item: Item) -> None:
    """CYCLE85 (... DTB, FFR, RFF): in at FFR, out at RFF. CYCLE89: in and out at the feed in force."""
    data, r = drilling_data(i, runner, item), i.r
    hole, kept = data.hole(i), r.feed
    own = item.name == "CYCLE85"
    hole.to(hole.clearance, rapid=True)
    r.feed = data.value(6) * i.modes.feed_unit if own and data.value(6) else kept
    hole.to(hole.bottom, rapid=False)
    hole.wait(seconds(i, item, data.value(5)))
    r.feed = data.value(7) * i.modes.feed_unit if own and data.value(7) else r.feed
    hole.to(hole.clearance, rapid=False)
    r.feed = kept
    hole.leave()


def bore(i: SinumerikControl, runner: SinumerikRunner, item: Item) -> None:
    """CYCLE86 (... DTB, SDIR, RPA, RPO, RPAP): off the wall by RPA, RPO and RPAP with the spindle at rest, out, back over the hole.
    CYCLE87, CYCLE88: out at rapid with the spindle at rest; CYCLE88 dwells."""
    data, r = drilling_data(i, runner, item), i.r
    hole = data.hole(i)
    one, two, _ = PLANES[r.plane]
    middle = r.p[one], r.p[two]
    hole.to(hole.clearance, rapid=True)
    hole.to(hole.bottom, rapid=False)
    if item.name != "CYCLE87":
        hole.wait(seconds(i, item, data.value(5)))
    if item.name == "CYCLE86" and any(data.value(k) for k in (7, 8, 9)):
        hole.across(middle[0] + data.value(7) * r.unit, middle[1] + data.value(8) * r.unit)
        hole.to(hole.bottom + data.value(9) * r.unit, rapid=True)
        hole.to(hole.clearance, rapid=True)
        hole.across(*middle)
    hole.leave()


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
    from vcmm.program.sinumerik.turning import contour, thread

    (contour if item.name == "CYCLE95" else thread)(i, runner, item)  # type: ignore[arg-type]


def measure(i: SinumerikControl, runner: SinumerikRunner, item: Item) -> None:
    """CYCLE976 to CYCLE979, CYCLE998."""
    from vcmm.program.sinumerik.measuring import measure

    measure(i, runner, item, arguments_of(runner, item))


def deep(i: SinumerikControl, runner: SinumerikRunner, item: Item) -> None:
    """CYCLE83 (RTP, RFP, SDIS, DP, DPR, FDEP, FDPR, DAM, DTB, DTS, FRF, VARI): strokes to FDEP, then shorter by DAM each.

    A stroke is never shorter than DAM; what is left below two strokes is halved. VARI 1: out to the safety distance after
    each stroke (dwell DTS there) and back in rapid to 0.6 mm before the depth reached (depth / 50 above 30 mm, 7 mm at
    most); VARI 0: back by 1 mm.
    """
    data, unit, r = drilling_data(i, runner, item), i.r.unit, i.r
    first = data.value(5) * unit if data.given[5] is not None else data.reference - data.value(6) * unit
    if not data.depth <= first < data.reference:
        raise BlockFault(
            item.first, "CYCLE83: the first depth FDEP must lie between RFP and the depth; correct it"
        )
    feed, factor = r.feed, data.value(10, 1.0) or 1.0
    total, out = data.reference - data.depth, round(data.value(11)) == 1
    ahead = min(0.6 if total <= 30 else total / 50, 7.0) if out else CHIP_BREAK
    hole = data.hole(i)

    def slower(k: int) -> None:
        r.feed = feed * factor if k == 0 and feed is not None else feed

    hole.to(hole.clearance, rapid=True)
    hole.pecks(
        strokes(data.reference, first, data.depth, abs(data.value(7)) * unit), lambda depth: depth + ahead, out=out,
        wait=seconds(i, item, data.value(8)), pause=seconds(i, item, data.value(9)) if out else 0.0, back_at_feed=not out,
        before=slower,
    )  # fmt: skip
    r.feed = feed
    hole.leave()


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
    "CYCLE81": drill, "CYCLE82": drill, "CYCLE83": deep, "CYCLE84": tap, "CYCLE840": tap, "CYCLE85": ream, "CYCLE86": bore, "CYCLE87": bore,
    "CYCLE88": bore, "CYCLE89": ream, "CYCLE832": tolerance, "CYCLE800": swivel, "HOLES1": pattern, "HOLES2": pattern, "CYCLE801": pattern,
    "CYCLE802": pattern, "POCKET1": mill, "POCKET2": mill, "POCKET3": mill, "POCKET4": mill, "CYCLE71": mill,
    "CYCLE61": mill, "CYCLE72": mill, "CYCLE90": mill, "SLOT1": mill, "LONGHOLE": mill,
    "CYCLE95": turn_contour, "CYCLE97": turn_contour, "CYCLE976": measure, "CYCLE977": measure, "CYCLE978": measure, "CYCLE979": measure,
    "CYCLE998": measure,
}  # fmt: skip
