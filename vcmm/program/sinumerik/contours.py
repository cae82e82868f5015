"""CYCLE72 of Sinumerik: a contour followed by the tool at several depths, with its approach and retraction.

Source: Siemens, Programming Guide Cycles, "Path milling - CYCLE72": RL 40, 41, 42 is G40, G41, G42; AS1, AS2 1 a straight line, 2 a quadrant,
3 a semicircle (tens 1: in space); LP1, LP2 their length (from the edge of the tool) or the radius of the path of the tool centre; VARI tens 1:
ways between depths at FF3; hundreds 0: up to RTP between depths, 1: to RFP + SDIS, 2: by SDIS.
"""

from __future__ import annotations

import math
from typing import TYPE_CHECKING

from vcmm.program.clearing import PathPiece
from vcmm.program.cutter import equal_depths
from vcmm.program.cycle_tables import Values
from vcmm.program.expressions import evaluate
from vcmm.program.faults import BlockFault
from vcmm.program.moves import PLANES, Move
from vcmm.program.radius import SINUMERIK, RadiusCompensation, centre_path

if TYPE_CHECKING:
    from vcmm.program.sinumerik.milling import MillingCall

Flat = tuple[float, float]
SIDES = {41: "left", 42: "right"}


def mill_contour(m: MillingCall, v: Values) -> None:
    """The contour at each depth; forward each time."""
    from vcmm.program.sinumerik.turning import record_contour

    check(m, v)
    name = next((evaluate(a, m.runner) for a in m.item.arguments or () if a is not None), "")
    r, c = m.paths.r, m.cutter
    kept, r.feed = r.feed, r.feed or v["FFP1"] or None  # a contour without F
    moves = record_contour(m.paths, m.runner, str(name), m.item)
    r.feed = kept
    if moves is None:
        return
    rough = v.number("VARI") % 10 == 1
    side, side_of = SIDES.get(v.number("RL")), v.number("RL")
    tool = c.radius("CYCLE72")
    path = beside(m, moves[1:], side, tool + (v["FAL"] if rough else 0.0))
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
            c.follow([*lead_in[1], *pieces(path, m), *lead_out[1]], level)
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


def beside(m: MillingCall, moves: list[Move], side: str | None, radius: float) -> list[Move]:
    """The contour as the path of the tool centre, without ways in and out."""
    if side is None or not radius:
        return moves
    first, last = _lead(m, moves[0], False), _lead(m, moves[-1], True)
    compensation = RadiusCompensation(side, radius, SINUMERIK)
    sides: list[RadiusCompensation | None] = [*[compensation] * (len(moves) + 1), None]
    made = centre_path([first, *moves, last], sides, m.paths.r.file)
    return made[1:-1]


def _lead(m: MillingCall, move: Move, behind: bool) -> Move:
    """A line into the contour along its first direction, or out of it along its last, far enough for any tool."""
    a, b = tangent(move, behind)
    one, two, _ = PLANES[m.paths.r.plane]
    end = move.end if behind else move.start
    far = list(end)
    for k, value in ((one, a), (two, b)):
        far[k] += value * 1e3 * (1.0 if behind else -1.0)
    away = (far[0], far[1], far[2])
    line = move._replace(kind="line", centre=None, clockwise=None, turns=1)
    return line._replace(start=end, end=away) if behind else line._replace(start=away, end=end)


def flat(move: Move, at_end: bool) -> Flat:
    """The first or the last point of a move in its plane."""
    one, two, _ = PLANES[move.plane]
    point = move.end if at_end else move.start
    return point[one], point[two]


def tangent(move: Move, at_end: bool) -> Flat:
    """The direction of a move at one of its ends."""
    (a, b), (c, d) = flat(move, False), flat(move, True)
    if move.centre is None:
        length = math.hypot(c - a, d - b)
        return (c - a) / length, (d - b) / length
    one, two, _ = PLANES[move.plane]
    p = (c, d) if at_end else (a, b)
    x, y = p[0] - move.centre[one], p[1] - move.centre[two]
    length = math.hypot(x, y)
    return (y / length, -x / length) if move.clockwise else (-y / length, x / length)


def approach(
    move: Move, way: Flat, kind: int, length: float, side: int, tool: float, out: bool = False
) -> tuple[Flat, list[PathPiece]]:
    """Where an approach begins, and its pieces (out: a retraction). A line is `length` and the radius of the tool long, mm; arcs lie on
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


def pieces(path: list[Move], m: MillingCall) -> list[PathPiece]:
    """The moves as pieces at one height."""
    one, two, _ = PLANES[m.paths.r.plane]
    out = []
    for move in path:
        centre = None if move.centre is None else (move.centre[one], move.centre[two])
        out.append(PathPiece(flat(move, True), centre, bool(move.clockwise)))
    return out
