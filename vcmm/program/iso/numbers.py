"""Findings on the text of a program about its numbers as a whole: decimal points, unit, fixed format.

Controls of the seventies take coordinates of a fixed format, X-014895 for -14.895 mm, from point to point by default. A survey reads them so,
and says so; strict reading takes numbers as the set-up says (decimal_point).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

from vcmm.core.errors import DataError
from vcmm.program.dialects import Dialect
from vcmm.program.iso.control import IsoControl
from vcmm.program.levels import Assumption, SetupEntry
from vcmm.program.moves import MoveFlow, Program, Source

_FIXED, FEW = re.compile(r"[XYZIJK][-+]?0\d{4,}(?![\d.])"), 5
_FIXED_POINT, _SAID = re.compile(r"[XYZIJK][-+]?\d*\.\d"), re.compile(r"G9[01](?![\d.])")
_NOTE = re.compile(r"\([^()\n]*\)")
FIXED_LOOKED_AT = 200_000  # characters of a text
Reader = Callable[[Dialect, MoveFlow | None], Program]


def fixed_format(text: str) -> bool:
    """Return whether coordinates have five digits or more, leading zeros, and no point anywhere."""
    plain = _NOTE.sub("", text[:FIXED_LOOKED_AT]).upper()
    return len(_FIXED.findall(plain)) > FEW and not _FIXED_POINT.search(plain)


def read_fixed_format(read: Reader, text: str, dialect: Dialect, flow: MoveFlow | None) -> Program:
    """Return the program with numbers as increments; without G90 and G91 the way from point to point, where the arcs fit only so."""
    language = replace(dialect, decimal_point="increment")
    assumptions = [
        Assumption(
            1, "numbers of a fixed format, without a point", "increments of 0.001 mm: X-014895 is -14.895 mm",
            SetupEntry("", "decimal_point", '"increment"'),
        )
    ]  # fmt: skip
    if not _SAID.search(text.upper()) and _arcs_misfit(read, language):
        language = replace(language, absolute=False)
        assumptions.append(
            Assumption(
                1,
                "how coordinates count, for want of G90 and G91",
                "from point to point: the arcs fit only so",
            )
        )
    program = read(language, flow)
    return replace(program, assumed=(*assumptions, *program.assumed))


def _arcs_misfit(read: Reader, language: Dialect) -> bool:
    try:
        read(language, None)
    except DataError as error:
        return "does not fit" in str(error)
    return False


LOOKED_AT = 300_000  # characters in which the style of numbers is looked for
_POINTED, _POINTLESS = re.compile(r"[XYZ]-?\d*\.\d*"), re.compile(r"[XYZ]-?0*[1-9]\d*(?![\d.])")
_COMMENT = re.compile(r"\(([^()\n]*)\)|;([^\n]*)")
_TOOL = r"(?:END|EM|E\.M\.|DRILL|BALL|REAM|TAP|SPOT|MILL|CHAMFER|DIA)"
_UNITS = {  # words, and sizes of tools as they are called: 1/2 END MILL, .375 DRILL, DIA-0.5000, 6MM DRILL
    "inch": re.compile(
        rf"\bINCH(?:ES)?\b|\bIMPERIAL\b|\bUNITS?\W{{1,3}}IN\b|\d[ ]?IN\b|\b\d+/\d+[ -]*(?:\"|{_TOOL})|(?<![\d.])0?\.\d{{3,4}}[ -]*{_TOOL}"
        r"|\bDIA[ .=:-]*0?\.\d{3,4}\b",
        re.IGNORECASE,
    ),
    "mm": re.compile(r"\bMILLIM|\bMETRIC\b|\bUNITS?\W{1,3}MM\b|\bIN MM\b|\d[ ]?MM\b", re.IGNORECASE),
}


def has_points_written(text: str) -> bool:
    """Return whether every coordinate other than zero has its decimal point, as on a control that counts increments without."""
    plain = re.sub(r"\([^()\n]*\)", "", text[:LOOKED_AT])
    return bool(_POINTED.search(plain)) and not _POINTLESS.search(plain)


def stated_unit(text: str) -> tuple[str, int, str] | None:
    """Return ("inch" or "mm", line, comment) of the first comment that names a unit; None where none does, or where comments name both."""
    units: dict[str, tuple[str, int, str]] = {}
    for match in _COMMENT.finditer(text[:LOOKED_AT]):
        note = (match[1] or match[2] or "").strip()
        for unit, pattern in _UNITS.items():
            if unit not in units and pattern.search(note):
                units[unit] = (unit, text.count("\n", 0, match.start()) + 1, note[:60])
    return next(iter(units.values())) if len(units) == 1 else None


def tell_unit(c: IsoControl, text: str) -> None:
    """Add a remark on the unit: a program without G20 and G21 is read in mm; a unit stated in its text is added."""
    stated = stated_unit(text)
    c.source = Source(1, 1, 1)
    if stated is None or stated[0] == "mm":
        note = "" if stated is None else f', as the comment of line {stated[1]} says ("{stated[2]}")'
        c.assume(
            "the unit, for want of G20 and G21",
            f"mm{note}",
            blank=SetupEntry("", "unit", '"mm"'),
            matters=False,
        )
        return
    value = f'mm; the comment of line {stated[1]} says "{stated[2]}": if inches are meant, write unit = "inch" in the set-up file'
    c.assume("the unit, for want of G20 and G21", value, blank=SetupEntry("", "unit", '"inch"'))
