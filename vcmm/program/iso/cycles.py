"""Drilling, tapping and boring cycles G73, G74, G76, G81 to G89, in the three planes, expanded into single moves.

A series: R and the depth stay in force until another motion code; each block with an axis word makes L (K) holes. The
initial level is the height at which the series began; G98 goes back to it (or to R where that is higher), G99 to R. With
G91 R counts from the initial level and the depth from R: Fanuc and its kin take the mode in which the word was given, so that
heights stay where they are under a later G90 or G91; LinuxCNC takes the mode of each block (RS274/NGC, 3.5.20).
"""

from __future__ import annotations

from collections.abc import Callable, Mapping
from functools import partial

from vcmm.program.cycle_tables import Cycle, Values, cycle
from vcmm.program.drilling import Hole
from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import AXES, IsoControl
from vcmm.program.iso.lengths import length, rotary_target, waiting
from vcmm.program.iso.motion import CENTRE_WORDS, target, thread_to
from vcmm.program.iso.settings import tell_clearance
from vcmm.program.levels import pass_over
from vcmm.program.moves import PLANES

_MOST_PECKS = 20_000
TAPPING = ("G74", "G84")
OUT = "times as fast out"  # what J of G74 and G84 means on a Haas; J of G83 and G87 is a length, and stays in force beside it
FASTEST_OUT = 9  # J of Haas
SIDE = {"G87": "G83", "G88": "G84", "G89": "G85"}  # of Fanuc lathes, along X


def drill(c: IsoControl, w: IsoWords, code: str) -> None:
    """Drill a block in which a cycle is in force."""
    if c.compensation is not None:
        c.fault(f"{code} while cutter radius compensation is on; cancel it with G40 before")
    if c.feed_mode == "G93":
        c.fault(f"{code} with inverse time feed (G93); write G94 before")
    if any(w.has(a) for a in "ABC") and c.language.words == "o":
        c.fault(f"rotary axes cannot move in the block of the cycle {code}; move them before")
    normal = PLANES[c.plane][2]
    if c.cycle_level is None:
        c.cycle_level = c.p[normal]
    _heights(c, w, code, normal)
    _words(c, w, code)
    repeats = _repeats(c, w, c.column)
    point, step = _hole_point(c, w)
    rotary = rotary_target(c, w)
    if rotary != c.rotary:
        c.straight(c.p, True, rotary)
    if code in ("G73", "G74", "G83", "G84") and c.cycle.get("Q"):
        r, bottom = heights(c)
        if (r - bottom) / c.cycle["Q"] > _MOST_PECKS:
            raise BlockFault(w.column("Q"), f"Q gives more than {_MOST_PECKS} pecks; correct it")
    for _ in range(repeats):
        point = [point[0] + step[0], point[1] + step[1]]
        drill_at(c, point[0], point[1], code)


def lathe_cycle(c: IsoControl, mode: str) -> tuple[str, str]:
    """Return the kind of a drilling cycle of a lathe and its plane: along Z; on Fanuc G87, G88, G89 work along X as G83, G84, G85 along Z.

    Source: FANUC B-64304EN-1, "canned cycle for drilling": face (Z) and side (X) drilling, tapping and boring.
    """
    if mode in SIDE and not c.language.everything_home:
        return SIDE[mode], "YZ"
    return mode, "XY"


def _hole_point(c: IsoControl, w: IsoWords) -> tuple[list[float], list[float]]:
    """Return the places of the holes in the plane, and the increment from one to the next (G91)."""
    first, second, _ = PLANES[c.plane]
    if c.polar is not None or c.language.lathe:
        p, _ = target(c, w)
        return [p[first], p[second]], [0.0, 0.0]
    step, point = [0.0, 0.0], [c.p[first], c.p[second]]
    for k, i in enumerate((first, second)):
        number = w.take(AXES[i])
        if number is not None:
            value = length(c, w, AXES[i], number) * (0.5 if i == 0 and c.diametral() else 1.0)
            if c.absolute:
                point[k] = value
            else:
                step[k] = value
    return point, step


def heights(c: IsoControl) -> tuple[float, float]:
    """Return the clearance and bottom of the cycle in force, mm."""
    level = c.cycle_level or 0.0
    r = c.cycle["R"] + (level if _counts_on(c, "R") else 0.0)
    return r, c.cycle["Z"] + (r if _counts_on(c, "Z") else 0.0)


def _counts_on(c: IsoControl, letter: str) -> bool:
    """Return whether R counts from the initial level, the depth from R."""
    if letter == "R" and c.language.lathe and not c.language.everything_home:
        return True  # Fanuc lathes: from where it starts
    return not c.absolute if c.language.words == "o" else letter in c.counted_on


def drill_at(c: IsoControl, a: float, b: float, code: str = "") -> None:
    """Drill one hole of the cycle in force, at (a, b) mm of the plane."""
    code, normal = code or str(c.motion), PLANES[c.plane][2]
    r, bottom = heights(c)
    level = r if c.cycle_level is None else c.cycle_level
    hole = Hole(c, r, bottom, r if c.retract == "G99" else max(level, r))
    if c.language.words == "o" and level < r:  # even where it is higher now
        hole.to(r, True)
    elif c.p[normal] < r and code != "G87":
        c.assume(
            f"where {code} ends whose R lies above the level at which it begins",
            "at R: it goes across at its present level and up to R then (FANUC B-64304EN, operations 1 and 2); the way back is not described",
            column=c.column,
        )  # fmt: skip
    hole.across(a, b)
    if code != "G87":
        hole.to(r, True)
    row = DRILLING[code]
    row.primitive(c, hole, row.read(c.cycle, lambda parameter, value: value))


def _heights(c: IsoControl, w: IsoWords, code: str, normal: int) -> None:
    """Read R and depth: the words as given stay in force, and are checked."""
    letter = AXES[normal]
    half = 0.5 if letter == "X" and c.diametral() else 1.0
    for meaning, word, factor in (("Z", letter, half), ("R", "R", 1.0)):
        number = w.take(word)
        if number is not None:
            c.cycle[meaning] = length(c, w, word, number) * factor
            c.counted_on = c.counted_on - {meaning} if c.absolute else c.counted_on | {meaning}
    number = w.take("UVW"[normal]) if c.language.lathe else None
    if number is not None:  # from R to the bottom
        c.cycle["Z"], c.counted_on = length(c, w, "UVW"[normal], number) * half, c.counted_on | {"Z"}
    if "Z" not in c.cycle:
        c.fault(f"{code} has no depth yet; add {letter}, as in {code} {letter}-10.0 R2.0")
    if "R" not in c.cycle and (c.language.lathe or c.language.survey):
        c.cycle["R"] = 0.0 if c.language.lathe and not c.language.everything_home else c.cycle_level or 0.0
        c.counted_on -= {"R"}
        if not c.language.lathe:
            c.assume("the clearance height R of a cycle", "the height at which it begins", column=c.column)
    if "R" not in c.cycle:
        c.fault(f"{code} has no clearance height yet; add R, as in {code} {letter}-10.0 R2.0")
    r, bottom = heights(c)
    if (bottom > r and code != "G87") or (code == "G87" and c.language.words == "o" and bottom > r):
        c.fault(
            f"the bottom of {code} ({letter} {bottom:g} mm) lies above its clearance height (R {r:g} mm); correct one of them",
        )


def _words(c: IsoControl, w: IsoWords, code: str) -> None:
    """Read Q, P and the words of boring cycles, kept in force; words without use in the cycle are noted."""
    row, unused = DRILLING[code], []
    for letter in ("Q", "P", *CENTRE_WORDS):
        number = None if letter == "K" and _k_counts(c, w) else w.take(letter)
        if number is None:
            continue
        if letter == "Q" and (
            (number <= 0 and code in ("G73", "G83")) or (number < 0 and code in ("G74", "G84"))
        ):
            raise BlockFault(w.column("Q"), f"Q{number:g}: the depth of a peck must be positive; correct it")
        if letter == "P" and number < 0:
            raise BlockFault(w.column("P"), "a dwell cannot be negative; correct P")
        multiple = letter == "J" and code in TAPPING and c.language.haas
        if multiple:
            c.cycle[OUT] = _retract_multiple(w, number)
        else:
            c.cycle[letter] = waiting(c, w, number) if letter == "P" else length(c, w, letter, number)
        if number and not (row.uses(letter) or multiple):
            unused.append(letter)
    if c.language.words == "macro":
        for letter in unused:
            pass_over(c, f"{letter}{w.words[letter].text}", w.column(letter))
    missing = [letter for letter in row.required_names if letter not in c.cycle]
    if missing and c.language.words == "o":
        meaning = "the depth of a peck" if missing[0] == "Q" else "the dwell in seconds"
        c.fault(f"{code} needs {missing[0]}, {meaning}; add it")


def _retract_multiple(w: IsoWords, number: float) -> float:
    """Return J of G74 and G84 on a Haas: how many times as fast the tap comes out (mill operator's manual, "G84 tapping": J2 is twice as fast)."""
    if not 0 < number <= FASTEST_OUT:
        raise BlockFault(
            w.column("J"),
            f"J{number:g}: how many times as fast the tap comes out is 1 to {FASTEST_OUT}; correct it",
        )
    return number


def _k_counts(c: IsoControl, w: IsoWords) -> bool:
    """Return whether K is a number of repeats: Fanuc and its kin, but with I in G83 of Haas, where it is the least peck."""
    return c.language.words == "macro" and not (c.language.codes == "haas" and "I" in w.values)


def _repeats(c: IsoControl, w: IsoWords, column: int) -> int:
    count = w.whole("L", column) if c.language.words == "o" or w.has("L") else None
    if _k_counts(c, w):
        c.cycle.pop("K", None)
        times = w.whole("K", column)
        count = times if count is None else count
    if count is not None and count > _MOST_PECKS:
        raise BlockFault(
            column, f"{count} repeats of a cycle; {_MOST_PECKS} are the most, correct their number"
        )
    if count == 0 and c.language.words == "o":
        raise BlockFault(w.column("L"), "L0 repeats nothing; write L1 or more")
    return 1 if count is None else count


# -- what happens in the hole ------------------------------------------------------------------------------------------
def in_and_out(c: IsoControl, h: Hole, v: Values) -> None:
    """Feed to the bottom, dwell, move out at rapid."""
    h.feed_in(v["P"])
    h.leave()


def peck(c: IsoControl, h: Hole, v: Values, *, out: bool) -> None:
    """Peck by Q, each back to the clearance above the depth reached; G83 goes out to R between them. Haas: first peck I, each smaller by
    J, down to K."""
    step, gap, smaller = v["Q"], c.language.peck_clearance, 0.0
    if c.language.codes == "haas" and v["I"]:
        step, smaller = v["I"], v["J"]
    if step <= 0:
        c.remark("the cycle has no Q and is drilled in one go", c.column, "no Q")
        return in_and_out(c, h, v if out else Values({}))
    depths = [h.clearance - step]
    while depths[-1] > h.bottom and len(depths) < _MOST_PECKS:
        step = max(step - smaller, v["K"], 1e-3) if smaller else step
        depths.append(depths[-1] - step)
    depths[-1] = h.bottom
    if len(depths) > 1:
        tell_clearance(c, "G83" if out else "G73")
    h.pecks(depths, lambda depth: min(depth + gap, h.clearance), out=out)
    if c.language.words == "macro":
        h.wait(v["P"])
    return h.leave()


def tap(c: IsoControl, h: Hole, v: Values) -> None:
    """Tap in and out at feed, the spindle reversed at the bottom. Fanuc leaves the hole at R, LinuxCNC at the retract height."""
    _tapping_pecks(c, h, v["Q"])
    h.feed_in(v["P"])
    _feed_out(c, h, -c.sense, c.cycle.get(OUT, 1.0))
    h.leave()


def _tapping_pecks(c: IsoControl, h: Hole, step: float) -> None:
    """Peck while tapping, G84 Q of Fanuc and its kin: after each Q the spindle turns back and the tap comes up by d (high-speed peck
    tapping; B-64304EN,
    "peck rigid tapping cycle (G84 or G74)", parameter 5213). With parameter 5200#5 PCP = 1 it comes up to R; which, the control knows."""
    if c.language.words != "macro" or step <= 0:
        return
    back = c.language.peck_clearance
    c.assume(
        "how far the tap comes up after each peck Q", f"{back:g} mm (FANUC parameter 5213; with 5200#5 PCP = 1 to R)", column=c.column
    )  # fmt: skip
    depth = h.clearance - step
    while depth > h.bottom + 1e-9:
        h.to(depth, False)
        sense, c.sense = c.sense, -c.sense
        h.to(min(depth + back, h.clearance), False)
        c.sense = sense
        depth -= step


def _feed_out(c: IsoControl, h: Hole, turning: int, times: float = 1.0) -> None:
    """Move out at feed: Fanuc to R, LinuxCNC to the retract height. turning: sense of the spindle meanwhile; times: how many times as fast
    spindle and feed go."""
    kept = c.sense, c.speed, c.feed
    c.sense, c.speed = turning, c.speed * times
    if c.feed is not None and c.feed_mode == "G94":
        c.feed *= times
    h.to(h.clearance if c.language.words == "macro" else h.retract, False)
    c.sense, c.speed, c.feed = kept


def ream(c: IsoControl, h: Hole, v: Values) -> None:
    """Ream, G85: out at feed to R, and on at rapid: LinuxCNC 2.9, convert_cycle_g85, and Fanuc alike."""
    h.feed_in()
    h.to(h.clearance, False)
    h.leave()


def ream_and_dwell(c: IsoControl, h: Hole, v: Values) -> None:
    """Ream and dwell, G89: the same with a dwell; LinuxCNC goes on at feed to the retract height."""
    h.feed_in(v["P"])
    _feed_out(c, h, c.sense)
    h.leave()


def bore(c: IsoControl, h: Hole, v: Values) -> None:
    """Bore, G86: the spindle stops at the bottom, out at rapid."""
    h.feed_in(v["P"])
    sense, c.sense = c.sense, 0
    h.leave()
    c.sense = sense


def fine_bore(c: IsoControl, h: Hole, v: Values) -> None:
    """Bore and step off the wall, G76: oriented stop, off the wall by Q (Fanuc: along the first axis of the plane; I J K where given), out."""
    h.feed_in(v["P"])
    first, second, _ = PLANES[c.plane]
    a, b = c.p[first], c.p[second]
    da, db = _away(c, v)
    sense, c.sense = c.sense, 0
    h.across(a + da, b + db)
    h.leave()
    h.across(a, b)
    c.sense = sense


def _away(c: IsoControl, v: Values) -> tuple[float, float]:
    first, second, _ = PLANES[c.plane]
    i, j = v[CENTRE_WORDS[first]], v[CENTRE_WORDS[second]]
    return (i, j) if i or j else (v["Q"], 0.0)


def back_bore(c: IsoControl, h: Hole, v: Values) -> None:
    """Bore backwards, G87: down beside the centre line, in, up at feed, and out the same way."""
    first, second, normal = PLANES[c.plane]
    a, b = c.p[first], c.p[second]
    da, db = _away(c, v)
    o_words = c.language.words == "o"
    if o_words:
        for letter in CENTRE_WORDS:
            if not v.has(letter):
                c.fault(f"G87 needs I, J and K; {letter} is missing")
        low, high = h.bottom, v[CENTRE_WORDS[normal]] + (0.0 if c.absolute else h.bottom)
        h.to(h.clearance, True)
    else:
        low, high = min(h.clearance, h.bottom), max(h.clearance, h.bottom)
    sense, c.sense = c.sense, 0
    h.across(a + da, b + db)
    h.to(low, True)
    h.across(a, b)
    c.sense = sense
    h.to(high, False)
    if o_words:
        h.to(low, False)
    else:
        h.wait(v["P"])
    c.sense = 0
    h.across(a + da, b + db)
    h.to(h.retract if o_words else max(h.retract, c.cycle_level or h.retract), True)
    h.across(a, b)
    c.sense = sense


def hand_bore(c: IsoControl, h: Hole, v: Values) -> None:
    """Bore, G88: dwell, spindle stop, out by hand: the way out is taken at rapid."""
    h.feed_in(v["P"])
    text = "G88 is retracted by hand at the machine; a rapid to the clearance height is assumed"
    c.remark(text, c.column, "G88")
    h.leave()


def pocket(c: IsoControl, h: Hole, v: Values) -> None:
    """Mill a pocket, G287: pocket Q of those that the program has beside it (Fagor)."""
    c.language.pockets[round(v["Q"] / c.unit) - 1](c, h)


_PECKS = "Q mm!, P time, I mm, J mm, K mm"  # I J K: of Haas
DRILLING: Mapping[str, Cycle[Callable[[IsoControl, Hole, Values], None]]] = {  # "!": LinuxCNC insists
    "G73": cycle(_PECKS, partial(peck, out=False)),
    "G74": cycle("Q mm, P time", tap),
    "G76": cycle("Q mm!, P time, I mm, J mm, K mm", fine_bore),
    "G81": cycle("", in_and_out),
    "G82": cycle("P time!", in_and_out),
    "G83": cycle(_PECKS, partial(peck, out=True)),
    "G84": cycle("Q mm, P time", tap),
    "G85": cycle("", ream),
    "G86": cycle("P time!", bore),
    "G87": cycle("Q mm, P time, I mm?, J mm?, K mm?", back_bore),
    "G88": cycle("P time!", hand_bore),
    "G89": cycle("P time!", ream_and_dwell),
    "G287": cycle("Q mm", pocket),
}


def rigid_tap(c: IsoControl, w: IsoWords, lead: float) -> None:
    """Tap rigidly, G33.1: in at `lead` per turn, and back with the spindle reversed to where it began."""
    begin = c.p
    p, rotary = target(c, w)
    thread_to(c, p, lead, rotary)
    c.sense = -c.sense
    thread_to(c, begin, lead, rotary)
    c.sense = -c.sense
