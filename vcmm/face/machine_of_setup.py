"""The set-up and the machine of a program that is to be compensated, read from their files."""

from __future__ import annotations

from pathlib import Path

from vcmm.compensation.loading import MachineOfFile, no_machine
from vcmm.core.machine import Machine
from vcmm.files.own.machine import load_machine
from vcmm.files.own.setup import load_setup
from vcmm.files.toml import read_toml
from vcmm.program.setup import Setup


def setup_and_machine(
    setup: str | Path | Setup, machine: Machine | None
) -> tuple[Setup, MachineOfFile | Machine]:
    """Return the set-up as a value, and the machine: the given one, else that which the set-up names. Raises UsageError where it names none."""
    read = setup if isinstance(setup, Setup) else load_setup(setup)
    if machine is not None:
        return read, machine
    if read.machine is None:
        raise no_machine(read)
    table = read_toml(read.machine).data.get("errors")
    state = str(table.get("state", "")) if isinstance(table, dict) else None
    return read, MachineOfFile(load_machine(read.machine), Path(read.machine), state)
