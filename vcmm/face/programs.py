"""Read NC programs on the machine of their set-up, check that they are sensible, and read what a program needs to be compensated."""

from __future__ import annotations

from pathlib import Path
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vcmm.compensation.loading import MachineOfFile
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


def setup_and_machine(
    setup: str | Path | Setup, machine: Machine | None
) -> tuple[Setup, MachineOfFile | Machine]:
    """Return the set-up as a value, and the machine: the given one, else that which the set-up names. Raises UsageError where it names none."""
    from vcmm.compensation.loading import MachineOfFile, no_machine
    from vcmm.files.own.machine import load_machine
    from vcmm.files.own.setup import load_setup
    from vcmm.files.toml import read_toml
    from vcmm.program.setup import Setup

    read = setup if isinstance(setup, Setup) else load_setup(setup)
    if machine is not None:
        return read, machine
    if read.machine is None:
        raise no_machine(read)
    table = read_toml(read.machine).data.get("errors")
    state = str(table.get("state", "")) if isinstance(table, dict) else None
    return read, MachineOfFile(load_machine(read.machine), Path(read.machine), state)
