"""Front-end for Fagor programs of mills: translated into the words of the G-code family, and read there."""

from __future__ import annotations

import re
from collections.abc import Callable
from dataclasses import replace

from vcmm.program.dialects import FANUC
from vcmm.program.drilling import Hole
from vcmm.program.fagor.lines import FagorLines
from vcmm.program.fagor.pockets import mill
from vcmm.program.faults import ProgramFault
from vcmm.program.iso.program import run
from vcmm.program.levels import Assumption
from vcmm.program.moves import Program
from vcmm.program.recorder import Recorder
from vcmm.program.setup import Setup

MILL = replace(
    FANUC, name="fagor", codes="fagor", peck_clearance=1.0
)  # G83: back to 1 mm before the depth reached


def _pocket(code: str, given: dict[str, float]) -> Callable[[Recorder, Hole], None]:
    """Return a pocket with its words."""
    return lambda r, hole: mill(r, hole, code, given)


def read(text: str, file: str, setup: Setup, trace: bool = False) -> Program:
    """Return the moves of a program. Raises ProgramFault for one of a lathe, and for what cannot be understood; columns are those of the
    line as it is read."""
    code = re.sub(r"\([^)\n]*\)|;.*|^%.*", "", text.upper(), flags=re.MULTILINE)
    if (
        re.search(r"X\s*[-+.\d]", code)
        and re.search(r"Z\s*[-+.\d]", code)
        and not re.search(r"Y\s*[-+.\d]", code)
    ):
        raise ProgramFault(
            file,
            1,
            1,
            "X and Z without Y: a Fagor program of a lathe (T model), which is not here; have it posted for fanuc-lathe",
        )
    lines = FagorLines(text)
    made = lines.translate()
    if setup.strict and lines.assumptions:
        line, what, _ = min(lines.assumptions)
        raise ProgramFault(file, line, 1, f"{what} is not understood; write its motion with G1 to G3")
    language = replace(MILL, pockets=tuple(_pocket(code, given) for code, given in lines.pockets))
    program = run(
        made, language, replace(setup, unit=setup.unit or 1.0), file, trace
    )  # a Fagor wakes up in mm: G71
    assumptions = [Assumption(line, what, value) for line, what, value in lines.assumptions]
    return replace(program, assumed=tuple(sorted([*program.assumed, *assumptions], key=lambda a: a.line)))
