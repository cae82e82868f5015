"""Load the inputs of a compensation: program text, set-up, machine with the state of the control of its file, and the name of the dialect."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path

from vcmm.compensation.source import SourceText, read_source
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.program.reading import guess
from vcmm.program.setup import Setup


@dataclass(frozen=True, eq=False)
class MachineOfFile:
    """A machine and the statements of its file. state: of its [errors], "" where that table states none, None where there is no such table."""

    machine: Machine
    file: Path
    state: str | None


LoadedProgram = tuple[SourceText, Setup, MachineOfFile | Machine, str]


def load_program(
    program: str | Path, setup: Setup, machine: MachineOfFile | Machine, dialect: str | None
) -> LoadedProgram:
    """Return (source, set-up with the axes of the machine, machine, dialect)."""
    setup = replace(setup, axes=frozenset(machine_of(machine).axes))
    source = read_source(Path(program))
    name = dialect or setup.dialect or guess(source.text, Path(program))[0]
    return source, setup, machine, name


def machine_of(stated: MachineOfFile | Machine) -> Machine:
    """Return the machine itself."""
    return stated.machine if isinstance(stated, MachineOfFile) else stated


def no_machine(setup: Setup) -> UsageError:
    """Return the error to raise where neither the caller nor the set-up names a machine."""
    return UsageError(f'{setup.path or "the set-up"} names no machine; add machine = "mill.toml"')
