"""POCKET1 to POCKET4 of Sinumerik: how deep, how wide, and how the tool goes in.

VARI of POCKET1 and POCKET2: 0 rough and finish, 1 rough, 2 finish. Of POCKET3 and POCKET4: units 1 rough, 2 finish; tens 0 straight down at
rapid (a pocket that is drilled before), 1 straight down at FFD, 2 on a helix of radius RAD1 in whole turns of DP1 at most and a full circle at
depth, from the side of the first axis; 3 to and fro along the pocket at an angle RAD1 at most, how long each way is the control works out.

Source: Siemens, SINUMERIK 840D/840Di/810D, Programming Guide Cycles (PGZ), "Milling rectangular pockets", "Milling circular pockets". What it
leaves to the control is done with a remark.
"""

from __future__ import annotations

import math
from typing import NamedTuple

from vcmm.program.clearing import PathPiece, circle, rectangle, shift_pieces
from vcmm.program.cutter import equal_depths
from vcmm.program.cycle_tables import Values
from vcmm.program.drilling import depths_of
from vcmm.program.faults import BlockFault
from vcmm.program.sinumerik.milling_call import MillingCall

AT_RAPID, STRAIGHT, ON_A_HELIX, TO_AND_FRO = range(4)
COMPLETE, ROUGH, FINISH = range(3)


class Insertion(NamedTuple):
    """How the tool gets to the depth of an infeed: which way, radius and depth of a turn of a helix, mm, where its turns begin, rad."""

    way: int
    radius: float = 0.0
    turn: float = 0.0
    angle: float = 0.0
    clockwise: bool = False


def is_clockwise(m: MillingCall, v: Values) -> bool:
    """CDIR: 2 is G2, 3 is G3; 0 is climb milling, inside G3 with M3 and G2 with M4; 1 the other way."""
    direction = v.number("CDIR")
    return direction == 2 if direction in (2, 3) else (direction == 1) == (m.paths.r.sense >= 0)


def pocket(m: MillingCall, v: Values) -> None:
    """POCKET3 and POCKET1 (rectangle), POCKET4 and POCKET2 (circle): from the inside outwards, in infeeds of MID."""
    depth, kind = m.floor(v), v.number("VARI") % 10
    m.radius()
    m.note_clearing("in rings from the inside outwards", "G1 and G2")
    if v["AP1"] or v["AP2"] or v["AD"]:
        m.note("the blank of the pocket (AP1, AP2, AD)", "none: cleared as from the solid")
    way = _insertion(m, v)
    if kind != FINISH:
        base = depth + v["FALD"]
        clear(m, v, _path(m, v, v["FAL"], True), depths_of(v["RFP"], base, v["MID"] or v["RFP"] - base), way)
    if kind == FINISH or (kind == COMPLETE and m.item.name in ("POCKET1", "POCKET2") and v["FAL"]):
        _finish(m, v, depth)
    m.cutter.to(None, v["RTP"], True)


def _finish(m: MillingCall, v: Values, depth: float) -> None:
    """Round the edge in infeeds of MIDF (POCKET3, POCKET4: MID), then over the base where an allowance stood on it."""
    most = v["MIDF"] or (v["MID"] if m.item.name in ("POCKET3", "POCKET4") else 0.0)
    plain = Insertion(STRAIGHT)
    feed = v["FFP2"] or v["FFP1"]
    clear(m, v, _path(m, v, 0.0, False), equal_depths(v["RFP"], depth, most), plain, feed)
    if v["FALD"]:
        clear(m, v, _path(m, v, 0.0, True), [depth], plain, feed)


def _path(m: MillingCall, v: Values, side: float, whole: bool) -> list[PathPiece]:
    """Rings of the middle of the tool, `side` mm left on the edge; whole: all of them, else the last one."""
    radius, clockwise = m.radius(), is_clockwise(m, v)
    step = (v["MIDA"] or 0.8 * 2.0 * radius) if whole else 0.0
    if m.item.name in ("POCKET4", "POCKET2"):
        return circle(max(v["PRAD"] - radius - side, 0.0), step, clockwise)
    size = (max(v["LENG"] / 2 - radius - side, 0.0), max(v["WID"] / 2 - radius - side, 0.0))
    return rectangle(size, step, max(v["CRAD"] - radius, 0.0), clockwise, v["STA"])


def _insertion(m: MillingCall, v: Values) -> Insertion:
    """What the tens of VARI say."""
    if m.item.name in ("POCKET1", "POCKET2"):
        return Insertion(STRAIGHT)
    way = v.number("VARI") // 10 % 10
    if way == ON_A_HELIX:
        if v["RAD1"] <= 0 or v["DP1"] <= 0:
            raise BlockFault(
                m.item.first,
                f"{m.item.name} with VARI 2x needs the radius RAD1 of its helix and the depth DP1 of a turn",
            )
        free = _half_width(m, v) - m.radius() - v["FAL"]
        if v["RAD1"] > free + 1e-9:
            raise BlockFault(
                m.item.first,
                f"{m.item.name}: a helix of RAD1 {v['RAD1']:g} mm leaves the pocket; at most {max(free, 0.0):g} mm fit beside the tool and FAL",
            )
        m.note("from where the helix goes in", "from RFP + SDIS, then from the depth reached")
        return Insertion(way, v["RAD1"], v["DP1"], v["STA"], is_clockwise(m, v))
    if way == AT_RAPID:
        m.note(
            "how the tool goes in with VARI 0x", "straight down at rapid (a pocket that is drilled before)"
        )
    if way == TO_AND_FRO:
        m.note("how the tool goes in to and fro (VARI 3x)", "straight down at FFD")
    elif way > TO_AND_FRO:
        raise BlockFault(m.item.first, f"{m.item.name}: the tens of VARI are 0 to 3, {way} stands there")
    return Insertion(STRAIGHT if way == TO_AND_FRO else way)


def _half_width(m: MillingCall, v: Values) -> float:
    """Return the distance from the middle of the pocket to its nearest wall, mm."""
    return v["PRAD"] if m.item.name in ("POCKET4", "POCKET2") else min(v["LENG"], v["WID"]) / 2


def clear(
    m: MillingCall, v: Values, path: list[PathPiece], levels: list[float], way: Insertion, feed: float = 0.0
) -> None:
    """A path about the middle of the pocket at each of the levels, mm, back to the middle each time. feed: FFP1 where it is zero."""
    c, over, middle = m.cutter, v["RFP"] + v["SDIS"], (v["PA"], v["PO"])
    c.to(None, max(c.height, over), True)
    c.to(middle, None, True)
    c.to(None, over, True)
    for level in levels:
        go_in(m, v, middle, level, way)
        with c.feed_at(feed or v["FFP1"]):
            c.follow([*shift_pieces(path, middle), PathPiece(middle)], level)


def go_in(m: MillingCall, v: Values, middle: tuple[float, float], level: float, way: Insertion) -> None:
    """From the middle of the pocket to a depth, mm."""
    c = m.cutter
    if way.way == AT_RAPID:
        c.to(middle, level, True)
        return
    with c.feed_at(v["FFD"]):
        if way.way != ON_A_HELIX:
            c.to(middle, level, False)
            return
        begin = (middle[0] + way.radius * math.cos(way.angle), middle[1] + way.radius * math.sin(way.angle))
        c.to(begin, None, False)
        high = c.height
        turns = math.ceil((high - level) / way.turn - 1e-9)
        c.helix(middle, way.radius, (high, level), (high - level) / turns, way.clockwise)
        c.follow([PathPiece(begin, middle, way.clockwise)], level)
