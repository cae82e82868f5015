"""Front-end for Okuma OSP programs: translated into the words of the G-code family, and read there."""

from __future__ import annotations

import re
from dataclasses import replace

from vcmm.program.dialects import FANUC, FANUC_LATHE_B
from vcmm.program.faults import ProgramFault
from vcmm.program.iso.program import run
from vcmm.program.levels import Assumption
from vcmm.program.moves import Program
from vcmm.program.okuma.lines import OkumaLines
from vcmm.program.setup import Setup

MILL = replace(FANUC, name="okuma", dwell=1.0)
LATHE = replace(FANUC_LATHE_B, name="okuma", codes="lathe-b", dwell=1.0, part_spindles={"G14": 2, "G15": 1})


def read(text: str, file: str, setup: Setup, trace: bool = False) -> Program:
    """Return the moves of a program. Without Y, and without a work offset G15 H, it is one of a lathe: X counts diameters.

    Raises ProgramFault for what cannot be understood; its columns are those of the line as it is read.
    """
    lathe = is_turning(text)
    lines = OkumaLines(text, lathe)
    made = lines.translate()
    assumptions = [
        Assumption(line, what, value, matters=matters) for line, what, value, matters in lines.assumptions
    ]
    assumptions += [Assumption(1, f"the value of {name}", "0") for name in lines.names.read]
    lost = [a for a in assumptions if a.matters]
    if setup.strict and lost:
        first = min(lost, key=lambda a: a.line)
        raise ProgramFault(file, first.line, 1, f"{first.what} is not known here; give it in the program")
    program = run(made, LATHE if lathe else MILL, setup, file, trace)
    names = {number: name for name, number in lines.names.programs.items()}
    assumed = [a._replace(what=_program_name(a.what, names)) for a in program.assumed]
    return replace(program, assumed=tuple(sorted([*assumed, *assumptions], key=lambda a: a.line)))


def is_turning(text: str) -> bool:
    """Return whether a program turns: X and Z without Y, no work offset of a mill."""
    code = re.sub(r"\([^)\n]*\)", "", text.upper())
    mill = re.search(r"\bG1[56]\s*H|\bG56\s*H|(?<![A-Z])Y[-+.\d\[=]", code)
    return mill is None and re.search(r"(?<![A-Z])X[-+.\d\[=]", code) is not None


def _program_name(what: str, programs: dict[int, str]) -> str:
    """Return the name of a program instead of the number that it was given."""
    return re.sub(r"\bO(\d+)\b", lambda m: f"O{programs.get(int(m[1]), m[1])}", what)
