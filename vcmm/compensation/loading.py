"""Load the inputs of a compensation: program text, set-up, machine with the state of the control of its file, and the name of the dialect.

Temperatures that errors of the machine depend on and the set-up does not state: 20 degC, with a remark.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace
from pathlib import Path

from vcmm.compensation.source import SourceText, read_source
from vcmm.core.effect import required
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import T0_DEG_C
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


def with_temperatures(
    machine: Machine, setup: Setup, stated: Mapping[str, float]
) -> tuple[dict[str, float], tuple[str, ...]]:
    """Return the stated columns with temp_<sensor>_C at 20 degC for sensors that neither the set-up nor its log states, and a note about it."""
    logged = setup.log.sensors if setup.log is not None else {}
    open_: dict[str, list[str]] = {}
    for effect in machine.effects:
        for column in required(effect):
            sensor = column.removeprefix("temp_").removesuffix("_C")
            if column == f"temp_{sensor}_C" and column not in stated and sensor not in logged:
                open_.setdefault(sensor, []).append(effect.id)
    if not open_:
        return dict(stated), ()
    first, *_ = open_
    message = (
        f"{', '.join(dict.fromkeys(e for effects in open_.values() for e in effects))} of the machine file go with the temperature of {', '.join(open_)}, which the set-up does not "
        f'state: taken as 20 degC; write [temperature] {first} = "22 degC" into it where it is another'
    )
    return {**stated, **{f"temp_{s}_C": T0_DEG_C for s in open_}}, (message,)
