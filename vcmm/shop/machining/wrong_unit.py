"""Detect inches taken for millimetres, or the reverse: test whether a program that misses the part would hit it in the other unit.

The program is read again with its code of the unit exchanged and set up anew, so that what follows from the unit (radius
compensation, cycles, offsets from the set-up, turned tables, passes of a lathe) follows here as well. It costs a second reading, and
happens only where the first has failed.
"""

from __future__ import annotations

import re
from collections.abc import Callable

from vcmm.core.errors import VcmmError
from vcmm.program.interpret import interpret
from vcmm.program.moves import Program
from vcmm.program.reading import guess, read_bytes
from vcmm.task.measuring.cut_scenario import CutScenario

LEAST_POINT_SHARE = 0.5  # share of the inspection points
CODES = {"G20": "G21", "G21": "G20", "G70": "G71", "G71": "G70", "G700": "G710", "G710": "G700"}
NUMBERS = {"sinumerik": "70|71|700|710", "fanuc": "20|21|70|71"}  # others: 20|21; G70 of a lathe is a cycle
_HEADER = re.compile(r"^(\s*\d*\s*(?:BEGIN|END) PGM .*?)\b(MM|INCH)\b", re.IGNORECASE | re.MULTILINE)
UNITS = {"G20": "inches", "G21": "millimetres", "INCH": "inches", "MM": "millimetres"}


Hits = Callable[[CutScenario, Program], tuple[int, int]]
"""(inspection points that a program cuts, inspection points)."""


def unit_hint(scenario: CutScenario, hits: Hits) -> str:
    """Return an addition to the message about a program that misses the part; empty where the other unit does not hit it either."""
    text = read_bytes(scenario.program)
    dialect = scenario.dialect or scenario.setup.dialect or guess(text, scenario.program)[0]
    other, unit_code, line = exchange_unit(text, dialect)
    if not other:
        return ""
    try:
        program = interpret(other, dialect, scenario.setup, str(scenario.program))
        hit, count = hits(scenario, program)
    except VcmmError:
        return ""
    if hit < LEAST_POINT_SHARE * count:
        return ""
    unit = UNITS.get(unit_code, "inches" if unit_code in ("G70", "G700") else "millimetres")
    wanted = "millimetres" if unit == "inches" else "inches"
    where = (
        f'"{unit_code}" in line {line}' if line else f'"{unit_code}" is taken, as the program states no unit'
    )
    return (
        f". The program is read in {unit} ({where}); in {wanted} it would cut {hit} of the {count} inspection points: "
        "correct the unit in the program"
    )


def exchange_unit(text: str, dialect: str) -> tuple[str, str, int]:
    """Return (text with the unit exchanged, code that was in force, its line or 0 where none is stated); "" where it cannot be."""
    numbers = NUMBERS.get(dialect, "20|21")
    code = re.compile(rf"(?<![A-Z0-9_])G(?:{numbers})(?![0-9.])", re.IGNORECASE)
    pattern = _HEADER if dialect == "heidenhain" else code
    first = pattern.search(text)
    if first is None:
        return ("", "", 0) if dialect == "heidenhain" else _state_unit(text, dialect)
    if pattern is _HEADER:
        swap = {"MM": "INCH", "INCH": "MM"}
        new = _HEADER.sub(lambda m: m[1] + swap[m[2].upper()], text)
        return new, first[2].upper(), text.count("\n", 0, first.start(2)) + 1
    new = code.sub(lambda m: CODES[m[0].upper()], text)
    return new, first[0].upper(), text.count("\n", 0, first.start()) + 1


def _state_unit(text: str, dialect: str) -> tuple[str, str, int]:
    """Return the text with the other unit stated in front of its first motion; a program without a code of the unit is in millimetres."""
    first_block = re.search(r"^(?!\s*(?:%|[O:]\s*\d|\())(?=.*[A-Z])", text, re.IGNORECASE | re.MULTILINE)
    if first_block is None:
        return "", "", 0
    inch, metric = ("G70", "G71") if dialect == "sinumerik" else ("G20", "G21")
    return f"{text[: first_block.start()]}{inch}\n{text[first_block.start() :]}", metric, 0
