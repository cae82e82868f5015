"""Plans of set-ups (design/1): instrument, place, number of readings, duration."""

from __future__ import annotations

from dataclasses import replace
from functools import partial
from pathlib import Path

from pydantic import Field

from vcmm.core.axes import is_rotary
from vcmm.core.errors import UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.units import quantity
from vcmm.files.own.machine import load_machine
from vcmm.files.own.setups import SetupTable, plan_setup
from vcmm.files.problems import Problems
from vcmm.files.schema import Table, Travel, checked_model
from vcmm.files.toml import check_version, read_toml
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.response.recording import Recording


class AxisTravel(Table):
    travel: Travel


class DesignFile(Table):
    """design/1"""

    vcmm: str
    machine: str = ""
    structure: str = Field(default="", examples=['"w b Y X Z t"'])
    axes: dict[str, AxisTravel] = Field(default_factory=dict)
    budget: str | None = Field(default=None, examples=['"120 min"'])
    setups: list[SetupTable] = Field(default_factory=list)


def load_design(
    path: str | Path,
) -> tuple[list[tuple[str, tuple[Recording, ...], float, InstrumentCertificate]], Machine, float | None]:
    """Read a plan of set-ups of instruments (design/1).

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    tuple
        Set-ups (name, recordings, minutes, certificate of the instrument), the machine, and the budget in minutes or None.

    Raises
    ------
    DataError
        Every problem of the file, each with its line.
    """
    document = read_toml(path)
    check_version(document, "design")
    problems = Problems(document)
    model = checked_model(DesignFile, document.data, problems)
    machine = (
        None
        if model is None
        else problems.attempt(("structure",), lambda: _machine(model, document.path.parent))
    )
    out = []
    if model is not None and machine is not None:
        for i, table in enumerate(model.setups):
            made = problems.attempt(("setups", i), partial(plan_setup, table, machine))
            if made is not None:
                out.append((table.name, made[0], table.minutes, made[1]))
    budget = None
    if model is not None and model.budget is not None:
        seconds = problems.attempt(("budget",), lambda: quantity(model.budget, "time", "budget", "120 min"))
        budget = None if seconds is None else seconds / 60
    problems.raise_if_any()
    assert machine is not None
    return out, machine, budget


def _machine(model: DesignFile, folder: Path) -> Machine:
    """Return the machine that the plan names, without its errors, or structure and travels."""
    if model.machine:
        return replace(load_machine(folder / model.machine), effects=(), inputs=())
    if not model.structure:
        raise UsageError(
            'the plan names no machine; write structure = "w b Y X Z t" and [axes], or machine = "machine.toml"'
        )
    chain = parse_structure(model.structure)
    axes = {}
    for letter in chain.letters:
        if letter not in model.axes:
            raise UsageError(
                f'there is no travel of {letter}; add [axes.{letter}] travel = ["0 mm", "600 mm"]'
            )
        low, high = (
            quantity(t, "angle" if is_rotary(letter) else "length", "travel")
            for t in model.axes[letter].travel
        )
        axes[letter] = Axis(letter, (low, high))
    return Machine("planned", "cmm", chain, axes)
