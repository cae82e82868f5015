"""Milling cycles of Klartext: pockets and slots (3 to 5, 251 to 253), rows over a face (230, 232).

Source: HEIDENHAIN, TNC 640 User's Manual Cycle Programming, "Pockets, studs, slots" and "Multipass milling"; TNC 426/430 for 3 to 5
and 230. The manual says that a pocket is cleared from the inside outwards by Q370 times the tool radius; how the rings follow
one another is the control's own, and that they are taken as rectangles (circles) one outside the other is told.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass

from vcmm.program.clearing import PathPiece, circle, rectangle, rows, shift_pieces
from vcmm.program.drilling import depths_of, whole_count
from vcmm.program.heidenhain.machining import Action, MachiningCycle
from vcmm.program.moves import PLANES

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
    plunge: float
    feed: float
    leave: float


def _note_clearing(c: MachiningCycle) -> None:
    c.recorder.assume(
        f"how cycle {c.number} clears", "in rings from the inside outwards, in rows to and fro",
        f"how cycle {c.number} clears is the control's own affair and not known; write its motion with L and C",
    )  # fmt: skip


def clear(c: MachiningCycle, pieces: Sequence[PathPiece], data: Clearing) -> None:
    """The pieces at each depth from where the tool stands, which it comes back to."""
    a, b = c.here()
    path = shift_pieces(pieces, (a, b))
    c.to(None, None, data.over, True)
    for depth in depths_of(data.surface, data.floor, data.step):
        with c.feed_at(data.plunge):
            c.to(a, b, depth, False)
        with c.feed_at(data.feed):
            c.cutter.follow([*path, PathPiece((a, b))], depth)
    c.to(None, None, data.leave, True)


def _q_data(c: MachiningCycle) -> Clearing:
    """Heights and feeds of 251 to 253. Q215 = 2 finishes only: to the depth at once where Q338 is zero."""
    floor = c.surface + c.mm("Q201") + (c.mm("Q369") if round(c.plain("Q215")) == 1 else 0.0)
    step = c.mm("Q338") if round(c.plain("Q215")) == 2 else c.mm("Q202")
    step = step or c.surface - floor
    return Clearing(
        over=c.clearance, surface=c.surface, floor=floor, step=step, plunge=c.feed("Q206"), feed=c.feed("Q207"), leave=c.second
    )  # fmt: skip


def _step(c: MachiningCycle, radius: float) -> float:
    """Q370 times the tool radius; half the width at once where the tool is not known."""
    return (c.plain("Q370", 1.0) or 1.0) * radius


def _way(c: MachiningCycle) -> bool:
    """Clockwise: up-cut in a pocket with M3."""
    return round(c.plain("Q351", 1.0)) == -1


def _pocket(
    c: MachiningCycle, size: tuple[float, float], corner: float, turn: float, data: Clearing, step: float
) -> None:
    """A rectangle about where the tool stands."""
    _note_clearing(c)
    clear(c, rectangle(size, step, corner, _way(c), math.radians(turn)), data)


def _to_middle(c: MachiningCycle, length: float, width: float, turn: float) -> None:
    """From the corner that Q367 names to the middle."""
    p, q = CORNERS.get(round(c.plain("Q367")), (0.0, 0.0))
    x, y = -p * length / 2.0, -q * width / 2.0
    w = math.radians(turn)
    a, b = c.here()
    c.to(None, None, c.clearance, True)
    c.to(a + x * math.cos(w) - y * math.sin(w), b + x * math.sin(w) + y * math.cos(w), None, True)


def rectangular(c: MachiningCycle) -> None:
    """251: length Q218, width Q219, corners Q220, turned by Q224."""
    radius, left = c.radius(), c.mm("Q368") if round(c.plain("Q215")) == 1 else 0.0
    length, width, turn = c.mm("Q218"), c.mm("Q219"), c.plain("Q224")
    _to_middle(c, length, width, turn)
    size = (max(length / 2.0 - radius - left, 0.0), max(width / 2.0 - radius - left, 0.0))
    _pocket(c, size, max(c.mm("Q220") - radius, 0.0), turn, _q_data(c), _step(c, radius))


def circular(c: MachiningCycle) -> None:
    """252: diameter Q223."""
    radius, left = c.radius(), c.mm("Q368") if round(c.plain("Q215")) == 1 else 0.0
    _note_clearing(c)
    clear(c, circle(max(c.mm("Q223") / 2.0 - radius - left, 0.0), _step(c, radius), _way(c)), _q_data(c))


def slot(c: MachiningCycle) -> None:
    """253: length Q218, width Q219, turned by Q374; Q367: middle, ends."""
    radius, turn = c.radius(), c.plain("Q374")
    length, width = c.mm("Q218"), c.mm("Q219")
    along = {0: 0.0, 1: 0.5, 2: 0.5 - width / 2 / length, 3: width / 2 / length - 0.5, 4: -0.5}
    shift = along.get(round(c.plain("Q367")), 0.0) * length if length else 0.0
    a, b = c.here()
    w = math.radians(turn)
    c.to(None, None, c.clearance, True)
    c.to(a + shift * math.cos(w), b + shift * math.sin(w), None, True)
    size = (max(length / 2.0 - radius, 0.0), max(width / 2.0 - radius, 0.0))
    _pocket(c, size, size[1], turn, _q_data(c), _step(c, radius))


# -- 3, 4, 5: from where the tool stands --------------------------------------------------------------------------------
def _old_data(c: MachiningCycle) -> Clearing:
    start = c.recorder.p[PLANES[c.recorder.plane][2]]
    surface = start - abs(c.mm("DIST"))
    floor = surface - abs(c.mm("DEPTH"))
    step = abs(c.mm("PECKG")) or surface - floor
    return Clearing(
        over=start, surface=surface, floor=floor, step=step, plunge=c.feed("PLUNGE", "F"), feed=c.feed("F"), leave=start
    )  # fmt: skip


def old_pocket(c: MachiningCycle) -> None:
    """4: X by Y about where the tool stands, corners RADIUS."""
    radius = c.radius()
    size = (max(abs(c.mm("X")) / 2.0 - radius, 0.0), max(abs(c.mm("Y")) / 2.0 - radius, 0.0))
    _pocket(c, size, max(c.mm("RADIUS") - radius, 0.0), 0.0, _old_data(c), radius)


def old_circle(c: MachiningCycle) -> None:
    """5: RADIUS about where the tool stands."""
    radius = c.radius()
    _note_clearing(c)
    clear(c, circle(max(abs(c.mm("RADIUS")) - radius, 0.0), radius, c.plain("DR") < 0), _old_data(c))


def old_slot(c: MachiningCycle) -> None:
    """3: from where the tool stands, at one end of the slot, along the longer of X and Y and back."""
    x, y, r = c.mm("X"), c.mm("Y"), c.radius()
    long = 0 if abs(x) >= abs(y) else 1
    length = (x, y)[long]
    size = math.copysign(max(abs(length) - 2.0 * r, 0.0), length)
    end = (size, 0.0) if long == 0 else (0.0, size)
    _note_clearing(c)
    clear(c, [PathPiece(end)], _old_data(c))


# -- faces --------------------------------------------------------------------------------------------------------------
def multipass(c: MachiningCycle) -> None:
    """230: Q240 rows from Q225, Q226 at Q227, each Q218 long, over Q219; Q206 down, Q207 along, Q209 across."""
    level, count = c.mm("Q227"), whole_count(c.plain("Q240", 2.0))
    ends = rows((c.mm("Q225"), c.mm("Q226")), (c.mm("Q218"), c.mm("Q219")), count)
    c.to(None, None, level + c.mm("Q200"), True)
    c.to(*ends[0], None, True)
    with c.feed_at(c.feed("Q206")):
        c.to(None, None, level, False)
    _along(c, ends, c.feed("Q207"), c.feed("Q209", "Q207"))
    c.to(None, None, level + c.mm("Q200"), True)


def _along(c: MachiningCycle, ends: Sequence[tuple[float, float]], feed: float, across: float) -> None:
    """Rows at one feed, from row to row at another."""
    for k, end in enumerate(ends[1:]):
        with c.feed_at(feed if k % 2 == 0 else across) as rapid:
            c.to(*end, None, rapid)


def face(c: MachiningCycle) -> None:
    """232: from Q227 to Q386 by Q202 at most; rows Q370 of the tool diameter apart at most, Q357 beside the face at their ends."""
    radius = c.radius()
    long, wide, side = c.mm("Q218"), c.mm("Q219"), c.mm("Q357") + radius
    count = (
        max(1, math.ceil(abs(wide) / max((c.plain("Q370", 1.0) or 1.0) * 2.0 * radius, 1e-9)))
        if radius
        else 2
    )
    top, floor = c.mm("Q227"), c.mm("Q386") + c.mm("Q369")
    sign = math.copysign(1.0, long)
    ends = rows((c.mm("Q225") - sign * side, c.mm("Q226")), (long + 2 * sign * side, wide), count + 1)
    if round(c.plain("Q389")) not in (0, 1, 2):
        c.recorder.remark("cycle 232 with a spiral (Q389 = 3, 4) is read as rows to and fro")
    _note_clearing(c)
    levels = depths_of(top, floor, c.mm("Q202") or top - floor)
    for depth in levels:
        c.to(None, None, max(top, depth) + c.mm("Q200"), True)
        c.to(*ends[0], None, True)
        with c.feed_at(c.feed("Q253")) as rapid:
            c.to(None, None, depth, rapid)
        _along(c, ends, c.feed("Q207"), c.feed("Q253", "Q207"))
    c.to(None, None, top + max(c.mm("Q200"), c.mm("Q204")), True)


POCKETS: Mapping[str, tuple[tuple[str, ...], Action]] = {
    "230": (("Q225", "Q226", "Q227", "Q218", "Q219", "Q240", "Q206", "Q207"), multipass),
    "232": (("Q225", "Q226", "Q227", "Q386", "Q218", "Q219", "Q202", "Q207"), face),
    "251": (("Q218", "Q219", "Q207", "Q201", "Q202", "Q206", "Q200", "Q203"), rectangular),
    "252": (("Q223", "Q207", "Q201", "Q202", "Q206", "Q200", "Q203"), circular),
    "253": (("Q218", "Q219", "Q207", "Q201", "Q202", "Q206", "Q200", "Q203"), slot),
}  # fmt: skip
OLD_POCKETS: Mapping[str, Action] = {"3": old_slot, "4": old_pocket, "5": old_circle}
