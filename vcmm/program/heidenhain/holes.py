"""Drilling, boring and tapping cycles of Klartext: 200 to 203, 205 to 209, 240, 241, and 1, 2, 17, 18.

Source: HEIDENHAIN, TNC 640 User's Manual Cycle Programming, "Drilling, boring and thread cycles"; TNC 426/430 User's Manual for
1, 2, 17 and 18, which count from where the tool stands: the set-up clearance above the surface.
"""

from __future__ import annotations

import math
from collections.abc import Mapping

from vcmm.program.cycle_tables import Cycle, Values, cycle
from vcmm.program.drilling import Hole, depths_of
from vcmm.program.heidenhain.machining import BlockwiseCycle, KlartextPrimitive, MachiningCycle, blockwise
from vcmm.program.moves import PLANES

BACK_OFF = 0.2  # mm, fixed in cycle 202
ENTRY, ENTRY_SHARE, ENTRY_MOST = 0.6, 50.0, 7.0  # mm: advanced stop of cycle 1; depth / 50 above 30 mm


def drill(c: MachiningCycle, v: Values) -> None:
    """Run cycle 200: by Q202 to the depth, out to the set-up clearance between, dwell Q210 there, rapid to Q200 above the depth reached."""
    hole = c.hole()
    depths = depths_of(c.surface, hole.bottom, v["step"])
    with c.feed_at(v["feed"]):
        hole.to(hole.clearance, True)
        hole.pecks(depths, lambda depth: min(depth + v["clear"], hole.clearance), pause=v["pause"])
        hole.wait(v["dwell"])
        hole.leave()


def ream(c: MachiningCycle, v: Values) -> None:
    """Run cycle 201: to the depth, dwell, out at Q208 to the set-up clearance, rapid to the second one."""
    hole = c.hole()
    hole.to(hole.clearance, True)
    with c.feed_at(v["feed"]):
        hole.feed_in(v["dwell"])
    _out(c, v, hole)


def _out(c: MachiningCycle, v: Values, hole: Hole) -> None:
    """Move out at Q208 (Q206 where it is zero) to the set-up clearance, and at rapid to the second one where it is higher."""
    with c.feed_at(v["back"], v["feed"]) as rapid:
        hole.to(hole.clearance, rapid)
    hole.leave_higher()


def bore(c: MachiningCycle, v: Values) -> None:
    """Run cycle 202: as 201; at the bottom off the wall by 0.2 mm where Q214 says so (1 -X, 2 -Y, 3 +X, 4 +Y), back over the hole at the end."""
    hole = c.hole()
    hole.to(hole.clearance, True)
    with c.feed_at(v["feed"]):
        hole.feed_in(v["dwell"])
    side, (a, b) = v.number("side"), c.here()
    if side in (1, 2, 3, 4):
        off = -BACK_OFF if side < 3 else BACK_OFF
        hole.across(a + off if side in (1, 3) else a, b + off if side in (2, 4) else b)
    _out(c, v, hole)
    if side in (1, 2, 3, 4):
        hole.across(a, b)


def universal(c: MachiningCycle, v: Values) -> None:
    """Run cycle 203: infeeds Q202, each Q212 shorter but not below Q205; after Q213 chip breaks (back by Q256) out at Q208, dwell Q210."""
    hole, breaks, broken = c.hole(), v.number("breaks"), 0
    depths = depths_of(c.surface, hole.bottom, v["step"], v["less"], v["least"])
    hole.to(hole.clearance, True)
    for depth in depths:
        with c.feed_at(v["feed"]):
            hole.to(depth, False)
        if depth == depths[-1]:
            break
        if broken < breaks:
            broken += 1
            with c.feed_at(v["back"], v["feed"]) as rapid:
                hole.to(depth + v["lift"], rapid)
            continue
        broken = 0
        with c.feed_at(v["back"], v["feed"]) as rapid:
            hole.to(hole.clearance, rapid)
        hole.wait(v["pause"])
        hole.to(min(depth + v["clear"], hole.clearance), True)
    hole.wait(v["dwell"])
    _out(c, v, hole)


def peck(c: MachiningCycle, v: Values) -> None:
    """Run cycle 205: infeeds as 203; rapid out and back to the advanced stop Q258 (Q259 at the last) above the depth reached; chips broken
    by Q256 each Q257; Q379 mm are drilled already, passed at Q253."""
    hole = c.hole()
    start = c.surface - v["start"]
    depths = depths_of(start, hole.bottom, v["step"], v["less"], v["least"])
    upper, lower = v["ahead"], v["ahead_last"] or v["ahead"]
    hole.to(hole.clearance, True)
    if start < c.surface:
        with c.feed_at(v["approach"]) as rapid:
            hole.to(start + v["clear"], rapid)
    before = start
    for k, depth in enumerate(depths):
        _in_pieces(c, v, hole, before, depth)
        before = depth
        if k < len(depths) - 1:
            hole.to(hole.clearance, True)
            ahead = upper + (lower - upper) * k / max(len(depths) - 2, 1)
            hole.to(min(depth + ahead, hole.clearance), True)
    hole.wait(v["dwell"])
    with c.feed_at(v["back"], math.inf) as rapid:
        hole.to(hole.clearance, rapid)
    hole.leave_higher()


def _in_pieces(c: MachiningCycle, v: Values, hole: Hole, top: float, depth: float) -> None:
    """Make one infeed at Q206, chips broken each Q257."""
    with c.feed_at(v["feed"]):
        for stop in depths_of(top, depth, v["piece"] or top - depth):
            hole.to(stop, False)
            if stop > depth:
                hole.to(stop + v["lift"], True)


def tap(c: MachiningCycle, v: Values) -> None:
    """Run cycle 206: to the depth at Q206, dwell, out at the same feed while the spindle turns back."""
    hole = c.hole()
    hole.to(hole.clearance, True)
    with c.feed_at(v["feed"]):
        hole.feed_in(v["dwell"])
        hole.to(hole.clearance, False)
    hole.leave_higher()


def rigid(c: MachiningCycle, v: Values) -> None:
    """Run cycles 207, 209: at pitch Q239 times the spindle speed, in and out; 209 breaks chips each Q257 by Q256."""
    hole, r = c.hole(), c.recorder
    hole.to(hole.clearance, True)
    with c.feed_at(v["pitch"] * r.speed):
        for stop in depths_of(c.surface, hole.bottom, v["piece"] or c.surface - hole.bottom):
            hole.to(stop, False)
            if stop > hole.bottom:
                hole.to(stop + v["lift"] if v["lift"] else hole.clearance, False)
        hole.to(hole.clearance, False)
    hole.leave_higher()


def centre(c: MachiningCycle, v: Values) -> None:
    """Run cycle 240: to the depth Q201, or (Q343 = 1) to where a point of 90 deg makes the diameter Q344; dwell; rapid out."""
    hole = c.hole()
    if v.number("by_diameter") == 1:
        c.recorder.assume(
            f"the point angle of tool {c.recorder.tool}", "90 deg",
            f"cycle 240 with Q343=1 needs the point angle of tool {c.recorder.tool}; give the depth Q201 with Q343=0",
        )  # fmt: skip
        hole = Hole(hole.recorder, hole.clearance, c.surface - v["diameter"] / 2.0, hole.retract, idle=True)
    hole.to(hole.clearance, True)
    with c.feed_at(v["feed"]):
        hole.feed_in(v["dwell"])
    hole.leave()


def single_lip(c: MachiningCycle, v: Values) -> None:
    """Run cycle 241: at Q253 to Q200 above the drilled depth Q379, to the depth at Q206, dwell, out at Q208."""
    hole = c.hole()
    hole.to(hole.clearance, True)
    with c.feed_at(v["approach"]) as rapid:
        hole.to(c.surface - v["start"] + v["clear"], rapid)
    with c.feed_at(v["feed"]):
        hole.feed_in(v["dwell"])
    _out(c, v, hole)


def bore_mill(c: MachiningCycle, v: Values) -> None:
    """Run cycle 208: a helix of Q334 a turn on the diameter Q335 to the depth, a full circle there, back to the middle, rapid out."""
    hole, (a, b), r = c.hole(), c.here(), c.recorder
    radius = v["diameter"] / 2.0 - c.radius()
    hole.to(hole.clearance, True)
    step = v["pitch"] or c.surface - hole.bottom
    clockwise = round(v.without("climb", 1.0)) == -1
    normal = PLANES[r.plane][2]
    with c.feed_at(v["feed"]):
        if radius > 1e-6:
            c.to(a + radius, None, None, False)
            for depth in depths_of(r.p[normal], hole.bottom, step):
                r.arc(c.at(a + radius, b, depth), c.at(a, b, depth), clockwise)
            r.arc(c.at(a + radius, b, hole.bottom), c.at(a, b, hole.bottom), clockwise)
            c.to(a, b, None, False)
        else:
            hole.feed_in()
    hole.leave()


# -- cycles that count from the position of the tool -----------------------------------------------------------------------
def _old(c: MachiningCycle, v: Values) -> tuple[Hole, float]:
    """Return the hole of an old cycle and the height of its surface. The sign of DEPTH says which way; the others have none of their own."""
    start = c.recorder.p[PLANES[c.recorder.plane][2]]
    way = -1.0 if v["DEPTH"] <= 0 else 1.0
    surface = start + way * v["DIST"]
    return Hole(c.recorder, start, surface + v["DEPTH"], start, idle=True), surface


def old_peck(c: MachiningCycle, v: Values) -> None:
    """Run cycle 1: by PECKG to DEPTH; rapid to the start and back to the advanced stop before the depth reached (0.6 mm; depth / 50 above
    30 mm, 7 mm at most); dwell at the bottom, rapid out."""
    hole, surface = _old(c, v)
    total = abs(v["DEPTH"])
    ahead = ENTRY if total <= 30.0 else min(total / ENTRY_SHARE, ENTRY_MOST)
    way = 1.0 if hole.bottom <= surface else -1.0
    step = v["PECKG"] or total
    depths = [surface + way * (d - surface) for d in depths_of(surface, surface - total, step)]
    with c.feed_at(v["F"]):
        hole.pecks(depths, lambda depth: depth + way * ahead)
        hole.wait(v["DWELL"])
        hole.leave()


def old_tap(c: MachiningCycle, v: Values) -> None:
    """Run cycles 2, 17: to DEPTH in one motion, dwell, back at the same feed; 17 at PITCH times the spindle speed."""
    hole, _ = _old(c, v)
    with c.feed_at(v["PITCH"] * c.recorder.speed, v["F"]):
        hole.feed_in(v["DWELL"])
        hole.to(hole.retract, False)


def old_thread(c: MachiningCycle, v: Values) -> None:
    """Run cycle 18: from the position of the tool to DEPTH at PITCH times the spindle speed; the tool stays there."""
    r = c.recorder
    start = r.p[PLANES[r.plane][2]]
    with c.feed_at(v["PITCH"] * r.speed):
        Hole(r, start, start + v["DEPTH"], start).feed_in()


_IN = "Q200=clear mm!, Q201=depth mm!, Q206=feed feed!"
_UP, _RIGID = "Q203=surface mm!, Q204=second mm", "Q200=clear mm!, Q201=depth mm!, Q239=pitch size!"
_SHRINK = "Q212=less mm, Q205=least mm"
HOLES: Mapping[str, Cycle[KlartextPrimitive]] = {
    "200": cycle(f"{_IN}, Q202=step mm!, Q210=pause time, {_UP}, Q211=dwell time", drill),
    "201": cycle(f"{_IN}, Q211=dwell time, Q208=back feed, {_UP}", ream),
    "202": cycle(f"{_IN}, Q211=dwell time, Q208=back feed, {_UP}, Q214=side count", bore),
    "203": cycle(f"{_IN}, Q202=step mm!, Q210=pause time, {_UP}, {_SHRINK}, Q213=breaks count, Q211=dwell time, Q208=back feed, Q256=lift mm", universal),
    "205": cycle(f"{_IN}, Q202=step mm!, {_UP}, {_SHRINK}, Q258=ahead mm, Q259=ahead_last mm, Q257=piece size, Q256=lift mm, Q211=dwell time, Q379=start size, Q253=approach feed, Q208=back feed", peck),
    "206": cycle(f"{_IN}, Q211=dwell time, {_UP}", tap),
    "207": cycle(f"{_RIGID}, {_UP}", rigid),
    "208": cycle(f"{_IN}, Q334=pitch size!, {_UP}, Q335=diameter mm!, Q351=climb count?", bore_mill),
    "209": cycle(f"{_RIGID}, {_UP}, Q257=piece size, Q256=lift mm", rigid),
    "240": cycle(f"Q200=clear mm!, Q343=by_diameter count, Q201=depth mm, Q344=diameter size, Q206=feed feed!, Q211=dwell time, {_UP}", centre),
    "241": cycle(f"{_IN}, Q211=dwell time, {_UP}, Q379=start size, Q253=approach feed, Q208=back feed", single_lip),
}  # fmt: skip
OLD_HOLES: Mapping[str, BlockwiseCycle] = {
    "1": blockwise("DIST size; DEPTH mm; PECKG size; DWELL time; F feed", old_peck),
    "2": blockwise("DIST size; DEPTH mm; DWELL time; F feed", old_tap),
    "17": blockwise("DIST size; DEPTH mm; PITCH size", old_tap),
    "18": blockwise("DEPTH mm; PITCH size", old_thread),
}
