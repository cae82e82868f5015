"""Turning cycles of Sinumerik: CYCLE95 (stock removal along a contour) and CYCLE97 (thread cutting).

Source: Siemens, SINUMERIK 840D sl / 802D sl, Programming Manual Cycles, "Turning cycles". Points are (X as a radius, Z), mm.
"""

from __future__ import annotations

import copy
import math
from collections.abc import Callable, Iterator, Mapping, Sequence

from vcmm.program.chords import arc_or_chords
from vcmm.program.contouring import record_contour
from vcmm.program.cycle_tables import Cycle, Values, cycle
from vcmm.program.drilling import COARSE, whole_count
from vcmm.program.expressions import evaluate
from vcmm.program.faults import BlockFault
from vcmm.program.levels import NOT_MOVED
from vcmm.program.moves import Move, Point
from vcmm.program.roughing import Cut, Flat, Rough, follow_contour, passes, section_of
from vcmm.program.sinumerik.blocks import Item
from vcmm.program.sinumerik.flow import SinumerikRunner
from vcmm.program.sinumerik.paths import SinumerikPaths

LIFT = 1.0  # mm: VRT where it is zero or left out


# -- threads --------------------------------------------------------------------------------------------------------------
def thread(i: SinumerikPaths, runner: SinumerikRunner, item: Item, v: Values) -> None:
    """Run CYCLE97."""
    r = i.r
    lead = v["PIT"] or COARSE.get(round(abs(v["MPIT"])), 0.0)
    if not lead or not v["TDEP"]:
        raise BlockFault(
            item.first, "CYCLE97 needs the pitch PIT (or the size MPIT) and the depth TDEP of the thread"
        )
    first, last = (v["DM1"] / 2.0, v["SPL"]), (v["DM2"] / 2.0, v["FPL"])
    way = math.copysign(1.0, last[1] - first[1])
    slope = (last[0] - first[0]) / (last[1] - first[1]) if last[1] != first[1] else 0.0
    begin, end = first[1] - way * v["APP"], last[1] + way * v["ROP"]
    inside = 1.0 if v.number("VARI") in (2, 4) else -1.0  # the way in: from the axis out, or towards it
    lift = v["_VRT"] or LIFT
    starts = whole_count(max(v["NUMT"], 1.0))
    for number in range(starts):
        if number or v["NSP"]:
            r.assume(
                "the angle at which a thread starts (NSP, NUMT)",
                "in time with the spindle: it moves no axis",
                matters=False,
            )
        for depth, aside in _infeeds(v):
            z = begin + way * aside
            low, high = (first[0] + slope * (q - first[1]) + inside * depth for q in (z, end))
            away = min(first[0], last[0]) - lift if inside > 0 else max(first[0], last[0]) + lift
            _to(i, (away, z), True)
            _to(i, (low, z), True)
            _thread(i, (high, end), lead)
            _to(i, (away, end), True)
        _to(i, (away, begin), True)


def _infeeds(v: Values) -> Iterator[Flat]:
    """Yield the depth of each cut and its way along the flank, mm: NRC cuts to TDEP - FAL, equal (VARI 1, 2) or of equal section (3, 4), one to
    TDEP where an allowance is left, NID without infeed. IANG < 0: on both flanks in turn."""
    depth, allowance, count = v["TDEP"], v["FAL"], whole_count(max(v["NRC"], 1.0))
    slope = math.tan(abs(v["IANG"]))
    equal = v.number("VARI") in (0, 1, 2)
    for k in range(1, count + 1):
        at = (depth - allowance) * (k / count if equal else math.sqrt(k / count))
        yield at, at * slope * (-1.0 if v["IANG"] < 0 and k % 2 == 0 else 1.0)
    for _ in range((1 if allowance else 0) + whole_count(v["NID"])):
        yield depth, depth * slope


def _thread(i: SinumerikPaths, end: Flat, lead: float) -> None:
    r = i.r
    start, goal = r.tip(), r.world.apply(_point(i, end))
    turns = abs(r.spindle(start, goal))
    if not turns:
        r.assume(
            "the speed of a thread", "not known; its time is not counted",
            "CYCLE97 needs a turning spindle; add S and M3 or M4 before it", matters=False,
        )  # fmt: skip
    r.emit("thread", goal, feed=lead * turns or None)
    r.p = _point(i, end)


# -- stock removal --------------------------------------------------------------------------------------------------------
def contour(i: SinumerikPaths, runner: SinumerikRunner, item: Item, v: Values) -> None:
    """Run CYCLE95: VARI 1 to 4 rough (along, across, outside; along, across,
    inside), 5 to 8 finish, 9 to 12 both. The depth is divided evenly into cuts of MID at most."""
    name = next((evaluate(a, runner) for a in item.arguments or () if a is not None), "")
    before, i.r.feed = (
        i.r.feed,
        i.r.feed or v["FF1"] or v["FF3"] or None,
    )  # a contour without F is cut with FF1 and FF3
    moves = contour_moves(i, runner, str(name), item)
    i.r.feed = before
    if moves is None:
        return
    kind = (v.number("VARI") - 1) % 4
    rough, finish = not 5 <= v.number("VARI") <= 8, v.number("VARI") >= 5
    along, inside = kind in (0, 2), kind >= 2
    sign, lift = -1.0 if inside else 1.0, v["_VRT"] or LIFT
    x, z = sign * max(v["FALX"], v["FAL"]), max(v["FALZ"], v["FAL"])
    bare = section_of(moves[1:], Rough(1.0, lift, 0.0, 0.0))
    edge = (min if inside else max)(p[0] for p in bare)
    face = max(p[1] for p in bare)
    begin = (edge, face)
    safe = (edge + x + sign * lift, face + z + lift)
    _to(i, safe, True)
    if rough:
        goal = bare[0][0] if along else bare[0][1]
        deep = abs((begin[0] if along else begin[1]) - goal)
        count = max(1, whole_count(math.ceil(deep / v["MID"] - 1e-9))) if v["MID"] else 1
        entry = (begin[0], safe[1] - z) if along else (safe[0] - x, begin[1])
        shape = Rough(max(deep / count, 1e-9), lift, x, z)
        with_feed = list(
            passes(
                [moves[0]._replace(kind="rapid"), *moves[1:]],
                entry,
                shape,
                "XZ" if along else "ZX",
                item.first,
            )
        )
        _run(i, with_feed, v["FF1"])
        _to(i, safe, True)
    if finish:
        _to(i, (moves[1].start[0], moves[1].start[2]), True)
        _run(i, list(follow_contour(moves[1:], 0.0, 0.0)), v["FF3"])
        _to(i, safe, True)


def _run(i: SinumerikPaths, cuts: list[Cut], feed: float) -> None:
    before = i.r.feed
    i.r.feed = feed or before
    for cut in cuts:
        if cut.centre is None:
            _to(i, cut.end, cut.rapid)
        else:
            arc_or_chords(i.r, _point(i, cut.end), _point(i, cut.centre), cut.clockwise, cut.turns)
    i.r.feed = before


def contour_moves(i: SinumerikPaths, runner: SinumerikRunner, name: str, item: Item) -> list[Move] | None:
    """Return the moves of the contour in programmed coordinates; None where it is missing. No part of the state is changed by them."""
    r, start, _, end = i.r, *name.upper().partition(":")
    section = next(
        (
            s
            for s in (runner.current, *runner.sections.values())
            if s and end and {start, end} <= {b.label for b in s.blocks}
        ),
        None,
    )
    section = section or (None if end else runner.find(start))
    if section is None:
        r.assume(
            f"the contour {name} of {item.name}", NOT_MOVED,
            f"{item.name}: there is no contour {name}: a subprogram of that name, or labels START:END", column=item.first,
        )  # fmt: skip
        return None
    modes, caller = copy.copy(vars(i.modes)), runner.current
    with record_contour(r) as contour:
        labels = [b.label for b in section.blocks]
        if end:
            runner.part(section, labels.index(start), labels.index(end))
        else:
            runner.run(section)
        runner.current = caller
    vars(i.modes).update(modes)
    made = [m for m in contour.programmed_moves if m.kind in ("rapid", "line", "arc")]
    if len(made) < 2:
        raise BlockFault(item.first, f"{item.name}: {name} makes no contour; correct it")
    return made


def _point(i: SinumerikPaths, at: Flat) -> Point:
    return at[0], i.r.p[1], at[1]


def _to(i: SinumerikPaths, at: Flat, rapid: bool) -> None:
    point = _point(i, at)
    if math.dist(point, i.r.p) > 1e-12:
        i.r.straight(point, rapid)


TURNING: Mapping[str, Cycle[Callable[[SinumerikPaths, SinumerikRunner, Item, Values], None]]] = {
    "CYCLE95": cycle("NPP text, MID size, FALZ size, FALX size, FAL size, FF1 plain, FF2 plain, FF3 plain, VARI count, DT plain, DAM size, _VRT size", contour),
    "CYCLE97": cycle("PIT size, MPIT plain, SPL mm, FPL mm, DM1 mm, DM2 mm, APP size, ROP size, TDEP size, FAL size, IANG deg, NSP plain, NRC count, NID count, VARI count, NUMT count, _VRT size", thread),
}  # fmt: skip


def turn(i: SinumerikPaths, runner: SinumerikRunner, item: Item, arguments: Sequence[float | None]) -> None:
    """Run the cycle of a call."""
    row = TURNING[item.name]
    row.primitive(i, runner, item, i.values(row, arguments, item.name))
