"""Milling cycles of Sinumerik as a table: POCKET1 to POCKET4, CYCLE71, CYCLE61, SLOT1, LONGHOLE, CYCLE72, CYCLE90.

Source: Siemens, SINUMERIK 840D/840Di/810D, Programming Guide Cycles (PGZ), "Milling cycles"; SINUMERIK 840D sl / 828D, "Programming cycles
externally" for POCKET3, POCKET4, CYCLE61 and CYCLE72. A remark states choices that the manual leaves to the control (clearing of a pocket, approach to a
contour).

CYCLE72 follows a contour at several depths, with approach and retraction ("Path milling - CYCLE72"): RL 40, 41, 42 is G40, G41, G42; AS1, AS2 1 a straight line, 2 a quadrant,
3 a semicircle (tens 1: in space); LP1, LP2 their length (from the edge of the tool) or the radius of the path of the tool centre; VARI tens 1:
ways between depths at FF3; hundreds 0: up to RTP between depths, 1: to RFP + SDIS, 2: by SDIS.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from typing import TYPE_CHECKING

from vcmm.program.clearing import PathPiece, rectangle, rows
from vcmm.program.contouring import Flat, flat, offset_contour, pieces, tangent
from vcmm.program.cutter import CycleCutter, equal_depths
from vcmm.program.cycle_tables import Cycle, Values, cycle
from vcmm.program.drilling import depths_of, whole_count
from vcmm.program.expressions import evaluate
from vcmm.program.faults import BlockFault
from vcmm.program.moves import Move
from vcmm.program.radius import SINUMERIK
from vcmm.program.sinumerik.blocks import Item
from vcmm.program.sinumerik.flow import SinumerikRunner
from vcmm.program.sinumerik.pockets import STRAIGHT, Insertion, MillingCall, clear, is_clockwise, pocket

if TYPE_CHECKING:
    from vcmm.program.sinumerik.paths import SinumerikPaths

SIDES = {41: "left", 42: "right"}


def mill_contour(m: MillingCall, v: Values) -> None:
    """Mill the contour at each depth; forward each time."""
    from vcmm.program.sinumerik.turning import contour_moves

    check(m, v)
    name = next((evaluate(a, m.runner) for a in m.item.arguments or () if a is not None), "")
    r, c = m.paths.r, m.cutter
    before, r.feed = r.feed, r.feed or v["FFP1"] or None  # a contour without F
    moves = contour_moves(m.paths, m.runner, str(name), m.item)
    r.feed = before
    if moves is None:
        return
    rough = v.number("VARI") % 10 == 1
    side, side_of = SIDES.get(v.number("RL")), v.number("RL")
    tool = c.radius("CYCLE72")
    path = offset_contour(moves[1:], side, tool + (v["FAL"] if rough else 0.0), SINUMERIK, r.file)
    m.note(
        "how far approach and retraction begin",
        "LP1 and LP2 from the edge of the tool (line), radius of the path of its centre (arc)",
    )
    lead_in = approach(path[0], tangent(path[0], False), v.number("AS1"), v["LP1"], side_of, tool)
    lead_out = approach(path[-1], tangent(path[-1], True), v.number("AS2"), v["LP2"], side_of, tool, out=True)
    over, up = v["RFP"] + v["SDIS"], v.number("VARI") // 100 % 10
    levels = equal_depths(v["RFP"], v["DP"] + (v["FALD"] if rough else 0.0), v["MID"])
    c.to(None, max(c.height, v["RTP"]), True)
    for k, level in enumerate(levels):
        c.to(lead_in[0], None, v.number("VARI") // 10 % 10 == 0 or k == 0)
        if k == 0 or up in (0, 1):
            c.to(None, over, True)
        with c.feed_at(v["FFD"]):
            c.to(None, level, False)
        with c.feed_at(v["FFP1"]):
            c.follow([*lead_in[1], *pieces(path), *lead_out[1]], level)
        if k < len(levels) - 1 and up != 3:
            c.to(None, {0: v["RTP"], 1: over}.get(up, level + v["SDIS"]), True)
    c.to(None, v["RTP"], True)


def check(m: MillingCall, v: Values) -> None:
    """Refuse what is not understood."""
    kind = v.number("VARI") % 10
    for bad, text in (
        (kind not in (1, 2) or v.number("VARI") >= 10000, f"VARI {v.number('VARI')} (read are 1 and 2 in its units, forward)"),
        (v.number("RL") not in (40, 41, 42), f"RL {v.number('RL')} (40, 41 or 42)"),
        (v.number("AS1") not in (1, 2, 3) or v.number("AS2") not in (0, 1, 2, 3), f"AS1 {v.number('AS1')}, AS2 {v.number('AS2')} (1 line, 2 quadrant, 3 semicircle, in the plane)"),
        (v.number("RL") == 40 and (v.number("AS1") > 1 or v.number("AS2") > 1), "RL 40 with an arc of approach: on which side is not stated"),
        (v["DP"] >= v["RFP"], "DP above RFP"),
    ):  # fmt: skip
        if bad:
            raise BlockFault(
                m.item.first, f"CYCLE72 with {text} is not understood; write its motion with G1 to G3"
            )


def approach(
    move: Move, way: Flat, kind: int, length: float, side: int, tool: float, out: bool = False
) -> tuple[Flat, list[PathPiece]]:
    """Return the start of an approach, and its pieces (out: a retraction). A line is `length` and the radius of the tool long, mm; arcs lie on
    the side of the tool, left of the way with 41."""
    end = flat(move, out)
    sign = 1.0 if out else -1.0
    left = -1.0 if side == 42 else 1.0
    n = (-way[1] * left, way[0] * left)
    centre = (end[0] + n[0] * length, end[1] + n[1] * length)
    if kind == 0 or not length:
        return end, []
    if kind == 1:
        far = (end[0] + sign * way[0] * (length + tool), end[1] + sign * way[1] * (length + tool))
        return far, [PathPiece(far if out else end)]
    far = (
        (centre[0] + sign * way[0] * length, centre[1] + sign * way[1] * length)
        if kind == 2
        else (centre[0] + n[0] * length, centre[1] + n[1] * length)
    )
    return far, [PathPiece(far if out else end, centre, side == 42)]


MillingPrimitive = Callable[[MillingCall, Values], None]


def face(m: MillingCall, v: Values) -> None:
    """Run CYCLE71: rows to and fro over a face, in infeeds MID, FDP beside it at their ends."""
    count = math.ceil(abs(v["WID"]) / v["MIDA"]) + 1 if v["MIDA"] else 2
    m.note_clearing("in rows to and fro")
    w, out = v["STA"], v["FDP"]
    local = rows((-out, 0.0), (v["LENG"] + 2 * out, v["WID"]), count)
    ends = [
        (v["PA"] + x * math.cos(w) - y * math.sin(w), v["PO"] + x * math.sin(w) + y * math.cos(w))
        for x, y in local
    ]
    depth = v["DP"] + v["FALD"]
    _over(m, v, ends, depths_of(v["RFP"], depth, v["MID"] or v["RFP"] - depth), True)


def plane_face(m: MillingCall, v: Values) -> None:
    """Run CYCLE61: rows along the first (tens of VARI 1, 3) or the second axis (2, 4), in one direction (1, 2) or to and fro (3, 4); MIDA
    in mm, or (tens of AMODE 1) in percent of the tool diameter; the tool is beside the face at the ends of rows."""
    way, mode, radius = v.number("VARI") // 10 % 10, v.number("AMODE"), m.radius()
    if mode % 10 or mode > 19 or v.number("LIM") or way not in (1, 2, 3, 4):
        raise BlockFault(
            m.item.first,
            f"CYCLE61 with VARI {v.number('VARI')}, LIM {v.number('LIM')}, AMODE {mode} is not understood: read are rows (tens of VARI 1 to 4) without limits "
            "(LIM 0), an absolute depth and incremental lengths (AMODE 0 or 10); write its motion with G1",
        )  # fmt: skip
    step = v["MIDA"] / m.paths.r.unit * 0.02 * radius if mode >= 10 else v["MIDA"]
    m.note_clearing("in rows a step apart, the tool one radius and SDIS beside the face at their ends")
    along, across = (v["LENG"], v["WID"]) if way in (1, 3) else (v["WID"], v["LENG"])
    out = math.copysign(radius + v["SDIS"], along)
    count = max(2, math.ceil(abs(across) / step - 1e-9) + 1) if step else 2
    if way in (1, 2):
        local = [
            p
            for k in range(count)
            for p in ((-out, across * k / (count - 1)), (along + out, across * k / (count - 1)))
        ]
    else:
        local = rows((-out, 0.0), (along + 2 * out, across), count)
    ends = [(v["PA"] + x, v["PO"] + y) if way in (1, 3) else (v["PA"] + y, v["PO"] + x) for x, y in local]
    depth = v["DP"] + (v["FALD"] if v.number("VARI") % 10 == 1 else 0.0)
    if depth >= v["RFP"]:
        raise BlockFault(m.item.first, "CYCLE61: the depth must lie below RFP; correct the planes")
    _over(m, v, ends, equal_depths(v["RFP"], depth, v["MID"]), way in (3, 4))


def _over(
    m: MillingCall, v: Values, ends: list[tuple[float, float]], levels: list[float], to_and_fro: bool
) -> None:
    """Make rows between pairs of ends at each level; in one direction the tool goes back above the face."""
    c, over = m.cutter, v["RFP"] + v["SDIS"]
    for level in levels:
        c.to(None, max(c.height, over), True)
        c.to(ends[0], None, True)
        c.to(None, level, False)
        with c.feed_at(v["FFP1"]):
            for k, end in enumerate(ends[1:], 1):
                if k % 2 == 0 and not to_and_fro:
                    c.to(None, over, True)
                    c.to(end, None, True)
                    c.to(None, level, False)
                else:
                    c.to(end, None, False)
    c.to(None, v["RTP"], True)


def _rays(v: Values) -> list[float]:
    """Return the directions of holes or slots on a circle, rad: from STA1 by INDA, or evenly."""
    count = whole_count(v["NUM"])
    step = v["INDA"] or 2.0 * math.pi / max(count, 1)
    return [v["STA1"] + k * step for k in range(count)]


def long_holes(m: MillingCall, v: Values) -> None:
    """Run LONGHOLE: NUM holes of the width of the tool along rays, LENG long from RAD on. The infeed is at the ends, one after the other."""
    c, radius, over = m.cutter, m.radius(), v["RFP"] + v["SDIS"]
    inner, outer = v["RAD"] + radius, v["RAD"] + v["LENG"] - radius
    if inner > outer:
        raise BlockFault(
            m.item.first,
            f"LONGHOLE: the tool is wider ({2 * radius:g} mm) than a hole is long ({v['LENG']:g} mm); take a smaller one",
        )
    m.note("from where infeeds count", "from RFP + SDIS, in equal steps of MID at most (_ZSD[1] = 0)")
    m.note("where a long hole begins", "its end lies on the circle of RAD")
    for w in _rays(v):
        ends = [(v["CPA"] + q * math.cos(w), v["CPO"] + q * math.sin(w)) for q in (inner, outer)]
        c.to(None, max(c.height, v["RTP"]), True)
        c.to(ends[0], None, True)
        c.to(None, over, True)
        for k, level in enumerate(equal_depths(over, m.floor(v), v["MID"])):
            with c.feed_at(v["FFD"]):
                c.to(None, level, False)
            with c.feed_at(v["FFP1"]):
                c.to(ends[1 - k % 2], None, False)
        c.to(None, v["RTP"], True)


def slots(m: MillingCall, v: Values) -> None:
    """Run SLOT1: NUM slots of LENG by WID along rays, from RAD on; FAL stays at their edges where VARI is 1. VARI 1: rough, 2: finish, 0: both."""
    radius, kind = m.radius(), v.number("VARI") % 10
    side = v["FAL"] if kind == 1 else 0.0
    along, across = v["LENG"] / 2 - radius - side, v["WID"] / 2 - radius - side
    if v["WID"] < 2 * radius - 1e-9:
        raise BlockFault(
            m.item.first,
            f"SLOT1: the tool ({2 * radius:g} mm) is wider than a slot ({v['WID']:g} mm); take a smaller one",
        )
    m.note_clearing("in rings about the middle line, an infeed at the middle", "G1 and G2")
    m.note("from where infeeds count", "from RFP + SDIS, in equal steps of MID at most (_ZSD[1] = 0)")
    floor = m.floor(v) + (v["FALD"] if kind == 1 else 0.0)
    size = (max(along, 0.0), max(across, 0.0))
    for w in _rays(v):
        middle = v["RAD"] + v["LENG"] / 2
        path = rectangle(size, 0.8 * 2.0 * radius, size[1], is_clockwise(m, v), w)
        spot = (v["CPA"] + middle * math.cos(w), v["CPO"] + middle * math.sin(w))
        m.cutter.to(None, max(m.cutter.height, v["RTP"]), True)
        placed = Values({**v.numbers, "PA": spot[0], "PO": spot[1]})
        clear(m, placed, path, equal_depths(v["RFP"] + v["SDIS"], floor, v["MID"]), Insertion(STRAIGHT))
        m.cutter.to(None, v["RTP"], True)


def thread(m: MillingCall, v: Values) -> None:
    """Run CYCLE90: a helix of the pitch PIT from RFP to DP about CPA, CPO, inside (TYPTH 0) or outside (1), by G2 or G3 (CDIR)."""
    c, radius = m.cutter, m.cutter.radius("CYCLE90")
    inside, floor = v.number("TYPTH") == 0, m.floor(v)
    if not v["PIT"]:
        raise BlockFault(m.item.first, "CYCLE90 needs the pitch PIT")
    run = v["DIATH"] / 2 - radius if inside else v["KDIAM"] / 2 + radius
    if run <= 0:
        raise BlockFault(
            m.item.first,
            f"CYCLE90: the tool ({2 * radius:g} mm) does not go into a thread of {v['DIATH']:g} mm; take a smaller one",
        )
    m.note_clearing(
        "from RFP to DP by its pitch; the way in and out is assumed as half a circle inside, a line outside",
        "G2 and G3 with TURN",
    )
    clockwise, middle = v.number("CDIR") == 2, (v["CPA"], v["CPO"])
    begin = (middle[0] + run, middle[1])
    start = middle if inside else (middle[0] + run + v["SDIS"], middle[1])
    c.to(None, max(c.height, v["RTP"]), True)
    c.to(start, None, True)
    c.to(None, v["RFP"], True)
    with c.feed_at(v["FFR"]):
        if inside:
            c.thread(middle, run, (v["RFP"], floor), v["PIT"], clockwise)
        else:
            c.to(begin, None, False)
            c.helix(middle, run, (v["RFP"], floor), v["PIT"], clockwise)
            (a, b), away = c.here(), (run + v["SDIS"]) / run
            c.to((middle[0] + (a - middle[0]) * away, middle[1] + (b - middle[1]) * away), None, False)
    c.to(None, v["RTP"], True)


_POCKET1, _POCKET3 = "RTP mm, RFP mm, SDIS size, DP mm, DPR size,", "RTP mm, RFP mm, SDIS size, DP mm,"
_ON_A_CIRCLE = "CPA mm, CPO mm, RAD size, STA1 deg, INDA deg, FFD feed, FFP1 feed, MID size"
MILLING: Mapping[str, Cycle[MillingPrimitive]] = {
    "POCKET1": cycle(f"{_POCKET1} LENG mm, WID mm, CRAD mm, PA mm, PO mm, STA deg, FFD feed, FFP1 feed, MID size, CDIR count, FAL mm, VARI count, MIDF size, FFP2 feed, SSF plain", pocket),
    "POCKET2": cycle(f"{_POCKET1} PRAD mm, PA mm, PO mm, FFD feed, FFP1 feed, MID size, CDIR count, FAL mm, VARI count, MIDF size, FFP2 feed, SSF plain", pocket),
    "POCKET3": cycle(f"{_POCKET3} LENG mm, WID mm, CRAD mm, PA mm, PO mm, STA deg, MID size, FAL mm, FALD mm, FFP1 feed, FFD feed, CDIR count, VARI count, MIDA mm, AP1 size, AP2 size, AD size, RAD1 size, DP1 size", pocket),
    "POCKET4": cycle(f"{_POCKET3} PRAD mm, PA mm, PO mm, MID size, FAL mm, FALD mm, FFP1 feed, FFD feed, CDIR count, VARI count, MIDA mm, AP1 size, AD size, RAD1 size, DP1 size", pocket),
    "CYCLE71": cycle(f"{_POCKET3} PA mm, PO mm, LENG mm, WID mm, STA deg, MID size, MIDA size, FDP size, FALD mm, FFP1 feed", face),
    "CYCLE61": cycle(f"{_POCKET3} PA mm, PO mm, LENG mm, WID mm, MID size, MIDA size, FALD size, FFP1 feed, VARI count, LIM count, DMODE count, AMODE count", plane_face),
    "LONGHOLE": cycle(f"{_POCKET1} NUM count, LENG size, {_ON_A_CIRCLE}", long_holes),
    "SLOT1": cycle(f"{_POCKET1} NUM count, LENG size, WID size, {_ON_A_CIRCLE}, CDIR count, FAL size, VARI count, MIDF size, FFP2 feed, SSF plain, FALD size, STA2 deg", slots),
    "CYCLE90": cycle(f"{_POCKET1} DIATH size, KDIAM size, PIT size, FFR feed, CDIR count, TYPTH count, CPA mm, CPO mm", thread),
    "CYCLE72": cycle("KNAME text, RTP mm, RFP mm, SDIS size, DP mm, MID size, FAL size, FALD size, FFP1 feed, FFD feed, VARI count, RL count, AS1 count, LP1 size, FF3 feed, AS2 count, LP2 size", mill_contour),
}  # fmt: skip


def mill(i: SinumerikPaths, runner: SinumerikRunner, item: Item, arguments: Sequence[float | None]) -> None:
    """Run the cycle of a call."""
    row = MILLING[item.name]
    row.primitive(MillingCall(i, runner, item, CycleCutter(i.r)), i.values(row, arguments, item.name))
