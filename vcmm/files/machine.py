"""Machine files: machine/1 TOML to a Machine with its Inputs."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import fields, replace
from pathlib import Path
from typing import Any, Literal

import numpy as np
from pydantic import Field

from vcmm.effect import Effect, parameter_fields, place_fields
from vcmm.effects.component import ComponentSpline, ComponentTable
from vcmm.effects.expansion import ScaleExpansion
from vcmm.effects.scatter import Scatter
from vcmm.effects.squareness import RotaryLocation, Squareness
from vcmm.errors import DataError, UsageError, choose_from
from vcmm.files.effects import build_effect
from vcmm.files.inputs import build_input
from vcmm.files.isg import ErrorFile, read_isg
from vcmm.files.problems import Problems
from vcmm.files.schema import (
    Acceleration,
    AngleSpread,
    Expansion,
    ExpansionSpread,
    Frequency,
    Jerk,
    KelvinSpread,
    Point,
    Size,
    Speed,
    Spread,
    Table,
    Travel,
    checked_model,
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
    travel: Travel
    centre: Point = (0.0, 0.0, 0.0)
    measured_at: Point | None = None
    error_frame: Literal["moving", "fixed"] = "moving"
    dynamics: Dynamics = Field(default_factory=Dynamics)


class Uncertainty(Table):
    translation: Spread = 0.0
    rotation: AngleSpread = 0.0
    squareness: AngleSpread = 0.0
    correlation_length: Size | None = None


class Errors(Table):
    table: str = Field(examples=['"errors.csv"'])
    state: Literal["residual", "raw"] = "residual"
    compensation: list[str] = Field(default_factory=list)
    interpolation: Literal["linear", "cubic"] = "linear"
    uncertainty: Uncertainty | None = None


class Repeatability(Table):
    law: Literal["normal", "t"] = "normal"
    u: Spread | None = None
    scale: Spread | None = None
    dof: float | None = Field(default=None, examples=["6"])


class Scales(Table):
    expansion: Expansion
    u_expansion: ExpansionSpread = 0.0
    compensated: bool = True
    u_sensor: KelvinSpread = 0.0


class MachineEnvironment(Table):
    scales: Scales | None = None


class MachineFile(Table):
    """machine/1"""

    vcmm: str
    name: str = ""
    kind: Literal["cmm", "machine-tool", "lathe"] = "cmm"
    structure: str = Field(examples=['"w b Y X Z t"'])
    axes: dict[str, AxisTable] = Field(examples=['{ X = { travel = ["0 mm", "600 mm"] } }'])
    errors: Errors | None = None
    repeatability: Repeatability | None = None
    environment: MachineEnvironment | None = None
    effects: list[dict[str, Any]] = Field(default_factory=list)
    inputs: list[dict[str, Any]] = Field(default_factory=list)
    certificate: dict[str, str] | None = None


def load_machine(path: str | Path) -> Machine:
    """Read a machine file. Raises DataError with every problem of the file, each with its line."""
    document = read_toml(path)
    check_version(document, "machine")
    return machine_from(document, document.data, ())


def machine_from(document: Document, data: dict[str, Any], at: Location) -> Machine:
    """A machine table (a file, or [machine] of a scenario) to a Machine. Raises DataError with every problem."""
    problems = Problems(document)
    machine = _checked_machine(document, data, at, problems)
    problems.raise_if_any()
    assert machine is not None
    return machine


def _checked_machine(
    document: Document, data: dict[str, Any], at: Location, problems: Problems
) -> Machine | None:
    model = checked_model(MachineFile, {"vcmm": "machine/1", **data}, problems, at)
    if model is None:
        for i, table in enumerate(tables_in(data, "effects")):  # what can be checked without the rest
            problems.attempt((*at, "effects", i), lambda table=table: build_effect(table))  # type: ignore[misc]
        return None
    if model.certificate is not None:
        problems.add(
            (*at, "certificate"),
            "drawing machines that are consistent with a certificate is not built yet; give [errors], [repeatability] or [[effects]]",
        )
    chain = problems.attempt((*at, "structure"), lambda: parse_structure(model.structure))
    axes = {
        k: problems.attempt((*at, "axes", k, "travel"), lambda k=k, a=a: _axis(k, a))  # type: ignore[misc]
        for k, a in model.axes.items()
    }
    _check_axes(chain, axes, problems, at)
    effects, inputs = _known_errors(model, document, problems, at, chain, axes)
    effects += further_effects(tables_in(data, "effects"), chain, problems, at)
    effects = merged(effects)
    inputs += further_inputs(tables_in(data, "inputs"), effects, inputs, problems, at)
    if problems.found:
        return None
    state = model.errors.state if model.errors else "residual"
    active = tuple(model.errors.compensation) if model.errors else ()
    name = model.name or document.path.stem
    return problems.attempt(
        (*at, "structure"),
        lambda: Machine(name, model.kind, chain, axes, tuple(effects), tuple(inputs), state, active),  # type: ignore[arg-type]
    )


def tables_in(data: dict[str, Any], key: str) -> list[dict[str, Any]]:
    """The tables of a list such as [[effects]]; empty where the key holds something else."""
    found = data.get(key, [])
    return [t for t in found if isinstance(t, dict)] if isinstance(found, list) else []


def further_effects(
    tables: list[dict[str, Any]], chain: Chain | None, problems: Problems, at: Location
) -> list[Effect]:
    """The [[effects]] of a machine or scenario, on axes that the machine has."""
    out = []
    for i, table in enumerate(tables):
        here = (*at, "effects", i)
        built = problems.attempt(here, lambda table=table: build_effect(table))  # type: ignore[misc]
        if built is None:
            continue
        if chain and built.link in "XYZABC" and built.link not in chain.letters:
            key = next((f.name for f in place_fields(built)), "effect")
            problems.add(
                (*here, key),
                f'{built.id} acts on axis {built.link}, which is not in structure = "{chain.structure}"; '
                f"the axes are {', '.join(sorted(chain.letters))}",
            )
        out.append(built)
    return out


def further_inputs(
    tables: list[dict[str, Any]],
    effects: Sequence[Effect],
    known: Sequence[Input],
    problems: Problems,
    at: Location,
) -> list[Input]:
    """The [[inputs]] of a machine or scenario. One quantity has one input: its name is that of its random stream."""
    out: list[Input] = []
    for i, table in enumerate(tables):
        here = (*at, "inputs", i)
        found = problems.attempt(here, lambda table=table: build_input(table, effects))  # type: ignore[misc]
        if found is None:
            continue
        note_second(found, [*known, *out], problems, here)
        out.append(found)
    return out


def note_second(one: Input, known: Sequence[Input], problems: Problems, at: Location) -> None:
    """A quantity that has an input already would be drawn twice from one stream."""
    other = next((k for k in known if k.id == one.id), None)
    if other is not None:
        said = f" ({other.evidence})" if other.evidence else ""
        problems.add(at, f"{one.id} has an input already{said}; keep one of the two")


def merged(effects: Sequence[Effect]) -> list[Effect]:
    """Effects of one name and place added into one where all that differs are numbers in which they are linear.

    An Input names an effect by name and place: two of them (a table and a further known effect) would count twice.
    """
    out: list[Effect] = []
    for effect in effects:
        match = next((i for i, e in enumerate(out) if e.id == effect.id and _addable(e, effect)), None)
        if match is None:
            out.append(effect)
            continue
        linear = [f.name for f in parameter_fields(effect) if not f.metadata["scan"]]
        sums = {n: getattr(out[match], n) + getattr(effect, n) for n in linear}
        out[match] = replace(out[match], **sums)
    return out


def _addable(one: Effect, other: Effect) -> bool:
    linear = {f.name for f in parameter_fields(one) if not f.metadata["scan"]}
    rest = [f.name for f in fields(one) if f.name not in linear]
    return all(np.array_equal(getattr(one, n), getattr(other, n)) for n in rest)


def _check_axes(
    chain: Chain | None, axes: Mapping[str, Axis | None], problems: Problems, at: Location
) -> None:
    """structure and [axes] name the same axes."""
    if chain is None:
        return
    for letter in chain.letters:
        if letter not in axes:
            problems.add(
                (*at, "structure"),
                f'structure = "{chain.structure}" names axis {letter}, but there is no [axes.{letter}]; '
                f'add it with its travel, for example travel = ["0 mm", "600 mm"]',
            )
    for letter in axes:
        if letter not in chain.letters and letter in tuple("XYZABC"):
            problems.add(
                (*at, "axes", letter),
                f'[axes.{letter}] is not in structure = "{chain.structure}"; add it there or remove it',
            )


def _axis(letter: str, table: AxisTable) -> Axis:
    if letter not in tuple("XYZABC"):
        raise UsageError(f'unknown axis "{letter}".{choose_from(letter, list("XYZABC"))}')
    low, high = (
        quantity(t, "angle", "travel", "90 deg")
        if letter in "ABC"
        else quantity(t, "length", "travel", "600 mm")
        for t in table.travel
    )
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
    axes: Mapping[str, Axis | None],
) -> tuple[list[Effect], list[Input]]:
    effects: list[Effect] = []
    inputs: list[Input] = []
    if model.errors:
        here = (*at, "errors", "table")
        path = document.path.parent / model.errors.table
        cubic = model.errors.interpolation == "cubic"
        tables = problems.attempt(here, lambda: read_isg(path))
        found = problems.attempt(here, lambda: effects_of(tables, cubic)) if tables is not None else None
        for effect in found or ():
            _check_on_machine(effect, chain, axes, problems, here, path)
        effects += found or []
        inputs += _table_inputs(found or [], model.errors.uncertainty)
    if model.repeatability:
        repeatability = model.repeatability
        law = problems.attempt((*at, "repeatability"), lambda: _repeatability(repeatability))
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
    axes: Mapping[str, Axis | None],
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
        if table.dof is not None:
            raise UsageError('[repeatability] dof goes with law = "t"; remove dof or write law = "t"')
        if table.u is not None and table.scale is not None:
            raise UsageError("[repeatability] u and scale are both given; a normal law takes u")
        spread = table.u if table.u is not None else table.scale
        if spread is None:
            raise UsageError('[repeatability] law = "normal" needs u; write for example u = "0.5 um"')
        return Normal(spread)
    if table.u is not None:
        raise UsageError(
            '[repeatability] law = "t" takes scale, the scale parameter of the law, not u; rename u to scale '
            "(u = scale times the root of dof / (dof - 2))"
        )
    if table.scale is None or table.dof is None:
        raise UsageError(
            '[repeatability] law = "t" needs scale and dof; write for example scale = "0.7 um" and dof = 6'
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
