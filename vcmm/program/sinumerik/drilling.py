"""Drilling, boring and tapping cycles of Sinumerik as a table: CYCLE81 to CYCLE89, CYCLE840.

Source: Siemens, Programming Manual Cycles, "Drilling cycles".
"""

from __future__ import annotations

from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass

from vcmm.program.cycle_tables import Cycle, Values, cycle
from vcmm.program.drilling import COARSE, Hole, depths_of
from vcmm.program.faults import BlockFault
from vcmm.program.moves import PLANES
from vcmm.program.sinumerik.blocks import Item
from vcmm.program.sinumerik.flow import SinumerikRunner
from vcmm.program.sinumerik.state import SinumerikControl

CHIP_BREAK = 1.0  # mm of retraction with VARI=0
# mm before the depth reached: CYCLE83 with VARI=1; depth / 50 above 30 mm
AHEAD = 0.6
AHEAD_SHARE = 50
AHEAD_MOST = 7.0


@dataclass(frozen=True)
class DrillingCall:
    """A call of a drilling cycle, its heights in mm: retract plane RTP, reference plane RFP, safety distance, depth."""

    control: SinumerikControl
    item: Item
    retract: float
    reference: float
    safety: float
    depth: float

    def hole(self) -> Hole:
        """Return the hole at the position of the tool."""
        return Hole(self.control.r, self.reference + self.safety, self.depth, self.retract, idle=True)

    def seconds(self, time: float) -> float:
        """Return the seconds of a dwell; a negative time counts turns of the spindle."""
        if time >= 0:
            return time
        if not self.control.r.speed:
            raise BlockFault(
                self.item.first,
                f"{self.item.name}: a negative dwell counts turns of the spindle, which has no speed",
            )
        return -time * 60.0 / self.control.r.speed


DrillingPrimitive = Callable[[DrillingCall, Values], None]


def drill(
    i: SinumerikControl, runner: SinumerikRunner, item: Item, arguments: Sequence[float | None]
) -> None:
    """Run the cycle of a call. Raises BlockFault where a height is missing or on the wrong side."""
    row = DRILLING[item.name]
    v = i.values(row, arguments, item.name)
    if not (v.has("RTP") and v.has("RFP") and (v.has("DP") or v.has("DPR"))):
        raise BlockFault(
            item.first, f"{item.name} needs RTP, RFP and a depth, as in {item.name}(10, 0, 2, -15)"
        )
    depth = v["RFP"] - v["DPR"] if v["DPR"] else v["DP"]  # both: DPR holds
    if depth >= v["RFP"] or v["RTP"] < v["RFP"]:
        raise BlockFault(
            item.first,
            f"{item.name}: the depth must lie below RFP and RTP not below it; correct the planes",
        )
    plane = i.r.plane
    i.r.plane = plane_along(v.number("AXN"), plane, item)
    try:
        row.primitive(DrillingCall(i, item, v["RTP"], v["RFP"], v["SDIS"], depth), v)
    finally:
        i.r.plane = plane


def plane_along(axis: int, plane: str, item: Item) -> str:
    """Return the plane square to the axis that AXN names: 1 and 2 are those of the plane in force, 3 and 0 (left out) the one square to it."""
    if axis not in (0, 1, 2, 3):
        raise BlockFault(
            item.first, f"{item.name}: AXN is 1, 2 or 3, an axis of the plane, and not {axis}; correct it"
        )
    wanted = PLANES[plane][(axis or 3) - 1]
    return next(name for name, axes in PLANES.items() if axes[2] == wanted)


def tap(d: DrillingCall, v: Values) -> None:
    """Run CYCLE84, CYCLE840: in and out at pitch times speed (SST in, SST1 out); DAM breaks chips. MPIT is the size of a metric thread with
    coarse pitch. ENC 1 of CYCLE840 (without encoder) without a pitch: at the feed in force."""
    r = d.control.r
    lead = v["PIT"] or COARSE.get(round(abs(v["MPIT"])), 0.0)
    speed = v["SST"] or r.speed
    back = v["SST1"] or speed
    if not lead and r.feed_mode == "G95" and r.feed:
        lead = r.feed
    if not lead and v.number("ENC") == 1 and r.feed:
        ream(d, v)
        return
    if not lead:
        raise BlockFault(
            d.item.first,
            f"{d.item.name} needs the pitch PIT, or the size MPIT of a coarse metric thread (3 to 48)",
        )
    hole, before, mode = d.hole(), r.feed, r.feed_mode
    hole.to(hole.clearance, rapid=True)
    r.feed_mode = "G94"
    for depth in depths_of(d.reference, d.depth, v["DAM"] or d.reference - d.depth):
        r.feed = lead * speed
        hole.to(depth, rapid=False)
        if depth > d.depth:
            r.feed = lead * back
            hole.to(depth + CHIP_BREAK, rapid=False)
    hole.wait(d.seconds(v["DTB"]))
    r.feed = lead * back
    hole.to(hole.clearance, rapid=False)
    r.feed, r.feed_mode = before, mode
    hole.leave()


def ream(d: DrillingCall, v: Values) -> None:
    """Run CYCLE85: in at FFR, out at RFF. CYCLE89, and CYCLE840 without encoder (G63): in and out at the feed in force."""
    r, hole = d.control.r, d.hole()
    before = r.feed
    hole.to(hole.clearance, rapid=True)
    r.feed = v["FFR"] or before
    hole.to(hole.bottom, rapid=False)
    hole.wait(d.seconds(v["DTB"]))
    r.feed = v["RFF"] or r.feed
    hole.to(hole.clearance, rapid=False)
    r.feed = before
    hole.leave()


def in_and_out(d: DrillingCall, v: Values) -> None:
    """Run CYCLE81, CYCLE82: rapid to the safety distance, feed to the depth, dwell (DTB), rapid out. CYCLE87, CYCLE88: the same with the spindle at
    rest. CYCLE86: off the wall by RPA, RPO and RPAP before it goes out, and back over the hole."""
    r, hole = d.control.r, d.hole()
    first, second, _ = PLANES[r.plane]
    middle = r.p[first], r.p[second]
    hole.to(hole.clearance, rapid=True)
    hole.to(hole.bottom, rapid=False)
    hole.wait(d.seconds(v["DTB"]))
    if v["RPA"] or v["RPO"] or v["RPAP"]:
        hole.across(middle[0] + v["RPA"], middle[1] + v["RPO"])
        hole.to(hole.bottom + v["RPAP"], rapid=True)
        hole.to(hole.clearance, rapid=True)
        hole.across(*middle)
    hole.leave()


def deep(d: DrillingCall, v: Values) -> None:
    """Run CYCLE83: strokes to FDEP (or FDPR below RFP), then shorter by DAM each.

     A stroke is never shorter than DAM; a rest below two strokes is halved. DAM below zero is a factor: each stroke is that share
    of the one before, MDEP at least. VARI 1: out to the safety distance after each stroke (dwell DTS there) and back in rapid to DIS1
    before the depth reached (left out: 0.6 mm; depth / 50 above 30 mm, 7 mm at most); VARI 0: back by VRT (left out: 1 mm). DTD: dwell at
    the last depth, DTB where it is left out or zero.
    """
    r = d.control.r
    first = v["FDEP"] if v.has("FDEP") else d.reference - v["FDPR"]
    if not d.depth <= first < d.reference:
        raise BlockFault(
            d.item.first, "CYCLE83: the first depth FDEP must lie between RFP and the depth; correct it"
        )
    feed, factor = r.feed, v.without("FRF", 1.0) or 1.0
    total, out = d.reference - d.depth, v.number("VARI") == 1
    automatic = min(AHEAD if total <= 30 else total / AHEAD_SHARE, AHEAD_MOST)
    ahead = (v["DIS1"] or automatic) if out else (v["VRT"] or CHIP_BREAK)
    hole, less = d.hole(), v["DAM"] * (r.unit if v["DAM"] > 0 else 1.0)

    def slower(k: int) -> None:
        r.feed = feed * factor if k == 0 and feed is not None else feed

    hole.to(hole.clearance, rapid=True)
    hole.pecks(
        strokes(d.reference, first, d.depth, less, v["MDEP"]), lambda depth: depth + ahead, out=out, wait=d.seconds(v["DTB"]),
        pause=d.seconds(v["DTS"]) if out else 0.0, back_at_feed=not out, before=slower,
        last=d.seconds(v["DTD"] or v["DTB"]),
    )  # fmt: skip
    r.feed = feed
    hole.leave()


def strokes(reference: float, first: float, final: float, less: float, least: float = 0.0) -> list[float]:
    """Return the depths of the strokes of CYCLE83, each shorter by `less` mm; below zero: by that factor, `least` mm at least."""
    if less < 0:
        return by_a_factor(reference, first, final, -less, least)
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


def by_a_factor(reference: float, first: float, final: float, factor: float, least: float) -> list[float]:
    """Return depths of strokes of which each is a share of the one before, `least` mm at least. Raises BlockFault where they would not get there."""
    depths, step = [first], reference - first
    if factor > 1 or (factor < 1 and not least):
        raise BlockFault(
            0, "CYCLE83: DAM below zero is a factor up to -1, and MDEP the least stroke; add MDEP"
        )
    while depths[-1] - final > 1e-9:
        step = max(step * factor, min(least, step))
        depths.append(max(depths[-1] - step, final))
    return depths


_HEIGHTS = "RTP mm?, RFP mm?, SDIS size, DP mm?, DPR size?"
_TURN = "DTB plain, SDIR count"
DRILLING: Mapping[str, Cycle[DrillingPrimitive]] = {
    "CYCLE81": cycle(f"{_HEIGHTS}, DTB plain", in_and_out),
    "CYCLE82": cycle(f"{_HEIGHTS}, DTB plain", in_and_out),
    "CYCLE83": cycle(f"{_HEIGHTS}, FDEP mm?, FDPR mm, DAM plain, DTB plain, DTS plain, FRF plain?, VARI count, AXN count, MDEP size, VRT size, DTD plain, DIS1 size", deep),
    "CYCLE84": cycle(f"{_HEIGHTS}, DTB plain, SDAC count, MPIT plain, PIT size, POSS plain, SST plain, SST1 plain, AXN count, PTAB count, TECHNO count, VARI count, DAM size", tap),
    "CYCLE840": cycle(f"{_HEIGHTS}, DTB plain, SDR count, SDAC count, ENC count, MPIT plain, PIT size, AXN count, PTAB count, TECHNO count", tap),
    "CYCLE85": cycle(f"{_HEIGHTS}, DTB plain, FFR feed, RFF feed", ream),
    "CYCLE86": cycle(f"{_HEIGHTS}, {_TURN}, RPA mm, RPO mm, RPAP mm, POSS plain", in_and_out),
    "CYCLE87": cycle(f"{_HEIGHTS}, SDIR count", in_and_out),
    "CYCLE88": cycle(f"{_HEIGHTS}, {_TURN}", in_and_out),
    "CYCLE89": cycle(f"{_HEIGHTS}, DTB plain", ream),
}  # fmt: skip
