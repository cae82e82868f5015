"""CYCLE72 of Sinumerik: a contour followed by the tool at several depths, with its approach and retraction.

Source: Siemens, Programming Guide Cycles, "Path milling - CYCLE72": RL 40, 41, 42 is G40, G41, G42; AS1, AS2 1 a straight line, 2 a quadrant,
3 a semicircle (tens 1: in space); LP1, LP2 their length (from the edge of the tool) or the radius of the path of the tool centre; VARI tens 1:
ways between depths at FF3; hundreds 0: up to RTP between depths, 1: to RFP + SDIS, 2: by SDIS.
"""

from __future__ import annotations

from vcmm.program.clearing import PathPiece
from vcmm.program.contouring import Flat, flat, offset_contour, pieces, tangent
from vcmm.program.cutter import equal_depths
from vcmm.program.cycle_tables import Values
from vcmm.program.expressions import evaluate
from vcmm.program.faults import BlockFault
from vcmm.program.moves import Move
from vcmm.program.radius import SINUMERIK
from vcmm.program.sinumerik.milling_call import MillingCall

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
    """Refuses what is not understood."""
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
