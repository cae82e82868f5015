"""Round and write the numbers of a program, in the style of the word that they replace.

A value is rounded to the decimals of the program. On chains of short blocks the rounding error of one block is carried
into the next (error diffusion: Floyd and Steinberg, Proc. SID 17 (1976) 75), so that the mean over the chain is right to
far less than one digit; elsewhere each value is rounded by itself, so that walls stay straight.
"""

from __future__ import annotations

import re

from vcmm.program.trace import WordAt

SAME_INCREMENT_SHARE = 1e-3  # share of an increment below which two values are one
HOLD = 0.75  # increments by which an axis that the block does not name may be off before a word is added


def nearest(value: float, step: float) -> float:
    """Return the nearest multiple of a step."""
    return round(value / step) * step


class Diffusion:
    """Rounding that carries its error along, for one axis."""

    def __init__(self, step: float) -> None:
        self.step, self.carry = step, 0.0

    def next(self, value: float) -> float:
        wanted = value + self.carry
        number = nearest(wanted, self.step)
        self.carry = wanted - number
        return number

    def forget(self) -> None:
        self.carry = 0.0


def decimals_of(words: list[WordAt], inch: bool, decimals: int | None) -> int:
    """Return the decimals with which a program is written: as many as its longest number, at least 0.001 mm or 0.0001 inch."""
    if decimals is not None:
        return decimals
    least = 4 if inch else 3
    return max([least, *(w.decimals or 0 for w in words)])


def format_number(value: float, decimals: int, like: str = "", increments: bool = False) -> str:
    """Return a number in the style of `like`: its plus sign, its missing zero before the point.

    increments: without a point, in units of the last decimal (control set to increments).
    """
    if increments:
        return f"{round(value * 10**decimals):d}"
    text = f"{value:.{decimals}f}"
    point = "," if "," in like else "."
    if float(text) == 0.0:
        text = text.removeprefix("-")
    if re.match(r"[-+]?\s*[.,]", like):
        text = re.sub(r"^(-?)0\.", r"\1.", text)
    if like.strip().startswith("+") and not text.startswith("-"):
        text = "+" + text
    return text.replace(".", point)


def value_of(word: WordAt) -> float:
    """Return the number of a plain word."""
    return float(re.sub(r"\s", "", word.text).replace(",", "."))
