"""Hole patterns and pockets of Sinumerik: HOLES1 HOLES2 CYCLE801 CYCLE802, POCKET1 to POCKET4, CYCLE71.

Source: Siemens, SINUMERIK 840D sl / 828D, Programming Manual Cycles (HMI), "Drilling patterns", "Milling cycles". The manual says that pockets are
cleared from the inside outwards in infeeds of MID; that the rings are taken as rectangles (circles) one outside the other is told.
"""

from __future__ import annotations

import math
from collections.abc import Sequence

from vcmm.program.chords import arc_or_chords
from vcmm.program.clearing import PathPiece, circle, rectangle, rows, shift_pieces
from vcmm.program.drilling import depths_of, whole_count
from vcmm.program.faults import BlockFault
from vcmm.program.levels import SetupEntry
from vcmm.program.moves import PLANES, Point
from vcmm.program.sinumerik.blocks import Item
from vcmm.program.sinumerik.flow import SinumerikRunner
from vcmm.program.sinumerik.paths import SinumerikPaths

Spots = list[tuple[float, float]]
Numbers = list[float | None]


def pad(given: Numbers, count: int) -> list[float]:
    """So many arguments; 0 for those left out."""
    return [v or 0.0 for v in (*given, *[None] * count)][:count]


# -- patterns -----------------------------------------------------------------------------------------------------------
def row(i: SinumerikPaths, given: Numbers) -> Spots:
    """HOLES1(SPCA, SPCO, STA1, FDIS, DBH, NUM): on a line, from the end that is nearer to the tool."""
    a, b, turn, first, step, count = pad(given, 6)
    w, u = math.radians(turn), i.r.unit
    out = [
        ((a + (first + k * step) * math.cos(w)) * u, (b + (first + k * step) * math.sin(w)) * u)
        for k in range(whole_count(count))
    ]
    here = _here(i)
    return out[::-1] if out and math.dist(out[-1], here) < math.dist(out[0], here) else out


def ring(i: SinumerikPaths, given: Numbers) -> Spots:
    """HOLES2(CPA, CPO, RAD, STA1, INDA, NUM): on a circle; INDA 0 spreads them evenly."""
    a, b, radius, start, step, count = pad(given, 6)
    step, u = step or 360.0 / max(count, 1.0), i.r.unit
    angles = [math.radians(start + k * step) for k in range(whole_count(count))]
    return [((a + abs(radius) * math.cos(w)) * u, (b + abs(radius) * math.sin(w)) * u) for w in angles]


def grid(i: SinumerikPaths, given: Numbers) -> Spots:
    """CYCLE801(SPCA, SPCO, STA, DIS1, DIS2, NUM1, NUM2): rows to and fro, along the shorter of the two distances."""
    a, b, turn, d1, d2, n1, n2 = pad(given, 7)
    w, u = math.radians(turn), i.r.unit
    along = abs(d1) <= abs(d2)
    inner, outer = (
        (whole_count(abs(n1)), whole_count(abs(n2)))
        if along
        else (whole_count(abs(n2)), whole_count(abs(n1)))
    )
    out: Spots = []
    for line in range(outer):
        for k in range(inner) if line % 2 == 0 else reversed(range(inner)):
            x, y = (k * abs(d1), line * abs(d2)) if along else (line * abs(d1), k * abs(d2))
            out.append(
                ((a + x * math.cos(w) - y * math.sin(w)) * u, (b + x * math.sin(w) + y * math.cos(w)) * u)
            )
    return out


def list_spots(i: SinumerikPaths, given: Numbers) -> Spots:
    """CYCLE802(_XA, _YA, X0, Y0, X1, Y1, ...): X0 and Y0 as they are; 9 points at most."""
    values = pad(given, 20)[2:]
    count = math.ceil(sum(v is not None for v in given[2:20]) / 2)
    return [(values[2 * k] * i.r.unit, values[2 * k + 1] * i.r.unit) for k in range(count)]


PATTERNS = {"HOLES1": row, "HOLES2": ring, "CYCLE801": grid, "CYCLE802": list_spots}


def visit(i: SinumerikPaths, runner: SinumerikRunner, item: Item, given: Numbers) -> None:
    """Rapid to each point; the modal cycle at each."""
    for a, b in PATTERNS[item.name](i, given):
        _to(i, (a, b), None, True)
        if i.modes.cycle is not None:
            i.command(runner, i.modes.cycle, 1)


# -- pockets ------------------------------------------------------------------------------------------------------------
def pocket(i: SinumerikPaths, runner: SinumerikRunner, item: Item, given: Numbers) -> None:
    """POCKET3 and POCKET1 (rectangle), POCKET4 and POCKET2 (circle)."""
    named = _pocket_arguments(item.name, given)
    u, r = i.r.unit, i.r
    reference = named["RFP"] * u
    depth = named["DP"] * u if named["DP"] else reference - abs(named["DPR"]) * u
    if depth >= reference:
        raise BlockFault(item.first, f"{item.name}: the depth must lie below RFP; correct the planes")
    radius, side, floor = tool_radius(i), named["FAL"] * u, named["FALD"] * u
    step = named["MIDA"] * u or 0.8 * 2.0 * radius
    clockwise = round(named["CDIR"]) in (0, 2)
    r.assume(
        f"how {item.name} clears", "in rings from the inside outwards",
        f"how {item.name} clears is the control's own affair and not known; write its motion with G1 and G2", column=item.first,
    )  # fmt: skip
    if item.name in ("POCKET4", "POCKET2"):
        path = circle(max(named["PRAD"] * u - radius - side, 0.0), step, clockwise)
    else:
        size = (
            max(named["LENG"] * u / 2 - radius - side, 0.0),
            max(named["WID"] * u / 2 - radius - side, 0.0),
        )
        corner = max(named["CRAD"] * u - radius, 0.0)
        path = rectangle(size, step, corner, clockwise, math.radians(named["STA"]))
    middle = (named["PA"] * u, named["PO"] * u)
    over = reference + abs(named["SDIS"]) * u
    _to(i, None, max(r.p[PLANES[r.plane][2]], over), True)
    _to(i, middle, None, True)
    _to(i, None, over, True)
    mid = abs(named["MID"]) * u or reference - depth
    for level in depths_of(reference, depth + floor, mid):
        _feed(i, named["FFD"], middle, level)
        _ring(i, [*shift_pieces(path, middle), PathPiece(middle)], level, named["FFP1"])
    _to(i, None, named["RTP"] * u, True)


_POCKET = {
    "POCKET3": "RTP RFP SDIS DP LENG WID CRAD PA PO STA MID FAL FALD FFP1 FFD CDIR VARI MIDA",
    "POCKET4": "RTP RFP SDIS DP PRAD PA PO MID FAL FALD FFP1 FFD CDIR VARI MIDA",
    "POCKET1": "RTP RFP SDIS DP DPR LENG WID CRAD PA PO STA FFD FFP1 MID CDIR FAL VARI",
    "POCKET2": "RTP RFP SDIS DP DPR PRAD PA PO FFD FFP1 MID CDIR FAL VARI",
}


def _pocket_arguments(cycle: str, given: Numbers) -> dict[str, float]:
    names = _POCKET[cycle].split()
    out = dict.fromkeys(["DPR", "CRAD", "STA", "FALD", "MIDA"], 0.0)
    return out | dict(zip(names, pad(given, len(names))))


def tool_radius(i: SinumerikPaths) -> float:
    """Of the tool in the spindle, mm; 0 where nobody knows it: the path then runs on the contour."""
    tool = i.r.tool_data
    if tool.radius is None:
        i.r.assume(
            f"the diameter of tool {tool.number}", "0 mm: the path on the programmed contour",
            f"a pocket needs the radius of tool {tool.number}; state its diameter in the set-up under [tools.{tool.number}]",
            blank=SetupEntry(f"tools.{tool.number}", "diameter", '"10 mm"'),
        )  # fmt: skip
    return tool.radius or 0.0


def face(i: SinumerikPaths, runner: SinumerikRunner, item: Item, given: Numbers) -> None:
    """CYCLE71(RTP, RFP, SDIS, DP, PA, PO, LENG, WID, STA, MID, MIDA, FDP, FALD, FFP1): rows to and fro over a face, in infeeds MID."""
    names = [
        "RTP",
        "RFP",
        "SDIS",
        "DP",
        "PA",
        "PO",
        "LENG",
        "WID",
        "STA",
        "MID",
        "MIDA",
        "FDP",
        "FALD",
        "FFP1",
    ]
    n, u, r = dict(zip(names, pad(given, len(names)))), i.r.unit, i.r
    reference, depth = n["RFP"] * u, n["DP"] * u + n["FALD"] * u
    wide = abs(n["WID"]) * u
    count = math.ceil(wide / (abs(n["MIDA"]) * u)) + 1 if n["MIDA"] else 2
    r.assume(
        f"how {item.name} clears", "in rows to and fro",
        f"how {item.name} clears is the control's own affair and not known; write its motion with G1", column=item.first,
    )  # fmt: skip
    w, out = math.radians(n["STA"]), abs(n["FDP"]) * u
    local = rows((-out, 0.0), (n["LENG"] * u + 2 * out, n["WID"] * u), count)
    ends = [
        (n["PA"] * u + x * math.cos(w) - y * math.sin(w), n["PO"] * u + x * math.sin(w) + y * math.cos(w))
        for x, y in local
    ]
    for level in depths_of(reference, depth, abs(n["MID"]) * u or reference - depth):
        _to(i, None, max(r.p[PLANES[r.plane][2]], reference + abs(n["SDIS"]) * u), True)
        _to(i, ends[0], None, True)
        _feed(i, 0.0, None, level)
        _ring(i, [PathPiece(e) for e in ends[1:]], level, n["FFP1"])
    _to(i, None, n["RTP"] * u, True)


# -- moves --------------------------------------------------------------------------------------------------------------
def _here(i: SinumerikPaths) -> tuple[float, float]:
    one, two, _ = PLANES[i.r.plane]
    return i.r.p[one], i.r.p[two]


def _point(i: SinumerikPaths, spot: tuple[float, float] | None, height: float | None) -> Point:
    one, two, normal = PLANES[i.r.plane]
    point = list(i.r.p)
    if spot is not None:
        point[one], point[two] = spot
    if height is not None:
        point[normal] = height
    return point[0], point[1], point[2]


def _to(i: SinumerikPaths, spot: tuple[float, float] | None, height: float | None, rapid: bool) -> None:
    point = _point(i, spot, height)
    if point != i.r.p:
        i.r.straight(point, rapid)


def _feed(i: SinumerikPaths, feed: float, spot: tuple[float, float] | None, height: float) -> None:
    """Straight at a feed, mm/min; the feed in force where it is zero."""
    kept = i.r.feed
    i.r.feed = feed * i.modes.feed_unit if feed else kept
    _to(i, spot, height, False)
    i.r.feed = kept


def _ring(i: SinumerikPaths, path: Sequence[PathPiece], height: float, feed: float) -> None:
    """Pieces at one height and one feed."""
    kept = i.r.feed
    i.r.feed = feed * i.modes.feed_unit if feed else kept
    for piece in path:
        if piece.centre is None:
            _to(i, piece.end, None, False)
        else:
            arc_or_chords(i.r, _point(i, piece.end, height), _point(i, piece.centre, height), piece.clockwise)
    i.r.feed = kept
