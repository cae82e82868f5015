"""Turning cycles without a contour: G74 and G75 (pecking along Z and X), G76 (threads), G90, G92, G94 (one cut, one thread, one face).

Source: FANUC Series 30i operator's manual for lathes B-64304EN-1, "canned cycle" and "multiple repetitive cycle"; Haas lathe
operator's manual for the forms in one block. X is a radius, machine coordinates, mm.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping
from functools import partial
from typing import NamedTuple

from vcmm.program.cycle_tables import Cycle, Values, cycle
from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import IsoControl
from vcmm.program.iso.lengths import length, read_words
from vcmm.program.iso.motion import target
from vcmm.program.iso.settings import keep_setting, setting_kept, tell_pull_out, tell_return

MOST_PECKS = 100_000
Flat = tuple[float, float]  # X (radius), Z
TurningPrimitive = Callable[[IsoControl, IsoWords, Values], None]


def to_tip(c: IsoControl, end: Flat, rapid: bool) -> None:
    """Move straight to (X, Z) in machine coordinates; nothing where the tool is there."""
    start = c.tip()
    goal = (end[0], start[1], end[1])
    if math.dist(start, goal) < 1e-12:
        return
    feed = None if rapid else c.line_feed(start, goal, c.rotary)
    c.emit("rapid" if rapid else "line", goal, feed=feed)
    c.locate()


def thread_tip(c: IsoControl, end: Flat, lead: float) -> None:
    """Cut a thread to (X, Z) in machine coordinates."""
    start = c.tip()
    goal = (end[0], start[1], end[1])
    turns = c.feeding((start[0] + end[0]) / 2.0 - c.world.shift[0])
    if not turns or not c.sense:
        c.assume(
            "the spindle speed",
            "not known; feeds per turn are not counted",
            "threads need a turning spindle; add S and M3 or M4 before this block",
        )
    if lead <= 0:
        c.fault("the lead of a thread must be positive; correct it")
    c.emit("thread", goal, feed=lead * turns or None)
    c.locate()


def _ends(c: IsoControl, w: IsoWords) -> tuple[Flat, Flat]:
    """Return the position of the tool, and the point of the words X Z U W, machine coordinates."""
    p, _ = target(c, w)
    end = c.world.apply(p)
    return (c.tip()[0], c.tip()[2]), (end[0], end[2])


# -- one cut ----------------------------------------------------------------------------------------------------------
def single_cut(c: IsoControl, w: IsoWords, code: str, lead: float) -> None:
    """Run G90, G92, G94 (G77 to G79): there, along, back. The words stay in force; R is the distance of the start of the cut beside its end."""
    start, _ = _ends(c, w)
    p, _ = target_kept(c, w)
    corner = c.world.apply(p)
    given = read_words(c, w, SINGLE[code])
    if given.has("taper"):
        c.cycle["R"] = given["taper"]
    if code in THREADED:
        tell_pull_out(c, code, None)
    v = Values({"taper": c.cycle.get("R", 0.0), "lead": lead})
    SINGLE[code].primitive(c, start, (corner[0], corner[2]), v)
    to_tip(c, start, True)


def turn(c: IsoControl, start: Flat, corner: Flat, v: Values) -> None:
    """Cut once along: down to X, along at feed, out at feed."""
    to_tip(c, (corner[0] + v["taper"], start[1]), True)
    to_tip(c, corner, False)
    to_tip(c, (start[0], corner[1]), False)


def screw(c: IsoControl, start: Flat, corner: Flat, v: Values) -> None:
    """Cut one pass of a thread: down to X, along as a thread, out at rapid."""
    to_tip(c, (corner[0] + v["taper"], start[1]), True)
    thread_tip(c, corner, v["lead"])
    to_tip(c, (start[0], corner[1]), True)


def face(c: IsoControl, start: Flat, corner: Flat, v: Values) -> None:
    """Face once: to Z, across at feed, back at feed."""
    to_tip(c, (start[0], corner[1] + v["taper"]), True)
    to_tip(c, corner, False)
    to_tip(c, (corner[0], start[1]), False)


def target_kept(c: IsoControl, w: IsoWords) -> tuple[tuple[float, float, float], None]:
    """Return the corner of the cut, programmed coordinates: words that are absent count as in the block before."""
    p = list(c.p)
    for i, (absolute, added) in enumerate((("X", "U"), ("Y", "V"), ("Z", "W"))):
        half = 0.5 if i == 0 and c.diametral() else 1.0
        if w.has(absolute):
            value = length(c, w, absolute, w.values[absolute]) * half
            p[i] = c.cycle[absolute] = value if c.absolute else c.p[i] + value
        elif w.has(added):
            p[i] = c.cycle[absolute] = c.p[i] + length(c, w, added, w.values[added]) * half
        elif absolute in c.cycle:
            p[i] = c.cycle[absolute]
    return (p[0], p[1], p[2]), None


# -- pecking ----------------------------------------------------------------------------------------------------------
def peck(c: IsoControl, w: IsoWords, v: Values, along: int) -> None:
    """Run G74: pecks along Z (1), at X from the start to the end; G75: pecks along X (0). The first block has the distance back after a peck."""
    start, end = _ends(c, w)
    across = 1 - along
    code = "G74" if along == 1 else "G75"
    setting = setting_kept(c, code)
    if "back" not in setting and 0 < abs(v["along"]) < abs(end[along] - start[along]):
        tell_return(c, code)
    for at in _places(c, start[across], end[across], abs(v["across"])):
        _plunge(
            c,
            _pair(along, start[along], at),
            end[along],
            along,
            abs(v["along"]),
            setting.get("back", 0.0),
        )
        if v["aside"]:
            aside = at - math.copysign(v["aside"], end[across] - start[across])
            to_tip(c, _pair(along, end[along], aside), False)
        to_tip(c, _pair(along, start[along], (c.tip()[0], c.tip()[2])[across]), True)
    to_tip(c, start, True)


def _pair(along: int, first: float, other: float) -> Flat:
    return (other, first) if along == 1 else (first, other)


def _places(c: IsoControl, first: float, last: float, step: float) -> list[float]:
    if abs(last - first) < 1e-9:
        return [first]
    if step <= 0:
        return [first, last]
    count = math.ceil(abs(last - first) / step - 1e-9)
    if count > MOST_PECKS:
        raise BlockFault(c.column, f"more than {MOST_PECKS} grooves; make the step larger")
    sign = math.copysign(step, last - first)
    return [*(first + sign * k for k in range(count)), last]


def _plunge(c: IsoControl, start: Flat, end: float, along: int, peck: float, back: float) -> None:
    to_tip(c, start, True)
    other, at = start[1 - along], start[along]
    depths = _places(c, at, end, peck)[1:] if peck > 0 else [end]
    for depth in depths:
        to_tip(c, _pair(along, depth, other), False)
        if back and depth != depths[-1]:
            to_tip(c, _pair(along, depth - math.copysign(min(back, abs(depth - at)), end - at), other), True)


# -- threads ----------------------------------------------------------------------------------------------------------
def thread(c: IsoControl, w: IsoWords, v: Values) -> None:
    """Cut a thread: the first block has the number of finishing passes, the angle, the least depth of a pass and the allowance."""
    setting, (start, end) = Values(setting_kept(c, "G76")), _ends(c, w)
    digits = f"{setting.number('digits'):06d}"  # passes, chamfer, angle
    tell_pull_out(c, "G76", int(digits[2:4]) / 10.0 if setting.has("digits") else None)
    angle = v.without("angle", float(digits[4:6]))
    height, first = v["height"], v["first"]
    if height <= 0 or first <= 0:
        raise BlockFault(
            c.column, "G76 needs the height of the thread (P or K) and the depth of the first pass (Q or D)"
        )
    side = 1.0 if end[0] < start[0] else -1.0
    slope = math.tan(math.radians(angle) / 2.0) * math.copysign(1.0, end[1] - start[1])
    for depth in _thread_depths(c, height, first, setting, int(digits[:2])):
        x, z = end[0] + side * (height - depth), start[1] + slope * depth
        to_tip(c, (start[0], z), True)
        to_tip(c, (x + v["taper"], z), True)
        thread_tip(c, (x, end[1]), v["lead"])
        to_tip(c, (start[0], end[1]), True)
        to_tip(c, start, True)


def _thread_depths(c: IsoControl, height: float, first: float, setting: Values, last: int) -> list[float]:
    """Return the depths of the passes: first sqrt(n), at least `least` more each, to the height less the allowance, then `last` ones."""
    least, allowance = setting["least"], setting["allowance"]
    out, depth, n = [], 0.0, 0
    while depth < height - allowance - 1e-9:
        n += 1
        depth = min(max(first * math.sqrt(n), depth + least), height - allowance)
        out.append(depth)
        if n > MOST_PECKS:
            raise BlockFault(
                c.column, f"G76 needs more than {MOST_PECKS} passes; make the first depth larger"
            )
    return [*out, *[height] * max(last, 1 if allowance else 0)]


class TurningCycle(NamedTuple):
    """A cycle in two blocks, the first of which is kept, or in one (which one of the words `key` tells)."""

    first: Cycle[None]
    second: Cycle[TurningPrimitive | None]
    single: Cycle[TurningPrimitive | None]
    key: str = ""


def groove(c: IsoControl, w: IsoWords, code: str) -> None:
    """Execute a block with one of these cycles."""
    row = GROOVING[code]
    if not any(w.has(k) for k in "XZUW"):
        keep_setting(c, code, dict(read_words(c, w, row.first).numbers))
        return
    form = row.single if any(w.has(k) for k in row.key) else row.second
    assert form.primitive is not None
    form.primitive(c, w, read_words(c, w, form))


_TAPER = "R=taper mm?"
SINGLE: Mapping[str, Cycle[Callable[[IsoControl, Flat, Flat, Values], None]]] = {  # X Z U W stay in force; F is the lead of a thread
    "G90": cycle(_TAPER, turn), "G92": cycle(_TAPER, screw), "G94": cycle(_TAPER, face),
    "G77": cycle(_TAPER, turn), "G78": cycle(_TAPER, screw), "G79": cycle(_TAPER, face),
}  # fmt: skip
THREADED = ("G92", "G78")
_Z, _X = partial(peck, along=1), partial(peck, along=0)
_ASIDE = "R=aside mm, D plain"  # D: nothing here
GROOVING: Mapping[str, TurningCycle] = {
    "G74": TurningCycle(cycle("R=back mm?", None), cycle(f"P=across steps, Q=along steps, {_ASIDE}", _Z), cycle(f"I=across mm, K=along mm, {_ASIDE}, P plain, Q plain", _Z), "IK"),
    "G75": TurningCycle(cycle("R=back mm?", None), cycle(f"Q=across steps, P=along steps, {_ASIDE}", _X), cycle(f"K=across mm, I=along mm, {_ASIDE}, P plain, Q plain", _X), "IK"),
    "G76": TurningCycle(
        cycle("P=digits count?, Q=least steps?, R=allowance mm?", None),
        cycle("P=height steps, Q=first steps, R=taper mm, E=lead mm, F=lead mm", thread),
        cycle("K=height mm, D=first mm, I=taper mm, A=angle plain, P plain, E=lead mm, F=lead mm", thread), "K",
    ),
}  # fmt: skip
