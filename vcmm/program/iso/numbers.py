"""Findings on the text of a program about its numbers as a whole: decimal points, and the unit."""

from __future__ import annotations

import re

from vcmm.program.iso.control import IsoControl
from vcmm.program.levels import SetupEntry
from vcmm.program.moves import Source

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
