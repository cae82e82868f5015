"""Check that an export agrees with itself and with the scenario: deviation = actual - nominal, and one nominal in both.

A row measured against another nominal than that of the scenario is a row of another drawing, or the scenario is: its value is right,
its decision may not be. Numbers are compared as far as they are written: deviation within 1.5 last digits of the coarsest of the
three (each is rounded on its own), nominal within half a last digit.
"""

from __future__ import annotations

import re
from dataclasses import dataclass

from vcmm.core.units import UNITS
from vcmm.files.foreign.foreign_text import foreign_number

ROUNDING = 1e-6  # of a last digit: binary numbers


@dataclass(frozen=True)
class StatedCells:
    """Cells of one row as written ("" where there is none), and the words of their columns."""

    actual: str
    nominal: str = ""
    deviation: str = ""
    words: tuple[str, str, str] = ("actual", "nominal", "deviation")


def contradictions(cells: StatedCells, unit: str, drawing: float | None) -> list[str]:
    """Return contradictions in words, without the place. unit: of the cells; drawing: nominal of the scenario, mm or rad."""
    actual, nominal, deviation = (_number(c) for c in (cells.actual, cells.nominal, cells.deviation))
    a, n, d = cells.words
    out = []
    if nominal is not None and drawing is not None:
        due = drawing / UNITS[unit][0]
        if abs(nominal - due) > (0.5 + ROUNDING) * _digit(cells.nominal) + ROUNDING * 1e-3:
            out.append(
                f"{n} {cells.nominal.strip()} {unit} is not that of the scenario, {due:.9g} {unit}: the value is judged against the "
                "scenario; correct the one that is not on the drawing"
            )
    if actual is not None and nominal is not None and deviation is not None:
        difference = actual - nominal
        allowed = (1.5 + ROUNDING) * max(_digit(c) for c in (cells.actual, cells.nominal, cells.deviation))
        if (
            min(abs(difference - deviation), abs(difference + deviation)) > allowed
        ):  # either sign: of a place below zero some count outwards
            places = max(_places(c) for c in (cells.actual, cells.nominal))
            out.append(
                f"{d} {cells.deviation.strip()} is not {a} - {n} = {cells.actual.strip()} - {cells.nominal.strip()} = "
                f"{difference:.{places}f} {unit}; {a} is taken"
            )
    return out


def _number(cell: str) -> float | None:
    """Return the number of a cell; None for an empty cell, or a word such as MMC."""
    try:
        return foreign_number(cell)
    except ValueError:
        return None


def _places(cell: str) -> int:
    """Return the digits behind the point or comma: 50,0021 -> 4."""
    return len(re.sub(r"^[^.,]*[.,]?", "", cell.strip().lower().split("e")[0]))


def _digit(cell: str) -> float:
    """Return the value of the last digit: 50,0021 -> 1e-4, 1.5e-3 -> 1e-4."""
    power = cell.strip().lower().partition("e")[2]
    return float(10.0 ** ((int(power) if power else 0) - _places(cell)))
