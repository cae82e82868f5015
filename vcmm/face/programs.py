"""Understand an NC program on the machine of its set-up, and check that it is sensible."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vcmm.core.machine import Machine
    from vcmm.program.moves import Program
    from vcmm.program.setup import Setup


def machine_of(setup: Setup | None) -> Machine | None:
    """Return the machine that a set-up names; None without one, and where its file is missing."""
    from vcmm.core.text import is_file
    from vcmm.files.own.machine import load_machine

    named = None if setup is None else setup.machine
    return load_machine(named) if named is not None and is_file(Path(named)) else None


def understand_program(program: Path, dialect: str | None, setup: Setup | None, strict: bool) -> Program:
    """Return the program, with remarks on whether it is sensible on the machine of the set-up."""
    from dataclasses import replace

    from vcmm.program.interpret import read_program
    from vcmm.program.moves import Remark
    from vcmm.program.sensible import remarks_on

    read = read_program(program, dialect, at_level(setup, strict))
    if setup is None:
        return read
    machine = machine_of(setup)
    notes = list(remarks_on(read, setup, machine))
    if machine is not None and read.moves:
        from vcmm.shop.motion.tool_centre import orient_moves

        moves, singular = orient_moves(read.moves, machine, str(program))
        read, notes = replace(read, moves=moves), [*notes, *singular]
    if setup.machine and machine is None:
        notes.append(Remark(1, 1, f"{setup.machine} does not exist: travels are not looked at"))
    return replace(read, warnings=(*read.warnings, *notes))


def at_level(setup: Setup | None, strict: bool) -> Setup:
    from dataclasses import replace

    from vcmm.program.setup import Setup

    return replace(setup or Setup(), strict=strict)
