"""Drilling, tapping and boring cycles G73, G74, G76, G81 to G89, in the three planes, expanded into single moves.

A series: R and the depth stay in force until another motion code; each block with an axis word makes L (K) holes. The
initial level is the height at which the series began; G98 goes back to it (or to R where that is higher), G99 to R. With
G91 R counts from the initial level and the depth from R.
"""

from __future__ import annotations

from vcmm.nc.control import AXES, Control
from vcmm.nc.faults import BlockFault
from vcmm.nc.iso.codes import Words
from vcmm.nc.iso.motion import CENTRE_WORDS, dwell, length, line, thread_to
from vcmm.nc.moves import PLANES

CYCLES = ("G73", "G74", "G76", "G81", "G82", "G83", "G84", "G85", "G86", "G87", "G88", "G89")
_STICKY = {"G73": "Q", "G83": "Q", "G82": "P", "G89": "P", "G86": "P", "G88": "P", "G76": "Q"}
_MOST_PECKS = 20_000


class Hole:
    """One hole: heights and the moves along the axis of the tool."""

    def __init__(self, c: Control, w: Words, column: int, r: float, bottom: float, clear: float) -> None:
        self.c, self.w, self.column = c, w, column
        self.r, self.bottom, self.clear = r, bottom, clear
        self.first, self.second, self.normal = PLANES[c.plane]

    def to(self, height: float, rapid: bool) -> None:
        """Along the axis of the tool."""
        if abs(self.c.p[self.normal] - height) < 1e-12:
            return
        p = list(self.c.p)
        p[self.normal] = height
        line(self.c, self.w, p, self.c.rotary, rapid, self.column)

    def across(self, a: float, b: float) -> None:
        """Rapid in the plane."""
        p = list(self.c.p)
        p[self.first], p[self.second] = a, b
        if p != self.c.p:
            line(self.c, self.w, p, self.c.rotary, True, self.column)

    def wait(self, name: str = "P") -> None:
        seconds = self.c.cycle.get(name, 0.0) * self.c.dialect.dwell
        if seconds:
            dwell(self.c, seconds, self.column)


def drill(c: Control, w: Words, code: str, column: int) -> None:
    """A block in which a cycle is in force."""
    if c.compensation is not None:
        raise BlockFault(column, f"{code} while cutter radius compensation is on; cancel it with G40 before")
    if c.feed_mode == "G93":
        raise BlockFault(column, f"{code} with inverse time feed (G93); write G94 before")
    if any(w.has(a) for a in "ABC"):
        raise BlockFault(
            column, f"rotary axes cannot move in the block of the cycle {code}; move them before"
        )
    first, second, normal = PLANES[c.plane]
    if c.cycle_level is None:
        c.cycle_level = c.p[normal]
    r, bottom = _heights(c, w, code, normal, column)
    _words(c, w, code, column)
    repeats = _repeats(c, w, column)
    step = [0.0, 0.0]
    point = [c.p[first], c.p[second]]
    for k, i in enumerate((first, second)):
        number = w.take(AXES[i])
        if number is not None:
            value = length(c, w, AXES[i], number)
            if c.absolute:
                point[k] = value
            else:
                step[k] = value
    level = max(c.cycle_level, r)
    hole = Hole(c, w, column, r, bottom, r if c.retract == "G99" else level)
    if (
        c.cycle_level if c.dialect.words == "o" else c.p[normal]
    ) < r:  # LinuxCNC: even where it stands higher now
        hole.to(r, True)
    for _ in range(repeats):
        point = [point[0] + step[0], point[1] + step[1]]
        hole.across(point[0], point[1])
        hole.to(r, True) if code not in ("G87",) else None
        _MACHINING[code](hole)


def _heights(c: Control, w: Words, code: str, normal: int, column: int) -> tuple[float, float]:
    """R and bottom, absolute, mm; the words as given stay in force."""
    letter = AXES[normal]
    number = w.take(letter)
    if number is not None:
        c.cycle["Z"] = length(c, w, letter, number)
    number = w.take("R")
    if number is not None:
        c.cycle["R"] = length(c, w, "R", number)
    if "Z" not in c.cycle:
        raise BlockFault(column, f"{code} has no depth yet; add {letter}, as in {code} {letter}-10.0 R2.0")
    if "R" not in c.cycle:
        raise BlockFault(
            column, f"{code} has no clearance height yet; add R, as in {code} {letter}-10.0 R2.0"
        )
    assert c.cycle_level is not None
    r = c.cycle["R"] if c.absolute else c.cycle_level + c.cycle["R"]
    bottom = c.cycle["Z"] if c.absolute else r + c.cycle["Z"]
    if (bottom > r and code != "G87") or (code == "G87" and c.dialect.words == "o" and bottom > r):
        raise BlockFault(
            column,
            f"the bottom of {code} ({letter} {bottom:g} mm) lies above its clearance height (R {r:g} mm); correct one of them",
        )
    return r, bottom


def _words(c: Control, w: Words, code: str, column: int) -> None:
    """Q, P and the words of boring cycles, kept in force."""
    pecks = w.take("Q")
    if pecks is not None:
        if pecks <= 0 and code in ("G73", "G83"):
            raise BlockFault(w.column("Q"), f"Q{pecks:g}: the depth of a peck must be positive; correct it")
        c.cycle["Q"] = length(c, w, "Q", pecks)
    wait = w.take("P")
    if wait is not None:
        if wait < 0:
            raise BlockFault(w.column("P"), "a dwell cannot be negative; correct P")
        c.cycle["P"] = wait
    for letter in CENTRE_WORDS:
        number = w.take(letter)
        if number is not None:
            c.cycle[letter] = length(c, w, letter, number)
    needed = _STICKY.get(code)
    if needed and c.dialect.words == "o" and needed not in c.cycle:
        meaning = "the depth of a peck" if needed == "Q" else "the dwell in seconds"
        raise BlockFault(column, f"{code} needs {needed}, {meaning}; add it")


def _repeats(c: Control, w: Words, column: int) -> int:
    count = w.whole("L", column) if c.dialect.words == "o" or w.has("L") else None
    if count is None and c.dialect.words == "macro":
        count = None if "K" not in w.values else w.whole("K", column)
        c.cycle.pop("K", None)
    if count == 0 and c.dialect.words == "o":
        raise BlockFault(w.column("L"), "L0 repeats nothing; write L1 or more")
    return 1 if count is None else count


# -- what happens in the hole ------------------------------------------------------------------------------------------
def _feed_in(h: Hole) -> None:
    h.to(h.bottom, False)


def _g81(h: Hole) -> None:
    _feed_in(h)
    h.to(h.clear, True)


def _g82(h: Hole) -> None:
    _feed_in(h)
    h.wait()
    h.to(h.clear, True)


def _g83(h: Hole) -> None:
    """Pecks of Q; out to R after each, back to the clearance above the depth reached."""
    _pecks(h, full=True)


def _g73(h: Hole) -> None:
    """Pecks of Q; up by the clearance after each."""
    _pecks(h, full=False)


def _pecks(h: Hole, full: bool) -> None:
    peck, gap = h.c.cycle.get("Q", 0.0), h.c.dialect.peck_clearance
    if peck <= 0:
        h.c.remark("the cycle has no Q and is drilled in one go", h.column, once="no Q")
        return (_g82 if full else _g81)(h)
    if (h.r - h.bottom) / peck > _MOST_PECKS:
        raise BlockFault(h.w.column("Q"), f"Q gives more than {_MOST_PECKS} pecks; correct it")
    depth = h.r - peck
    while depth > h.bottom:
        h.to(depth, False)
        if full:
            h.to(h.r, True)
            h.to(min(depth + gap, h.r), True)
        else:
            h.to(min(depth + gap, h.r), True)
        depth -= peck
    h.to(h.bottom, False)
    h.wait() if h.c.dialect.words == "macro" else None
    return h.to(h.clear, True)


def _tap(h: Hole) -> None:
    """G84, G74: in and out at feed, the spindle reversed at the bottom. Fanuc leaves the hole at R, LinuxCNC at the retract height."""
    _feed_in(h)
    h.wait()
    sense = h.c.sense
    h.c.sense = -sense
    h.to(h.r if h.c.dialect.words == "macro" else h.clear, False)
    h.c.sense = sense
    h.to(h.clear, True)


def _g85(h: Hole) -> None:
    _feed_in(h)
    if h.c.dialect.words == "macro":
        h.to(h.r, False)
        h.to(h.clear, True)
    else:
        h.to(h.clear, False)


def _g86(h: Hole) -> None:
    """Spindle stops at the bottom, out at rapid."""
    _feed_in(h)
    h.wait()
    sense, h.c.sense = h.c.sense, 0
    h.to(h.clear, True)
    h.c.sense = sense


def _fine_bore(h: Hole) -> None:
    """G76: oriented stop, off the wall by Q (Fanuc: along the first axis of the plane; I J K where given), out."""
    _feed_in(h)
    h.wait()
    a, b = h.c.p[h.first], h.c.p[h.second]
    da, db = _away(h)
    sense, h.c.sense = h.c.sense, 0
    h.across(a + da, b + db)
    h.to(h.clear, True)
    h.across(a, b)
    h.c.sense = sense


def _away(h: Hole) -> tuple[float, float]:
    i, j = h.c.cycle.get(CENTRE_WORDS[h.first], 0.0), h.c.cycle.get(CENTRE_WORDS[h.second], 0.0)
    return (i, j) if i or j else (h.c.cycle.get("Q", 0.0), 0.0)


def _back_bore(h: Hole) -> None:
    """G87: down beside the centre line, in, up at feed, and out the same way."""
    c = h.c
    a, b = c.p[h.first], c.p[h.second]
    da, db = _away(h)
    if c.dialect.words == "o":
        for letter in CENTRE_WORDS:
            if letter not in c.cycle:
                raise BlockFault(h.column, f"G87 needs I, J and K; {letter} is missing")
        top = c.cycle[CENTRE_WORDS[h.normal]] + (0.0 if c.absolute else h.bottom)
        low, high = h.bottom, top
        h.to(h.r, True)
    else:
        low, high = min(h.r, h.bottom), max(h.r, h.bottom)
    sense, c.sense = c.sense, 0
    h.across(a + da, b + db)
    h.to(low, True)
    h.across(a, b)
    c.sense = sense
    h.to(high, False)
    if c.dialect.words == "o":
        h.to(low, False)
    else:
        h.wait()
    c.sense = 0
    h.across(a + da, b + db)
    h.to(h.clear if c.dialect.words == "o" else max(h.clear, c.cycle_level or h.clear), True)
    h.across(a, b)
    c.sense = sense


def _g88(h: Hole) -> None:
    """Dwell, spindle stop, out by hand: the way out is taken at rapid."""
    _feed_in(h)
    h.wait()
    h.c.remark(
        "G88 is retracted by hand at the machine; a rapid to the clearance height is assumed",
        h.column,
        once="G88",
    )
    h.to(h.clear, True)


def _g89(h: Hole) -> None:
    _feed_in(h)
    h.wait()
    if h.c.dialect.words == "macro":
        h.to(h.r, False)
        h.to(h.clear, True)
    else:
        h.to(h.clear, False)


_MACHINING = {
    "G73": _g73, "G74": _tap, "G76": _fine_bore, "G81": _g81, "G82": _g82, "G83": _g83, "G84": _tap, "G85": _g85,
    "G86": _g86, "G87": _back_bore, "G88": _g88, "G89": _g89,
}  # fmt: skip


def rigid_tap(c: Control, w: Words, column: int, lead: float) -> None:
    """G33.1: in at `lead` per turn, and back with the spindle reversed to where it began."""
    from vcmm.nc.iso.motion import target

    begin = list(c.p)
    p, rotary = target(c, w)
    thread_to(c, p, rotary, column, lead)
    c.sense = -c.sense
    thread_to(c, begin, rotary, column, lead)
    c.sense = -c.sense
