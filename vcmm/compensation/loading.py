"""Reading what a compensation needs: program text, set-up, machine, and the name of the dialect."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

from vcmm.compensation.source import SourceText, read_source
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.program.reading import guess
from vcmm.program.setup import Setup

LoadedProgram = tuple[SourceText, Setup, Machine, Path | None, str]


def load_program(
    program: str | Path, setup: str | Path | Setup, machine: Machine | None, dialect: str | None
) -> LoadedProgram:
    """(source, set-up, machine, its file or None, dialect). Raises UsageError where no machine is named."""
    if not isinstance(setup, Setup):
        from vcmm.files.own.setup import load_setup

        setup = load_setup(setup)
    machine_file = None
    if machine is None:
        if setup.machine is None:
            raise UsageError(f'{setup.path or "the set-up"} names no machine; add machine = "mill.toml"')
        from vcmm.files.own.machine import load_machine

        machine_file, machine = setup.machine, load_machine(setup.machine)
    setup = replace(setup, axes=frozenset(machine.axes))
    source = read_source(Path(program))
    name = dialect or setup.dialect or guess(source.text, Path(program))[0]
    return source, setup, machine, machine_file, name
