"""Drilling, boring and tapping cycles of Klartext: 200 to 203, 205 to 209, 240, 241, and 1, 2, 17, 18.

Source: HEIDENHAIN, TNC 640 User's Manual Cycle Programming, "Drilling, boring and thread cycles"; TNC 426/430 User's Manual for
1, 2, 17 and 18, which count from where the tool stands: the set-up clearance above the surface.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from vcmm.program.drilling import Hole, depths_of
from vcmm.program.heidenhain.machining import Action, MachiningCycle
from vcmm.program.moves import PLANES

BACK_OFF = 0.2  # mm, fixed in cycle 202
ENTRY, ENTRY_SHARE, ENTRY_MOST = 0.6, 50.0, 7.0  # mm: advanced stop of cycle 1; depth / 50 above 30 mm


def drill(c: MachiningCycle) -> None:
    """200: by Q202 to the depth, out to the set-up clearance between, dwell Q210 there, rapid to Q200 above the depth reached."""
    clear = c.mm("Q200")
    hole = c.hole()
    depths = depths_of(c.surface, hole.bottom, c.mm("Q202"))
    with c.feed_at(c.feed("Q206")):
        hole.to(hole.clearance, True)
        hole.pecks(depths, lambda depth: min(depth + clear, hole.clearance), pause=c.plain("Q210"))
        hole.wait(c.plain("Q211"))
        hole.leave()


def ream(c: MachiningCycle) -> None:
    """201: to the depth, dwell, out at Q208 to the set-up clearance, rapid to the second one."""
    hole = c.hole()
    hole.to(hole.clearance, True)
    with c.feed_at(c.feed("Q206")):
        hole.feed_in(c.plain("Q211"))
    _out(c, hole)


def _out(c: MachiningCycle, hole: Hole) -> None:
    """Out at Q208 (Q206 where it is zero) to the set-up clearance, and at rapid to the second one where it is higher."""
    with c.feed_at(c.feed("Q208", "Q206")) as rapid:
        hole.to(hole.clearance, rapid)
    if hole.retract > hole.clearance:
        hole.leave()


def bore(c: MachiningCycle) -> None:
    """202: as 201; at the bottom off the wall by 0.2 mm where Q214 says so (1 -X, 2 -Y, 3 +X, 4 +Y), back over the hole at the end."""
    hole = c.hole()
    hole.to(hole.clearance, True)
    with c.feed_at(c.feed("Q206")):
        hole.feed_in(c.plain("Q211"))
    side, (a, b) = round(c.plain("Q214")), c.here()
    if side in (1, 2, 3, 4):
        off = -BACK_OFF if side < 3 else BACK_OFF
        hole.across(a + off if side in (1, 3) else a, b + off if side in (2, 4) else b)
    _out(c, hole)
    if side in (1, 2, 3, 4):
        hole.across(a, b)


def universal(c: MachiningCycle) -> None:
    """203: infeeds Q202, each Q212 shorter but not below Q205; after Q213 chip breaks (back by Q256) out at Q208, dwell Q210."""
    hole, breaks, broken = c.hole(), round(c.plain("Q213")), 0
    depths = depths_of(c.surface, hole.bottom, c.mm("Q202"), c.mm("Q212"), c.mm("Q205"))
    hole.to(hole.clearance, True)
    for depth in depths:
        with c.feed_at(c.feed("Q206")):
            hole.to(depth, False)
        if depth == depths[-1]:
            break
        if broken < breaks:
            broken += 1
            with c.feed_at(c.feed("Q208", "Q206")) as rapid:
                hole.to(depth + c.mm("Q256"), rapid)
            continue
        broken = 0
        with c.feed_at(c.feed("Q208", "Q206")) as rapid:
            hole.to(hole.clearance, rapid)
        hole.wait(c.plain("Q210"))
        hole.to(min(depth + c.mm("Q200"), hole.clearance), True)
    hole.wait(c.plain("Q211"))
    _out(c, hole)


def peck(c: MachiningCycle) -> None:
    """205: infeeds as 203; rapid out and back to the advanced stop Q258 (Q259 at the last) above the depth reached; chips broken
    by Q256 each Q257; Q379 mm are drilled already, passed at Q253."""
    hole = c.hole()
    start = c.surface - abs(c.mm("Q379"))
    depths = depths_of(start, hole.bottom, c.mm("Q202"), c.mm("Q212"), c.mm("Q205"))
    upper, lower = c.mm("Q258"), c.mm("Q259") or c.mm("Q258")
    hole.to(hole.clearance, True)
    if start < c.surface:
        with c.feed_at(c.feed("Q253")) as rapid:
            hole.to(start + c.mm("Q200"), rapid)
    before = start
    for k, depth in enumerate(depths):
        _in_pieces(c, hole, before, depth)
        before = depth
        if k < len(depths) - 1:
            hole.to(hole.clearance, True)
            ahead = upper + (lower - upper) * k / max(len(depths) - 2, 1)
            hole.to(min(depth + ahead, hole.clearance), True)
    hole.wait(c.plain("Q211"))
    with c.feed_at(c.feed("Q208") or math.inf) as rapid:
        hole.to(hole.clearance, rapid)
    if hole.retract > hole.clearance:
        hole.leave()


def _in_pieces(c: MachiningCycle, hole: Hole, top: float, depth: float) -> None:
    """One infeed at Q206, chips broken each Q257."""
    piece = abs(c.mm("Q257"))
    with c.feed_at(c.feed("Q206")):
        for stop in depths_of(top, depth, piece or top - depth):
            hole.to(stop, False)
            if stop > depth:
                hole.to(stop + c.mm("Q256"), True)


def tap(c: MachiningCycle) -> None:
    """206: to the depth at Q206, dwell, out at the same feed while the spindle turns back."""
    hole = c.hole()
    hole.to(hole.clearance, True)
    with c.feed_at(c.feed("Q206")):
        hole.feed_in(c.plain("Q211"))
        hole.to(hole.clearance, False)
    if hole.retract > hole.clearance:
        hole.leave()


def rigid(c: MachiningCycle) -> None:
    """207, 209: at pitch Q239 times the spindle speed, in and out; 209 breaks chips each Q257 by Q256."""
    hole, r = c.hole(), c.recorder
    step = abs(c.mm("Q257")) if c.number == "209" else 0.0
    hole.to(hole.clearance, True)
    with c.feed_at(abs(c.mm("Q239")) * r.speed):
        for stop in depths_of(c.surface, hole.bottom, step or c.surface - hole.bottom):
            hole.to(stop, False)
            if stop > hole.bottom:
                hole.to(stop + c.mm("Q256") if c.mm("Q256") else hole.clearance, False)
        hole.to(hole.clearance, False)
    if hole.retract > hole.clearance:
        hole.leave()


def centre(c: MachiningCycle) -> None:
    """240: to the depth Q201, or (Q343 = 1) to where a point of 90 deg makes the diameter Q344; dwell; rapid out."""
    hole = c.hole()
    if round(c.plain("Q343")) == 1:
        c.recorder.assume(
            f"the point angle of tool {c.recorder.tool}", "90 deg",
            f"cycle 240 with Q343=1 needs the point angle of tool {c.recorder.tool}; give the depth Q201 with Q343=0",
        )  # fmt: skip
        hole = Hole(
            hole.recorder, hole.clearance, c.surface - abs(c.mm("Q344")) / 2.0, hole.retract, idle=True
        )
    hole.to(hole.clearance, True)
    with c.feed_at(c.feed("Q206")):
        hole.feed_in(c.plain("Q211"))
    hole.leave()


def single_lip(c: MachiningCycle) -> None:
    """241: at Q253 to Q200 above the drilled depth Q379, to the depth at Q206, dwell, out at Q208."""
    hole = c.hole()
    hole.to(hole.clearance, True)
    with c.feed_at(c.feed("Q253")) as rapid:
        hole.to(c.surface - abs(c.mm("Q379")) + c.mm("Q200"), rapid)
    with c.feed_at(c.feed("Q206")):
        hole.feed_in(c.plain("Q211"))
    _out(c, hole)


def bore_mill(c: MachiningCycle) -> None:
    """208: a helix of Q334 a turn on the diameter Q335 to the depth, a full circle there, back to the middle, rapid out."""
    hole, (a, b), r = c.hole(), c.here(), c.recorder
    radius = c.mm("Q335") / 2.0 - c.radius()
    hole.to(hole.clearance, True)
    step = abs(c.mm("Q334")) or c.surface - hole.bottom
    clockwise = round(c.plain("Q351", 1.0)) == -1
    normal = PLANES[r.plane][2]
    with c.feed_at(c.feed("Q206")):
        if radius > 1e-6:
            c.to(a + radius, None, None, False)
            for depth in depths_of(r.p[normal], hole.bottom, step):
                r.arc(c.at(a + radius, b, depth), c.at(a, b, depth), clockwise)
            r.arc(c.at(a + radius, b, hole.bottom), c.at(a, b, hole.bottom), clockwise)
            c.to(a, b, None, False)
        else:
            hole.feed_in()
    hole.leave()


# -- cycles that count from where the tool stands -----------------------------------------------------------------------
def _old(c: MachiningCycle) -> tuple[Hole, float]:
    """The hole of an old cycle and the height of its surface. The sign of DEPTH says which way; the others have none of their own."""
    start = c.recorder.p[PLANES[c.recorder.plane][2]]
    way = -1.0 if c.plain("DEPTH") <= 0 else 1.0
    surface = start + way * abs(c.mm("DIST"))
    return Hole(c.recorder, start, surface + c.mm("DEPTH"), start, idle=True), surface


def old_peck(c: MachiningCycle) -> None:
    """1: by PECKG to DEPTH; rapid to the start and back to the advanced stop before the depth reached (0.6 mm; depth / 50 above
    30 mm, 7 mm at most); dwell at the bottom, rapid out."""
    hole, surface = _old(c)
    total = abs(c.mm("DEPTH"))
    ahead = ENTRY if total <= 30.0 else min(total / ENTRY_SHARE, ENTRY_MOST)
    way = 1.0 if hole.bottom <= surface else -1.0
    step = abs(c.mm("PECKG")) or total
    depths = [surface + way * (d - surface) for d in depths_of(surface, surface - total, step)]
    with c.feed_at(c.feed("F")):
        hole.pecks(depths, lambda depth: depth + way * ahead)
        hole.wait(c.plain("DWELL"))
        hole.leave()


def old_tap(c: MachiningCycle) -> None:
    """2, 17: to DEPTH in one motion, dwell, back at the same feed; 17 at PITCH times the spindle speed."""
    hole, _ = _old(c)
    feed = abs(c.mm("PITCH")) * c.recorder.speed if c.number == "17" else c.feed("F")
    with c.feed_at(feed):
        hole.feed_in(c.plain("DWELL"))
        hole.to(hole.retract, False)


def old_thread(c: MachiningCycle) -> None:
    """18: from where the tool stands to DEPTH at PITCH times the spindle speed; the tool stays there."""
    r = c.recorder
    start = r.p[PLANES[r.plane][2]]
    with c.feed_at(abs(c.mm("PITCH")) * r.speed):
        Hole(r, start, start + c.mm("DEPTH"), start).feed_in()


HOLES: Mapping[str, tuple[tuple[str, ...], Action]] = {  # what they need, and what they do
    "200": (("Q200", "Q201", "Q206", "Q202", "Q203"), drill), "201": (("Q200", "Q201", "Q206", "Q203"), ream),
    "202": (("Q200", "Q201", "Q206", "Q203"), bore), "203": (("Q200", "Q201", "Q206", "Q202", "Q203"), universal),
    "205": (("Q200", "Q201", "Q206", "Q202", "Q203"), peck), "206": (("Q200", "Q201", "Q206", "Q203"), tap),
    "207": (("Q200", "Q201", "Q239", "Q203"), rigid), "208": (("Q200", "Q201", "Q206", "Q334", "Q203", "Q335"), bore_mill),
    "209": (("Q200", "Q201", "Q239", "Q203"), rigid), "240": (("Q200", "Q206", "Q203"), centre),
    "241": (("Q200", "Q201", "Q206", "Q203"), single_lip),
}  # fmt: skip
OLD_HOLES: Mapping[str, Action] = {"1": old_peck, "2": old_tap, "17": old_tap, "18": old_thread}
