"""Milling cycles of Klartext: pockets and slots (3 to 5, 251 to 253), rows over a face (230, 232), threads (262).

Source: HEIDENHAIN, TNC 640 User's Manual Cycle Programming, "Pockets, studs, slots" and "Multipass milling"; TNC 426/430 for 3 to 5
and 230. The manual says that a pocket is cleared from the inside outwards by Q370 times the tool radius; the order
of the rings is the control's own; a remark states that they are read as rectangles (circles) one outside the other.

Cycle 262 ("Thread milling"): pre-positioning at Q253 to the starting plane, a
tangential way to the nominal diameter, one helix (Q355 = 0), one along the whole thread (1) or several (Q355 pitches apart), and
back to the middle. A remark states that the way in and out is half a circle at one height.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from vcmm.program.clearing import PathPiece, circle, rectangle, rows, shift_pieces
from vcmm.program.cutter import Flat
from vcmm.program.cycle_tables import Cycle, Values, cycle
from vcmm.program.drilling import depths_of, whole_count
from vcmm.program.heidenhain.machining import BlockwiseCycle, KlartextPrimitive, MachiningCycle, blockwise
from vcmm.program.moves import PLANES


def thread_milling(c: MachiningCycle, v: Values) -> None:
    """Run cycle 262: diameter Q335, pitch Q239 (negative: left-hand), depth Q201. Climb (Q351 = 1) inside is counter-clockwise: a right-hand
    thread rises then, and goes down in up-cut."""
    r, pitch = c.recorder, v["pitch"]
    if not pitch:
        r.fault(f"cycle {c.number} has no pitch Q239; add it")
    radius = max(v["diameter"] / 2.0 - c.radius(), 0.0)
    floor, counter = c.surface + v["depth"], round(v.without("climb", 1.0)) != -1
    rises = counter == (pitch > 0)
    r.assume(
        f"how cycle {c.number} leads in and out", "in half a circle at one height",
        f"how cycle {c.number} leads in is the control's own affair and not known; write its helix with CP", matters=True,
    )  # fmt: skip
    levels, turns = _levels(c, v, floor, abs(pitch))
    middle = c.here()
    c.to(None, None, c.clearance, True)
    for low in levels:
        first, last = (low, low + turns * abs(pitch)) if rises else (low + turns * abs(pitch), low)
        with c.feed_at(v["approach"], v["feed"]) as rapid:
            c.to(*middle, first, rapid)
        with c.feed_at(v["feed"]):
            c.cutter.thread(middle, radius, (first, last), abs(pitch), not counter)
    c.to(None, None, c.second, True)


def _levels(c: MachiningCycle, v: Values, floor: float, pitch: float) -> tuple[list[float], int]:
    """Return the lower ends of the helices, and their turns."""
    steps = v.number("turns")
    if steps == 0:
        return [floor], 1
    length = c.surface - floor
    if steps == 1:
        return [floor], max(1, whole_count(math.ceil(length / pitch - 1e-9)))
    count = max(1, whole_count(math.ceil(length / (steps * pitch) - 1e-9)))
    return [floor + k * steps * pitch for k in range(count)], 1


THREADS: Mapping[str, Cycle[KlartextPrimitive]] = {
    "262": cycle("Q335=diameter mm!, Q239=pitch mm!, Q201=depth mm!, Q355=turns count, Q253=approach feed, Q351=climb count?, Q200=clear mm!, Q203=surface mm!, Q204=second mm, Q207=feed feed!", thread_milling),
}  # fmt: skip


CORNERS = {
    0: (0.0, 0.0),
    1: (-1.0, -1.0),
    2: (1.0, -1.0),
    3: (1.0, 1.0),
    4: (-1.0, 1.0),
}  # Q367: where the tool stands


@dataclass(frozen=True)
class Clearing:
    """Heights, mm, and feeds, mm/min, of a pocket: over it, its floor, infeed; feed of the infeed and in the plane."""

    over: float
    surface: float
    floor: float
    step: float
    plunge: tuple[float, ...]
    feed: float
    leave: float


def _note_clearing(c: MachiningCycle) -> None:
    c.recorder.assume(
        f"how cycle {c.number} clears", "in rings from the inside outwards, in rows to and fro",
        f"how cycle {c.number} clears is the control's own affair and not known; write its motion with L and C",
    )  # fmt: skip


def clear(c: MachiningCycle, pieces: Sequence[PathPiece], data: Clearing) -> None:
    """Follow the pieces at each depth from the position of the tool, and return to it."""
    a, b = c.here()
    path = shift_pieces(pieces, (a, b))
    c.to(None, None, data.over, True)
    for depth in depths_of(data.surface, data.floor, data.step):
        with c.feed_at(*data.plunge):
            c.to(a, b, depth, False)
        with c.feed_at(data.feed):
            c.cutter.follow([*path, PathPiece((a, b))], depth)
    c.to(None, None, data.leave, True)


def _q_data(c: MachiningCycle, v: Values) -> Clearing:
    """Return the heights and feeds of 251 to 253. Q215 = 2 finishes only: to the depth at once where Q338 is zero."""
    floor = c.surface + v["depth"] + (v["floor_left"] if v.number("mode") == 1 else 0.0)
    step = v["finish_step"] if v.number("mode") == 2 else v["step"]
    step = step or c.surface - floor
    return Clearing(
        over=c.clearance, surface=c.surface, floor=floor, step=step, plunge=(v["plunge"],), feed=v["feed"], leave=c.second
    )  # fmt: skip


def _step(v: Values, radius: float) -> float:
    """Return Q370 times the tool radius; half the width at once where the tool is not known."""
    return (v["overlap"] or 1.0) * radius


def _way(v: Values) -> bool:
    """Return whether the way is clockwise: up-cut in a pocket with M3."""
    return round(v.without("climb", 1.0)) == -1


def _pocket(
    c: MachiningCycle, size: tuple[float, float], corner: float, turn: float, clockwise: bool, data: Clearing, step: float
) -> None:  # fmt: skip
    """Clear a rectangle about the position of the tool."""
    _note_clearing(c)
    clear(c, rectangle(size, step, corner, clockwise, turn), data)


def _to_middle(c: MachiningCycle, x: float, y: float, turn: float) -> None:
    """Move to the middle of the pocket: by (x, y), turned, from the place that Q367 names."""
    a, b = c.here()
    c.to(None, None, c.clearance, True)
    c.to(a + x * math.cos(turn) - y * math.sin(turn), b + x * math.sin(turn) + y * math.cos(turn), None, True)


def rectangular(c: MachiningCycle, v: Values) -> None:
    """Run cycle 251: length Q218, width Q219, corners Q220, turned by Q224."""
    radius, left = c.radius(), v["left"] if v.number("mode") == 1 else 0.0
    p, q = CORNERS.get(v.number("place"), (0.0, 0.0))
    _to_middle(c, -p * v["length"] / 2.0, -q * v["width"] / 2.0, v["turn"])
    size = (max(v["length"] / 2.0 - radius - left, 0.0), max(v["width"] / 2.0 - radius - left, 0.0))
    corner = max(v["corner"] - radius, 0.0)
    _pocket(c, size, corner, v["turn"], clockwise=_way(v), data=_q_data(c, v), step=_step(v, radius))


def circular(c: MachiningCycle, v: Values) -> None:
    """Run cycle 252: diameter Q223."""
    radius, left = c.radius(), v["left"] if v.number("mode") == 1 else 0.0
    _note_clearing(c)
    clear(c, circle(max(v["diameter"] / 2.0 - radius - left, 0.0), _step(v, radius), _way(v)), _q_data(c, v))


def slot(c: MachiningCycle, v: Values) -> None:
    """Run cycle 253: length Q218, width Q219, turned by Q374; Q367: middle, ends."""
    radius, length, width = c.radius(), v["length"], v["width"]
    along = {0: 0.0, 1: 0.5, 2: 0.5 - width / 2 / length, 3: width / 2 / length - 0.5, 4: -0.5}
    _to_middle(c, along.get(v.number("place"), 0.0) * length if length else 0.0, 0.0, v["turn"])
    size = (max(length / 2.0 - radius, 0.0), max(width / 2.0 - radius, 0.0))
    _pocket(c, size, size[1], v["turn"], clockwise=_way(v), data=_q_data(c, v), step=_step(v, radius))


# -- 3, 4, 5: from the position of the tool --------------------------------------------------------------------------------
def _old_data(c: MachiningCycle, v: Values) -> Clearing:
    start = c.recorder.p[PLANES[c.recorder.plane][2]]
    surface = start - v["DIST"]
    floor = surface - v["DEPTH"]
    step = v["PECKG"] or surface - floor
    return Clearing(
        over=start, surface=surface, floor=floor, step=step, plunge=(v["PLUNGE"], v["F"]), feed=v["F"], leave=start
    )  # fmt: skip


def old_pocket(c: MachiningCycle, v: Values) -> None:
    """Run cycle 4: X by Y about the position of the tool, corners RADIUS."""
    radius = c.radius()
    size = (max(v["X"] / 2.0 - radius, 0.0), max(v["Y"] / 2.0 - radius, 0.0))
    _pocket(c, size, max(v["RADIUS"] - radius, 0.0), 0.0, clockwise=False, data=_old_data(c, v), step=radius)


def old_circle(c: MachiningCycle, v: Values) -> None:
    """Run cycle 5: RADIUS about the position of the tool."""
    radius = c.radius()
    _note_clearing(c)
    clear(c, circle(max(v["RADIUS"] - radius, 0.0), radius, v["DR"] < 0), _old_data(c, v))


def old_slot(c: MachiningCycle, v: Values) -> None:
    """Run cycle 3: from the position of the tool, at one end of the slot, along the longer of X and Y and back."""
    x, y, r = v["X"], v["Y"], c.radius()
    long = 0 if abs(x) >= abs(y) else 1
    length = (x, y)[long]
    size = math.copysign(max(abs(length) - 2.0 * r, 0.0), length)
    end = (size, 0.0) if long == 0 else (0.0, size)
    _note_clearing(c)
    clear(c, [PathPiece(end)], _old_data(c, v))


# -- faces --------------------------------------------------------------------------------------------------------------
def multipass(c: MachiningCycle, v: Values) -> None:
    """Run cycle 230: Q240 rows from Q225, Q226 at Q227, each Q218 long, over Q219; Q206 down, Q207 along, Q209 across."""
    level, count = v["top"], whole_count(v["rows"])
    ends = rows((v["x"], v["y"]), (v["length"], v["width"]), count)
    c.to(None, None, level + v["clear"], True)
    c.to(*ends[0], None, True)
    with c.feed_at(v["plunge"]):
        c.to(None, None, level, False)
    _along(c, ends, (v["feed"],), (v["across"], v["feed"]))
    c.to(None, None, level + v["clear"], True)


def _along(
    c: MachiningCycle, ends: Sequence[Flat], feed: tuple[float, ...], across: tuple[float, ...]
) -> None:
    """Make rows at one feed, from row to row at another."""
    for k, end in enumerate(ends[1:]):
        with c.feed_at(*(feed if k % 2 == 0 else across)) as rapid:
            c.to(*end, None, rapid)


def face(c: MachiningCycle, v: Values) -> None:
    """Run cycle 232: from Q227 to Q386 by Q202 at most; rows Q370 of the tool diameter apart at most, Q357 beside the face at their ends."""
    radius = c.radius()
    long, wide, side = v["length"], v["width"], v["beside"] + radius
    count = max(1, math.ceil(abs(wide) / max((v["overlap"] or 1.0) * 2.0 * radius, 1e-9))) if radius else 2
    top, floor = v["top"], v["floor"] + v["floor_left"]
    sign = math.copysign(1.0, long)
    ends = rows((v["x"] - sign * side, v["y"]), (long + 2 * sign * side, wide), count + 1)
    if v.number("way") not in (0, 1, 2):
        c.recorder.remark("cycle 232 with a spiral (Q389 = 3, 4) is read as rows to and fro")
    _note_clearing(c)
    levels = depths_of(top, floor, v["step"] or top - floor)
    for depth in levels:
        c.to(None, None, max(top, depth) + v["clear"], True)
        c.to(*ends[0], None, True)
        with c.feed_at(v["approach"]) as rapid:
            c.to(None, None, depth, rapid)
        _along(c, ends, (v["feed"],), (v["approach"], v["feed"]))
    c.to(None, None, top + max(v["clear"], v["second"]), True)


_DEPTHS = "Q351=climb count?, Q201=depth mm!, Q202=step mm!, Q369=floor_left mm, Q206=plunge feed!, Q338=finish_step mm, Q200=clear mm!, Q203=surface mm!, Q204=second mm, Q370=overlap plain"
_FACE = "Q225=x mm!, Q226=y mm!, Q227=top mm!"
POCKETS: Mapping[str, Cycle[KlartextPrimitive]] = {
    "230": cycle(f"{_FACE}, Q218=length mm!, Q219=width mm!, Q240=rows count!, Q206=plunge feed!, Q207=feed feed!, Q209=across feed, Q200=clear mm", multipass),
    "232": cycle(f"Q389=way count, {_FACE}, Q386=floor mm!, Q218=length mm!, Q219=width mm!, Q202=step mm!, Q369=floor_left mm, Q370=overlap plain, Q207=feed feed!, Q253=approach feed, Q200=clear mm, Q357=beside mm, Q204=second mm", face),
    "251": cycle(f"Q215=mode count, Q218=length mm!, Q219=width mm!, Q220=corner mm, Q368=left mm, Q224=turn deg, Q367=place count, Q207=feed feed!, {_DEPTHS}", rectangular),
    "252": cycle(f"Q215=mode count, Q223=diameter mm!, Q368=left mm, Q207=feed feed!, {_DEPTHS}", circular),
    "253": cycle(f"Q215=mode count, Q218=length mm!, Q219=width mm!, Q368=left mm, Q374=turn deg, Q367=place count, Q207=feed feed!, {_DEPTHS}", slot),
}  # fmt: skip
_DOWN = "DIST size; DEPTH size; PECKG size, PLUNGE feed"
OLD_POCKETS: Mapping[str, BlockwiseCycle] = {
    "3": blockwise(f"{_DOWN}; X mm; Y mm; F feed", old_slot),
    "4": blockwise(f"{_DOWN}; X size; Y size; F feed, RADIUS mm | DR plain", old_pocket),
    "5": blockwise(f"{_DOWN}; RADIUS size; F feed | DR plain", old_circle),
}
