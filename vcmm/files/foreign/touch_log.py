"""Logs of touches that a control prints (DPRNT, WRITE, FN 16): one line per touch.

    TOUCH F1 I-1. J0 K0 X 137.5041 Y 20.0000 Z-5.0000 A-30.0000 C60.0000 S0

F      number of the feature: [touch.features.1]
X Y Z  place of the touch, mm, in the work offset of the program: along the measured axis as the control reports, else the position
I J K  way of the probe towards the surface in the axes of the machine (unit vector); of use where the control has taken the radius of the ball off
A B C  positions of the rotary axes, deg; those that the machine has and the line leaves out stand at zero
S      orientation of the spindle, deg; 0 where it is left out
T      time in seconds; optional

Blanks between a letter and its number, and a leading +, are allowed. Lines that begin with % ( ; # or are blank are comments; any other line is refused.
"""

from __future__ import annotations

import math
import re
from dataclasses import dataclass
from pathlib import Path

import numpy as np

from vcmm.core.errors import DataError
from vcmm.core.run import Array
from vcmm.core.text import lines_of, read_text
from vcmm.files.sheets import Layout

WORD = re.compile(r"\s*([A-Z])\s*([-+]?)\s*(\d+\.?\d*|\.\d+)", re.IGNORECASE)
HEAD = re.compile(r"\s*TOUCH\b", re.IGNORECASE)
LAYOUT = Layout(comments=("%", "(", ";", "#"))
NEEDED, LETTERS = "FXYZ", "FXYZIJKABCST"


@dataclass(frozen=True, eq=False)
class TouchLog:
    """features (n,) numbers as text; values: letter -> (n,) as printed (0 where a line leaves it out); lines (n,); letters: those that occur in any line."""

    features: np.ndarray
    values: dict[str, Array]
    lines: np.ndarray
    letters: frozenset[str]


def read_touch_log(path: str | Path) -> TouchLog:
    """Read a log of touches. Raises DataError with file, line and the expected words."""
    path = Path(path)
    rows: list[dict[str, float]] = []
    lines: list[int] = []
    for line in LAYOUT.rows(lines_of(read_text(path))):
        try:
            rows.append(_words(line.text))
        except ValueError as error:
            raise DataError(f"{path}:{line.line}: {error}") from None
        lines.append(line.line)
    if not rows:
        raise DataError(
            f"{path}:1: no line begins with TOUCH; a touch reads: TOUCH F1 I-1 J0 K0 X137.5 Y20 Z-5 A-30 C60"
        )
    stated = frozenset(letter for row in rows for letter in row)
    for letter in "ABC":
        some = [row for row in rows if letter in row]
        if some and len(some) < len(rows):
            at = next(n for n, row in zip(lines, rows) if letter not in row)
            raise DataError(
                f"{path}:{at}: {letter} is missing, which other lines state; add it, or it would stand at zero"
            )
    values = {letter: np.array([row.get(letter, 0.0) for row in rows]) for letter in LETTERS if letter != "F"}
    features = np.array([f"{row['F']:.0f}" for row in rows], dtype=np.str_)
    return TouchLog(features, values, np.array(lines, dtype=np.intp), stated)


def _words(text: str) -> dict[str, float]:
    """Parse one line: letter -> number. Raises ValueError in words."""
    head = HEAD.match(text)
    if head is None:
        raise ValueError(
            f'"{text.strip()[:40]}" is neither a touch (TOUCH F1 X... Y... Z...) nor a comment (% ( ; #); remove it'
        )
    at, out = head.end(), {}
    while text[at:].strip():
        word = WORD.match(text, at)
        if word is None:
            raise ValueError(f'"{text[at:].strip()[:20]}" is no letter with a number')
        letter = word[1].upper()
        if letter not in LETTERS:
            raise ValueError(f"{letter} is no word of a touch; these are {' '.join(LETTERS)}")
        if letter in out:
            raise ValueError(f"{letter} is given twice in the line")
        out[letter] = float(word[2] + word[3])
        at = word.end()
    missing = [letter for letter in NEEDED if letter not in out]
    if missing:
        raise ValueError(f"{' '.join(missing)} missing; a touch needs F X Y Z")
    _check(out)
    return out


def _check(row: dict[str, float]) -> None:
    """Raises ValueError for a direction that is no unit vector, and a feature that is no whole number."""
    way = [row.get(letter, 0.0) for letter in "IJK"]
    if any(letter in row for letter in "IJK") and abs(math.hypot(*way) - 1.0) > 2e-3:
        raise ValueError(
            f"I J K = {way[0]:g} {way[1]:g} {way[2]:g} has the length {math.hypot(*way):.4g}; it is a unit vector"
        )
    if row["F"] != round(row["F"]) or row["F"] < 0:
        raise ValueError(f"F{row['F']:g} is no number of a feature; these are 0, 1, 2 ...")
