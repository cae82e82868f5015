"""Numbers of the program in mm, with the decimal point rule of the dialect."""

from __future__ import annotations

import math
from typing import Any

from vcmm.program.cycle_tables import Cycle, CycleParameter, Values
from vcmm.program.faults import BlockFault
from vcmm.program.iso.codes import IsoWords
from vcmm.program.iso.control import IsoControl
from vcmm.program.levels import pass_over
from vcmm.program.moves import Point
from vcmm.program.sensible import missing_axis_fault

POINTLESS = 20.0  # mm: from here on a number without a point counts increments where all coordinates have one, and so do those beside it
LENGTHS = "XYZUVWIJR"


def length(c: IsoControl, w: IsoWords, letter: str, number: float) -> float:
    """Return a number of the program in mm, with the decimal point rule of the dialect."""
    word = w.words.get(letter)
    if word is not None and number and not word.has_point and c.language.words == "macro":
        small = c.language.increment[1 if c.unit > 1.0 else 0]
        if c.language.decimal_point == "increment":
            return number * small * c.unit
        if c.points_written and _counts_increments(c, w, number):
            text = f"increments of {small:g}, as {letter}{word.text}: every coordinate of this program has its point"
            refusal = (
                f"{letter}{word.text} without a decimal point, where every coordinate has its own: {number * small:g} or {number:g}? Write the "
                'point, or decimal_point = "increment" (or "calculator") in the set-up file'
            )
            c.assume("words without a decimal point", text, refusal, column=word.first)
            return number * small * c.unit
        _warn_pointless(c, w, letter, number)
    return number * c.unit


def _counts_increments(c: IsoControl, w: IsoWords, number: float) -> bool:
    """Return whether all words of a block are increments: so where one of them would be too long for anything else."""
    beside = (w.values[k] for k in LENGTHS if k in w.values and not w.words[k].has_point)
    return any(abs(value) * c.unit >= POINTLESS for value in (number, *beside))


def _warn_pointless(c: IsoControl, w: IsoWords, letter: str, number: float) -> None:
    unit = "inch" if c.unit > 1.0 else "mm"
    small = number * c.language.increment[1 if c.unit > 1.0 else 0]
    c.remark(
        f"{letter}{w.words[letter].text} without a decimal point is read as {number:g} {unit} (calculator type); a control "
        f'set to increments reads {small:g} {unit}. Write the point, or decimal_point = "increment" in the set-up file',
        w.column(letter),
        "decimal point",
    )


def read_words(c: IsoControl, w: IsoWords, row: Cycle[Any]) -> Values:
    """Return the values of the words of a block in a cycle."""
    numbers = {p.name: value for p in row.parameters if (value := w.take(p.name)) is not None}

    def convert(parameter: CycleParameter, value: float) -> float:
        name, kind = parameter.name, parameter.kind
        if kind == "steps":
            small = 1.0 if w.words[name].has_point else c.language.increment[1 if c.unit > 1.0 else 0]
            return value * small * c.unit
        if kind == "count":
            return w.whole(name, c.column) or 0
        if kind in ("mm", "radius"):
            return length(c, w, name, value) * (0.5 if kind == "radius" and c.diametral() else 1.0)
        return math.radians(value) if kind == "deg" else value

    return row.read(numbers, convert)


def waiting(c: IsoControl, w: IsoWords, number: float) -> float:
    """Return P of a dwell in seconds. Haas: seconds where it has a decimal point, else milliseconds (mill operator's manual, G04). Fanuc:
    milliseconds, and no point (B-64304EN, "dwell (G04)": the decimal point cannot be used with P)."""
    small = c.language.dwell
    word = w.words.get("P")
    if small == 1.0 or not number or word is None or not word.has_point or callable(word.value):
        return number * small
    if not c.language.haas:
        c.assume(
            f"the time of P{word.text}, which has a decimal point", f"{number:g} s",
            f"P{word.text}: P counts milliseconds and takes no decimal point on this control; write P{number * 1000:.0f}, or X{number:g} with G4",
            column=word.first, matters=False,
        )  # fmt: skip
    return number


def pass_over_axes(c: IsoControl, w: IsoWords) -> None:
    """Pass over axes beside a code that has a block of its own (G4, G67): they move nothing."""
    for letter in "XYZABCUVW":
        if w.has(letter) and letter not in w.used:
            w.used.add(letter)
            pass_over(c, f"{letter}{w.words[letter].text}", w.column(letter))


def need_axis(c: IsoControl, w: IsoWords, axis: str) -> None:
    """Refuse an axis that the machine of the set-up lacks: no control takes it."""
    if c.setup.axes is not None and axis not in c.setup.axes:
        raise BlockFault(w.column(axis), missing_axis_fault(c.setup.axes, axis))


def rotary_target(c: IsoControl, w: IsoWords) -> Point:
    """Return the rotary position that a block asks for, rad."""
    out = list(c.rotary)
    step = w.take("H") if c.language.codes == "lathe" else None  # system A: C by an increment
    if step is not None:
        out[2] += math.radians(step)
    for i, axis in enumerate("ABC"):
        number = w.take(axis)
        if number is not None:
            need_axis(c, w, axis)
            angle = math.radians(number)
            out[i] = angle if c.absolute else out[i] + angle
    return (out[0], out[1], out[2])
