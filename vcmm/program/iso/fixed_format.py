"""Programs of controls of the seventies: coordinates of a fixed format, X-014895 for -14.895 mm, from point to point by default.

A survey takes them so, and tells; strict reading takes numbers as the set-up says (decimal_point).
"""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

from vcmm.core.errors import DataError
from vcmm.program.dialects import Dialect
from vcmm.program.levels import Assumption, SetupEntry
from vcmm.program.moves import MoveFlow, Program

_FIXED, FEW = re.compile(r"[XYZIJK][-+]?0\d{4,}(?![\d.])"), 5
_POINTED, _SAID = re.compile(r"[XYZIJK][-+]?\d*\.\d"), re.compile(r"G9[01](?![\d.])")
_NOTE = re.compile(r"\([^()\n]*\)")
LOOKED_AT = 200_000  # characters of a text
Reader = Callable[[Dialect, MoveFlow | None], Program]


def fixed_format(text: str) -> bool:
    """Return whether coordinates have five digits or more, leading zeros, and no point anywhere."""
    plain = _NOTE.sub("", text[:LOOKED_AT]).upper()
    return len(_FIXED.findall(plain)) > FEW and not _POINTED.search(plain)


def read_fixed_format(read: Reader, text: str, dialect: Dialect, flow: MoveFlow | None) -> Program:
    """Return the program with numbers as increments; without G90 and G91 the way from point to point, where the arcs fit only so."""
    language = replace(dialect, decimal_point="increment")
    assumptions = [
        Assumption(
            1, "numbers of a fixed format, without a point", "increments of 0.001 mm: X-014895 is -14.895 mm",
            SetupEntry("", "decimal_point", '"increment"'),
        )
    ]  # fmt: skip
    if not _SAID.search(text.upper()) and _misfits(read, language):
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


def _misfits(read: Reader, language: Dialect) -> bool:
    try:
        read(language, None)
    except DataError as error:
        return "does not fit" in str(error)
    return False
