"""Turning cycles without a contour: G74 and G75 (pecking along Z and X), G76 (threads), G90, G92, G94 (one cut, one thread, one face).

Source: FANUC Series 30i operator's manual for lathes B-64304EN-1, "canned cycle" and "multiple repetitive cycle"; Haas lathe
operator's manual for the forms in one block. X is a radius, machine coordinates, mm.
"""

from __future__ import annotations

import math
from collections.abc import Callable

from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import IsoControl
from vcmm.program.iso.lengths import length
from vcmm.program.iso.motion import target

MOST_PECKS = 100_000
SINGLE = {"G90": "turn", "G92": "thread", "G94": "face", "G77": "turn", "G78": "thread", "G79": "face"}
Flat = tuple[float, float]  # X (radius), Z


def to_tip(c: IsoControl, end: Flat, rapid: bool) -> None:
    """Straight to (X, Z) in machine coordinates; nothing where the tool is there."""
    start = c.tip()
    goal = (end[0], start[1], end[1])
    if math.dist(start, goal) < 1e-12:
        return
    feed = None if rapid else c.line_feed(start, goal, c.rotary)
    c.emit("rapid" if rapid else "line", goal, feed=feed)
    c.locate()


def thread_tip(c: IsoControl, end: Flat, lead: float) -> None:
    """A thread to (X, Z) in machine coordinates."""
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
    """Where the tool stands, and the point that the words X Z U W name, machine coordinates."""
    p, _ = target(c, w)
    end = c.world.apply(p)
    return (c.tip()[0], c.tip()[2]), (end[0], end[2])


def _word(c: IsoControl, w: IsoWords, letter: str) -> float:
    number = w.take(letter)
    return 0.0 if number is None else length(c, w, letter, number)


def _steps(c: IsoControl, w: IsoWords, letter: str) -> float:
    """A word that counts increments where it has no point: P and Q of G74 to G76."""
    number = w.take(letter)
    if number is None:
        return 0.0
    small = 1.0 if w.words[letter].has_point else c.language.increment[1 if c.unit > 1.0 else 0]
    return number * small * c.unit


# -- one cut ----------------------------------------------------------------------------------------------------------
def single_cut(c: IsoControl, w: IsoWords, code: str, lead: float) -> None:
    """G90, G92, G94: there, along, back. The words stay in force; R is how much the start of the cut lies beside its end."""
    start, _ = _ends(c, w)
    p, _ = target_kept(c, w)
    corner = c.world.apply(p)
    x, z = corner[0], corner[2]
    if w.has("R"):
        c.cycle["R"] = _word(c, w, "R")
    taper, kind = c.cycle.get("R", 0.0), SINGLE[code]
    if kind == "face":
        to_tip(c, (start[0], z + taper), True)
        to_tip(c, (x, z), False)
        to_tip(c, (x, start[1]), False)
    else:
        to_tip(c, (x + taper, start[1]), True)
        if kind == "thread":
            thread_tip(c, (x, z), lead)
        else:
            to_tip(c, (x, z), False)
        to_tip(c, (start[0], z), kind == "thread")
    to_tip(c, start, True)


def target_kept(c: IsoControl, w: IsoWords) -> tuple[tuple[float, float, float], None]:
    """The corner of the cut, programmed coordinates: words that are absent count as in the block before."""
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
def _peck(c: IsoControl, w: IsoWords, code: str) -> None:
    """G74: pecks along Z, at X from the start to the end; G75: pecks along X. R of a block of its own: how far back after a peck."""
    if not any(w.has(k) for k in "XZUW"):
        c.turning_words = {"R": _word(c, w, "R")}
        return
    back = c.turning_words.get("R", 0.0)
    start, end = _ends(c, w)
    along, across = (1, 0) if code == "G74" else (0, 1)
    one_block = w.has("I") or w.has("K")
    across_word, along_word = (
        (("I", "K") if code == "G74" else ("K", "I"))
        if one_block
        else (("P", "Q") if code == "G74" else ("Q", "P"))
    )
    read = _word if one_block else _steps
    step, peck, aside = abs(read(c, w, across_word)), abs(read(c, w, along_word)), _word(c, w, "R")
    w.used |= {"P", "Q", "I", "K", "D", "R"}
    for at in _places(c, start[across], end[across], step):
        _plunge(c, _pair(along, start[along], at), end[along], along, peck, back)
        if aside:
            to_tip(c, _pair(along, end[along], at - math.copysign(aside, end[across] - start[across])), False)
        to_tip(c, _pair(along, start[along], (c.tip()[0], c.tip()[2])[across]), True)
    to_tip(c, start, True)


def _pair(along: int, one: float, other: float) -> Flat:
    return (other, one) if along == 1 else (one, other)


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
def _g76(c: IsoControl, w: IsoWords, code: str) -> None:
    """Two blocks: P (finishing passes, chamfer, angle), Q least depth, R allowance; then X Z, R taper, P height, Q first depth, F lead.
    One block (Haas): K height, D first depth, A angle, I taper."""
    if not any(w.has(k) for k in "XZUW"):
        digits = f"{w.whole('P', c.column) or 0:06d}"
        c.turning_words = {
            "passes": float(digits[:2]), "angle": float(digits[4:6]), "least": _steps(c, w, "Q"), "allowance": _word(c, w, "R"),
        }  # fmt: skip
        return
    start, end = _ends(c, w)
    kept = c.turning_words
    if w.has("K"):
        height, first, taper = _word(c, w, "K"), _word(c, w, "D"), _word(c, w, "I")
        angle = w.take("A") or 0.0
        w.used.add("P")
    else:
        height, first, taper = _steps(c, w, "P"), _steps(c, w, "Q"), _word(c, w, "R")
        angle = kept.get("angle", 0.0)
    lead = _word(c, w, "F") or _word(c, w, "E")
    if height <= 0 or first <= 0:
        raise BlockFault(
            c.column, "G76 needs the height of the thread (P or K) and the depth of the first pass (Q or D)"
        )
    side = 1.0 if end[0] < start[0] else -1.0
    slope = math.tan(math.radians(angle) / 2.0) * math.copysign(1.0, end[1] - start[1])
    for depth in _thread_depths(c, height, first, kept):
        x, z = end[0] + side * (height - depth), start[1] + slope * depth
        to_tip(c, (start[0], z), True)
        to_tip(c, (x + taper, z), True)
        thread_tip(c, (x, end[1]), lead)
        to_tip(c, (start[0], end[1]), True)
        to_tip(c, start, True)


def _thread_depths(c: IsoControl, height: float, first: float, kept: dict[str, float]) -> list[float]:
    """Depths of the passes: first sqrt(n), at least `least` more each, to the height less the allowance, then the finishing ones."""
    least, allowance = kept.get("least", 0.0), kept.get("allowance", 0.0)
    out, depth, n = [], 0.0, 0
    while depth < height - allowance - 1e-9:
        n += 1
        depth = min(max(first * math.sqrt(n), depth + least), height - allowance)
        out.append(depth)
        if n > MOST_PECKS:
            raise BlockFault(
                c.column, f"G76 needs more than {MOST_PECKS} passes; make the first depth larger"
            )
    finishing = max(int(kept.get("passes", 0.0)), 1 if allowance else 0)
    return [*out, *[height] * finishing]


GROOVING: dict[str, Callable[[IsoControl, IsoWords], None]] = {
    "G74": lambda c, w: _peck(c, w, "G74"), "G75": lambda c, w: _peck(c, w, "G75"), "G76": lambda c, w: _g76(c, w, "G76"),
}  # fmt: skip
