"""Machine files: machine/1 TOML to a Machine with its Inputs."""

from __future__ import annotations

from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from vcmm.effect import Effect
from vcmm.effects.component import ComponentSpline, ComponentTable
from vcmm.effects.expansion import ScaleExpansion
from vcmm.effects.scatter import Scatter
from vcmm.effects.squareness import RotaryLocation, Squareness
from vcmm.errors import DataError, UsageError, choose_from
from vcmm.files.effects import build_effect, build_input
from vcmm.files.isg import ErrorFile, read_isg
from vcmm.files.schema import (
    Acceleration,
    Angle,
    Expansion,
    Frequency,
    Jerk,
    Kelvin,
    Length,
    Point,
    Problems,
    Speed,
    Table,
    read_model,
)
from vcmm.files.toml import Document, Location, check_version, read_toml
from vcmm.inputs import EVERY, Input
from vcmm.kinematics import Axis, Chain, parse_structure
from vcmm.laws import Law, MultivariateNormal, Normal, StudentT
from vcmm.machine import Machine
from vcmm.run import Array
from vcmm.units import quantity


class Dynamics(Table):
    speed: Speed | None = None
    acceleration: Acceleration | None = None
    jerk: Jerk | None = None
    gain: Frequency | None = None


class AxisTable(Table):
    travel: list[str]
    centre: Point = (0.0, 0.0, 0.0)
    measured_at: Point | None = None
    error_frame: Literal["moving", "fixed"] = "moving"
    dynamics: Dynamics = Field(default_factory=Dynamics)


class Uncertainty(Table):
    translation: Length = 0.0
    rotation: Angle = 0.0
    squareness: Angle = 0.0
    correlation_length: Length | None = None


class Errors(Table):
    table: str
    state: Literal["residual", "raw"] = "residual"
    compensation: list[str] = []
    interpolation: Literal["linear", "cubic"] = "linear"
    uncertainty: Uncertainty | None = None


class Repeatability(Table):
    law: Literal["normal", "t"] = "normal"
    u: Length | None = None
    scale: Length | None = None
    dof: float | None = None


class Scales(Table):
    expansion: Expansion
    u_expansion: Expansion = 0.0
    compensated: bool = True
    u_sensor: Kelvin = 0.0


class MachineEnvironment(Table):
    scales: Scales | None = None


class MachineFile(Table):
    """machine/1"""

    vcmm: str
    name: str = ""
    kind: Literal["cmm", "machine-tool", "lathe"] = "cmm"
    structure: str
    axes: dict[str, AxisTable]
    errors: Errors | None = None
    repeatability: Repeatability | None = None
    environment: MachineEnvironment | None = None
    effects: list[dict[str, Any]] = []
    inputs: list[dict[str, Any]] = []
    certificate: dict[str, str] | None = None


def load_machine(path: str | Path) -> Machine:
    """Read a machine file. Raises DataError with every problem of the file, each with its line."""
    document = read_toml(path)
    check_version(document, "machine")
    return machine_from(document, document.data, ())


def machine_from(document: Document, data: dict[str, Any], at: Location) -> Machine:
    """A machine table (a file, or [machine] of a scenario) to a Machine."""
    model = read_model(MachineFile, {"vcmm": "machine/1", **data}, document, at)
    problems = Problems(document)
    if model.certificate is not None:
        problems.add(
            (*at, "certificate"),
            "drawing machines that are consistent with a certificate is not built yet; give [errors], [repeatability] or [[effects]]",
        )
    chain = problems.attempt((*at, "structure"), lambda: parse_structure(model.structure))
    axes = {
        k: problems.attempt((*at, "axes", k, "travel"), lambda k=k, a=a: _axis(k, a))
        for k, a in model.axes.items()
    }
    effects, inputs = _known_errors(model, document, problems, at, chain, axes)
    for i, table in enumerate(model.effects):
        built = problems.attempt((*at, "effects", i), lambda table=table: build_effect(table))
        effects += [built] if built is not None else []
    for i, table in enumerate(model.inputs):
        found = problems.attempt((*at, "inputs", i), lambda table=table: build_input(table, effects))
        inputs += [found] if found is not None else []
    problems.raise_if_any()
    state = model.errors.state if model.errors else "residual"
    active = tuple(model.errors.compensation) if model.errors else ()
    name = model.name or document.path.stem
    machine = problems.attempt(
        (*at, "structure"),
        lambda: Machine(name, model.kind, chain, axes, tuple(effects), tuple(inputs), state, active),
    )
    problems.raise_if_any()
    assert isinstance(machine, Machine)
    return machine


def _axis(letter: str, table: AxisTable) -> Axis:
    if letter not in tuple("XYZABC"):
        raise UsageError(f'unknown axis "{letter}".{choose_from(letter, list("XYZABC"))}')
    if len(table.travel) != 2:
        raise UsageError(f'travel of {letter} needs two ends, for example travel = ["0 mm", "600 mm"]')
    low, high = (quantity(t, "angle" if letter in "ABC" else "length", "travel") for t in table.travel)
    if not low < high:
        raise UsageError(
            f"travel of {letter} runs from {table.travel[0]} to {table.travel[1]}; the first end must be the lower one"
        )
    dynamics = {k: v for k, v in table.dynamics.model_dump().items() if v is not None}
    return Axis(letter, (low, high), table.centre, table.measured_at, table.error_frame, dynamics)


def _known_errors(
    model: MachineFile,
    document: Document,
    problems: Problems,
    at: Location,
    chain: Chain | None,
    axes: dict[str, Axis | None],
) -> tuple[list[Effect], list[Input]]:
    effects: list[Effect] = []
    inputs: list[Input] = []
    if model.errors:
        path = document.path.parent / model.errors.table
        tables = problems.attempt((*at, "errors", "table"), lambda: read_isg(path))
        if tables is not None:
            effects = effects_of(tables, model.errors.interpolation == "cubic")
            for effect in effects:
                _check_on_machine(effect, chain, axes, problems, (*at, "errors", "table"), path)
            inputs += _table_inputs(effects, model.errors.uncertainty)
    if model.repeatability:
        law = problems.attempt((*at, "repeatability"), lambda: _repeatability(model.repeatability))  # type: ignore[arg-type]
        effects.append(Scatter())
        inputs += (
            [Input("scatter", "", "value", law, "touch", "repeatability of the machine file")] if law else []
        )
    if model.environment and model.environment.scales and chain:
        more, known = _scales(model.environment.scales, [a for a in chain.letters if a in "XYZ"])
        effects, inputs = effects + more, inputs + known
    return effects, inputs


def effects_of(file: ErrorFile, cubic: bool = False) -> list[Effect]:
    """Component tables (or cubic splines), squareness and rotary locations of an errors.csv."""
    effects: list[Effect] = []
    for table in file.tables:
        for name, values in table.values.items():
            if cubic and len(table.arguments) == 1 and table.arguments[0] == name[2] and len(values) > 2:
                effects.append(ComponentSpline(name, table.grids[0], values))
            else:
                effects.append(ComponentTable(name, table.arguments, table.grids, values))
    for name, value in file.constants.items():
        if name[2] in "XYZ":
            effects.append(Squareness(name, value))
        elif name[0] in "XYZ":
            effects.append(RotaryLocation(name, offset=value))
        else:
            effects.append(RotaryLocation(name, tilt=value))
    return effects


def _check_on_machine(
    effect: Effect,
    chain: Chain | None,
    axes: dict[str, Axis | None],
    problems: Problems,
    at: Location,
    path: Path,
) -> None:
    if chain and effect.link not in chain.letters:
        problems.add(
            at,
            f'{path.name} holds {effect.where} of axis {effect.link}, which structure = "{chain.structure}" lacks',
        )
    if isinstance(effect, ComponentTable):
        for letter in effect.arguments:
            if chain and letter not in chain.letters:
                problems.add(
                    at, f"{path.name} tabulates {effect.where} over axis {letter}, which the machine lacks"
                )


def _table_inputs(effects: list[Effect], known: Uncertainty | None) -> list[Input]:
    """The short form `uncertainty`: Gaussian process per component over its axis, squareness independent."""
    if known is None:
        return []
    inputs = []
    for effect in effects:
        if isinstance(effect, ComponentTable | ComponentSpline):
            u = known.translation if effect.component[1] in "XYZ" else known.rotation
            if u > 0:
                law = _correlated(effect, u, known.correlation_length)
                inputs.append(
                    Input(
                        effect.name, effect.where, "values", law, "machine", "calibration of the error table"
                    )
                )
        elif isinstance(effect, Squareness) and known.squareness > 0:
            inputs.append(
                Input(
                    "squareness",
                    effect.where,
                    "angle",
                    Normal(known.squareness),
                    "machine",
                    "calibration of the error table",
                )
            )
    return inputs


def _correlated(
    effect: ComponentTable | ComponentSpline, u: float, length: float | None
) -> MultivariateNormal:
    """u^2 exp(-(dq)^2 / (2 l^2)) between the nodes; without a correlation length the nodes are independent.

    A rotary axis has no length: its nodes are taken as independent unless they coincide.
    """
    grids = effect.grids if isinstance(effect, ComponentTable) else (np.asarray(effect.nodes),)
    letters = effect.arguments if isinstance(effect, ComponentTable) else (effect.link,)
    mesh = np.stack([g.ravel() for g in np.meshgrid(*grids, indexing="ij")], axis=1)
    squared: Array = np.zeros((len(mesh), len(mesh)))
    for i, letter in enumerate(letters):
        gap = mesh[:, None, i] - mesh[None, :, i]
        if length is None or letter in "ABC":
            squared = squared + np.where(gap == 0, 0.0, np.inf)
        else:
            squared = squared + (gap / length) ** 2
    return MultivariateNormal(u**2 * np.exp(-squared / 2))


def _repeatability(table: Repeatability) -> Law:
    if table.law == "normal":
        spread = table.u if table.u is not None else table.scale
        if spread is None:
            raise UsageError('[repeatability] law = "normal" needs u, for example u = "0.5 um"')
        return Normal(spread)
    if table.scale is None or table.dof is None:
        raise UsageError(
            '[repeatability] law = "t" needs scale and dof, for example scale = "0.7 um" and dof = 6'
        )
    return StudentT(table.scale, table.dof)


def _scales(table: Scales, letters: list[str]) -> tuple[list[Effect], list[Input]]:
    """Scale expansion of every linear axis; one coefficient for all scales, one sensor per scale."""
    corrected = table.expansion if table.compensated else 0.0
    effects: list[Effect] = [ScaleExpansion(a, table.expansion, corrected) for a in letters]
    inputs = []
    if table.u_expansion > 0:
        inputs.append(
            Input(
                "scale_expansion",
                EVERY,
                "alpha",
                Normal(table.u_expansion),
                "machine",
                "expansion of the scales",
            )
        )
    if table.u_sensor > 0:
        for a in letters:
            inputs.append(
                Input(
                    "channel",
                    "",
                    f"temp_scale_{a.lower()}_C",
                    Normal(table.u_sensor),
                    "machine",
                    f"temperature sensor of scale {a}",
                )
            )
    return effects, inputs


__all__ = ["DataError", "MachineFile", "effects_of", "load_machine", "machine_from"]
