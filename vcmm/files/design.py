"""Plans of set-ups (design/1): which instrument, where, how often, how long."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import replace
from functools import partial
from pathlib import Path
from typing import Literal

import numpy as np
from pydantic import Field

from vcmm.core.axes import is_rotary
from vcmm.core.errors import UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.core.text import LARGEST
from vcmm.core.units import quantity, usual
from vcmm.files.machine import load_machine
from vcmm.files.problems import Problems
from vcmm.files.schema import Point, Table, Travel, checked_model
from vcmm.files.toml import check_version, read_toml
from vcmm.instruments import artefact, ball_bar, find, laser, level, tracker
from vcmm.instruments.instrument import InstrumentCertificate
from vcmm.response.recording import Recording


class SetupTable(Table):
    """One set-up. Which keys matter depends on the instrument; see docs/calibrate.md."""

    name: str
    instrument: str = Field(examples=['"laser linear"'])
    minutes: float = Field(gt=0, allow_inf_nan=False, examples=["20"])
    u: str = Field(examples=['"0.2 um"'])
    own: dict[str, str] = Field(default_factory=dict, examples=['{ scale = "0.3 um/m" }'])
    axis: Literal["", "X", "Y", "Z"] = ""
    component: Literal["", "X", "Y", "Z", "A", "B", "C"] = ""
    at: dict[str, str] = Field(default_factory=dict, examples=['{ Y = "250 mm", Z = "-200 mm" }'])
    offset: Point = (0.0, 0.0, 0.0)
    n: int = Field(default=0, ge=0, examples=["13"])
    station: Point | None = None
    centre: Point | None = None
    radius: str = ""
    plane: Literal["", "XY", "YZ", "ZX"] = ""
    corner: Point | None = None
    along: Point | None = None
    across: Point | None = None


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
) -> tuple[list[tuple[str, Recording, float, InstrumentCertificate | None]], Machine, float | None]:
    """(set-ups as name, recording, minutes, certificate), machine, budget in minutes or None.

    Raises DataError with every problem, each with file and line.
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
            made = problems.attempt(("setups", i), partial(_setup, table, machine))
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
    """The machine that the plan names, without its errors, or structure and travels."""
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


def _setup(table: SetupTable, machine: Machine) -> tuple[Recording, InstrumentCertificate | None]:
    instrument = find(table.instrument)
    dimension = "angle" if instrument.kind == "angle" else "length"
    u = quantity(table.u, dimension, "u", "0.2 um")
    if u < usual(dimension) / LARGEST:
        raise UsageError(f'u = "{table.u}" must be positive')
    makers: dict[str, Callable[..., Recording]] = {
        "displacement": _line, "angle": _line, "length": _lengths, "probe": _plate,
    }  # fmt: skip
    recording = replace(makers[instrument.kind](table, machine, u), name=table.name)
    return recording, InstrumentCertificate.of(instrument, table.own) if table.own else None


def _need(table: SetupTable, *keys: str) -> None:
    for key in keys:
        if getattr(table, key) in ("", None, 0, {}):
            raise UsageError(f'the set-up "{table.name}" with "{table.instrument}" needs {key}')


def _line(table: SetupTable, machine: Machine, u: float) -> Recording:
    _need(table, "axis", "n")
    component = table.component or table.axis
    at = {a: quantity(v, "length", a, "250 mm") for a, v in table.at.items()}
    missing = [a for a in machine.chain.letters if a != table.axis and a not in at]
    if missing:
        raise UsageError(
            f'the set-up "{table.name}" does not say where {" ".join(missing)} stood; add at = {{ {missing[0]} = "250 mm" }}'
        )
    targets = np.linspace(*machine.axes[table.axis].travel, table.n)
    if table.instrument == "level":
        about = "XYZ"["ABC".index(component)] if component in "ABC" else component
        return level.readings(machine, table.axis, targets, at, about, u)
    return laser.line(
        machine, table.axis, targets, at, offset=np.array(table.offset), component=component, u=u
    )


def _lengths(table: SetupTable, machine: Machine, u: float) -> Recording:
    if table.instrument == "ball bar":
        _need(table, "centre", "radius", "plane")
        radius = quantity(table.radius, "length", "radius", "150 mm")
        return ball_bar.circle(
            machine,
            list(table.centre or ()),
            radius,
            table.plane,
            u,
            points=table.n or 72,
            offset=list(table.offset),
        )
    _need(table, "station", "n")
    grid = [np.linspace(*machine.axes[a].travel, table.n) for a in "XYZ"]
    tips = np.stack([m.ravel() for m in np.meshgrid(*grid, indexing="ij")], axis=1) + np.array(table.offset)
    free = (
        {"station": "setup", "zero": "setup"} if table.instrument == "LaserTracer" else {"station": "setup"}
    )
    return tracker.lengths_to(
        machine,
        table.name,
        tips,
        list(table.station or ()),
        list(table.offset),
        nuisance=free,
        u=u,
        label=table.name,
    )


def _plate(table: SetupTable, machine: Machine, u: float) -> Recording:
    _need(table, "corner", "along", "across")
    n = table.n or 5
    balls = artefact.grid_of_balls(
        list(table.corner or ()), list(table.along or ()), list(table.across or ()), (n, n)
    )
    return artefact.plate(machine, balls, table.name, list(table.offset), u)
