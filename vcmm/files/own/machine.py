"""Read machine files: machine/1 TOML to a Machine with its Inputs.

[tracked] of a machine file: its numbers were followed in time, and are known together as they were at a date.

    [tracked]
    at = "2026-12-01"                       # the date for which the file is valid
    last_check = "2026-11-20"               # the last recording that it knows
    covariance = "machine_state.csv"        # what the recordings leave
    since = "machine_since.csv"             # what may have changed from the last check until then

Both files are joint covariances (see vcmm.files.own.joint_covariance) whose rows are parameters of effects: their name as of Inputs and
the number of the element, "component_table[EXX].values" and 3, "backlash[X].gap" without one. Each becomes one Input of all of them; the second is
the line "time since calibration" of every budget.
"""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import replace
from itertools import groupby
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.core.axes import AXIS_NAMES, is_axis, is_rotary, unit_vector
from vcmm.core.effect import Effect
from vcmm.core.errors import DataError, UsageError, choose_from
from vcmm.core.expansions import unusual_expansion
from vcmm.core.inputs import SINCE, STATE, Input
from vcmm.core.kinematics import Axis, Chain, parse_structure
from vcmm.core.knowledge import add_knowledge, merge_effects
from vcmm.core.laws import MultivariateNormal, Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.core.units import quantity
from vcmm.files.own.certificate_keys import certificate_remarks
from vcmm.files.own.effects import build_effect
from vcmm.files.own.joint_covariance import read_joint_covariance
from vcmm.files.own.knowledge import further_effects, further_inputs, names_in, tables_in
from vcmm.files.own.known_errors import known_errors
from vcmm.files.own.machine_tables import AxisTable, MachineFile, Tracked, found_machine
from vcmm.files.problems import Problems
from vcmm.files.schema import checked_model
from vcmm.files.toml import Document, Location, check_version, read_toml
from vcmm.physics.structure.residual import ResidualField
from vcmm.physics.structure.scatter import Scatter

if TYPE_CHECKING:
    from vcmm.task.certification.certificate import MachineCertificate
    from vcmm.task.certification.knowledge import CertifiedKnowledge


def tracked_inputs(table: Tracked, folder: Path, effects: Sequence[Effect]) -> list[Input]:
    """Return the Inputs of [tracked]. Raises DataError and UsageError for files and names that do not fit the effects."""
    label = f"followed until {table.last_check}"
    out = [_joint_input(folder / table.covariance, effects, "", label)]
    if table.since is not None:
        later = f"from the last check, {table.last_check}, until {table.at}"
        out.append(_joint_input(folder / table.since, effects, SINCE, later))
    return out


def _joint_input(path: Path, effects: Sequence[Effect], cause: str, label: str) -> Input:
    joint = read_joint_covariance(path)
    members, widths, at = [], [], 0
    for name, rows in groupby(joint.errors):
        count = len(list(rows))
        member = _member(path, name, joint.position[at : at + count], effects)
        members.append(Input(member.name, member.where, name.rpartition(".")[2], Normal(1.0), cause=cause))
        widths.append(count)
        at += count
    law = MultivariateNormal(
        joint.factor @ joint.factor.T
    )  # what the digits of the file leave below zero is rounding
    return Input(
        "", "", STATE, law, "machine", label, members=tuple(members), cause=cause, widths=tuple(widths)
    )


def _member(path: Path, name: str, element: Array, effects: Sequence[Effect]) -> Effect:
    """Return the effect of a row. Raises UsageError where there is none, and DataError where its elements are others."""
    place, _, parameter = name.rpartition(".")
    hit = next((e for e in effects if e.id == place), None)
    if hit is None or not hasattr(hit, parameter):
        names = [f"{e.id}.{e.about.table_parameter}" if e.about.table_parameter else e.id for e in effects]
        raise UsageError(
            f'{path}: "{name}" is no parameter of an effect of the machine.{choose_from(name, names)}'
        )
    size = int(np.size(getattr(hit, parameter)))
    due = np.full(1, np.nan) if np.ndim(getattr(hit, parameter)) == 0 else np.arange(float(size))
    if len(element) != len(due) or not np.array_equal(element, due, equal_nan=True):
        raise DataError(
            f"{path}: {name} has {size} numbers, but the file has {len(element)} rows of it or another order"
        )
    return hit


# mm: hand-held arms have 20 to 50 um; probes of machines, on CMMs and machine tools, 0.1 to 10 um
MOST_SCATTER = 0.05


def load_machine(path: str | Path) -> Machine:
    """Read a machine file (machine/1).

    Parameters
    ----------
    path
        The file.

    Returns
    -------
    Machine
        Structure, axes, effects, and what is known of them; mm, rad.

    Raises
    ------
    DataError
        Every problem of the file, each with its line.
    """
    document = read_toml(path)
    check_version(document, "machine")
    return machine_from(document, document.data, ())


def load_machine_of(path: str | Path) -> Machine:
    """Return the machine of a machine file or of a scenario, without the part's effects, as in its acceptance test.

    Of a machine of which only a certificate is known these are machines that pass it with all their errors together.
    """
    return machine_from(*found_machine(path), passing=True)


def machine_from(document: Document, data: dict[str, Any], at: Location, *, passing: bool = False) -> Machine:
    """Convert a machine table (a file, or [machine] of a scenario) to a Machine. Raises DataError with every problem.

    passing: errors that a certificate allows are those of machines that pass its test, and not all that each limit allows.
    """
    problems = Problems(document)
    machine = _checked_machine(document, data, at, problems, passing)
    problems.raise_if_any()
    assert machine is not None
    return machine


def _checked_machine(
    document: Document, data: dict[str, Any], at: Location, problems: Problems, passing: bool
) -> Machine | None:
    before = len(problems.found)
    model = checked_model(MachineFile, {"vcmm": "machine/1", **data}, problems, at)
    if model is None:
        for i, table in enumerate(tables_in(data, "effects")):  # what can be checked without the rest
            problems.attempt((*at, "effects", i), lambda table=table: build_effect(table))  # type: ignore[misc]
        return None
    chain = problems.attempt((*at, "structure"), lambda: parse_structure(model.structure))
    axes = {
        k: problems.attempt((*at, "axes", k, "travel"), lambda k=k, a=a: _axis(k, a))  # type: ignore[misc]
        for k, a in model.axes.items()
    }
    _check_axes(chain, names_in(data, "axes"), problems, at)
    effects, inputs = known_errors(model, data, document, problems, at, chain)
    effects += further_effects(tables_in(data, "effects"), chain, problems, at)
    complete = len(problems.found) == before
    if model.tracked is not None and complete:
        when, folder, whole = model.tracked, document.path.parent, merge_effects(effects)
        inputs += problems.attempt((*at, "tracked"), lambda: tracked_inputs(when, folder, whole)) or []
    inputs += further_inputs(tables_in(data, "inputs"), effects, inputs, problems, at, complete)
    if problems.found:
        return None
    errors = model.errors
    bare = problems.attempt(
        (*at, "structure"),
        lambda: Machine(
            name=model.name or document.path.stem, kind=model.kind, chain=chain, axes=axes,  # type: ignore[arg-type]
            state=errors.state if errors else "residual", load_limit=model.load_limit,
            compensation=tuple(errors.compensation) if errors else (), large_errors=model.large_errors,
            remarks=(*_of_scales(model), *repeatability_remarks(model, tables_in(data, "inputs"))),
            record=model.record.entries,
        ),
    )  # fmt: skip
    if bare is not None and model.certificate is not None:
        from vcmm.files.own.certificate import certificate_from

        stated = model.certificate
        machine, here = bare, (*at, "certificate")
        certificate = problems.attempt(here, lambda: certificate_from(stated))
        if certificate is None:
            return None
        knowledge = problems.attempt(here, lambda: _from_certificate(machine, model, certificate, passing))
        bare = replace(machine, remarks=(*machine.remarks, *certificate_remarks(stated, certificate)))
        effects += knowledge.effects if knowledge else ()
        inputs += knowledge.inputs if knowledge else ()
    return bare and problems.attempt((*at, "structure"), lambda: add_knowledge(bare, effects, inputs))


def _of_scales(model: MachineFile) -> tuple[str, ...]:
    scales = model.environment and model.environment.scales
    remark = unusual_expansion("[environment] scales expansion", scales.expansion) if scales else ""
    return (remark,) if remark else ()


def _from_certificate(
    machine: Machine, model: MachineFile, certificate: MachineCertificate, passing: bool
) -> CertifiedKnowledge | None:
    """Return the errors that the certificate implies, where the file itself does not state them; its scatter is that of the file."""
    from vcmm.task.certification.knowledge import certified_knowledge, passing_machines

    if model.errors is not None or model.effects:
        return None
    knowledge = (
        passing_machines(machine, certificate) if passing else certified_knowledge(machine, certificate)
    )
    if model.repeatability is None:
        return knowledge
    return replace(
        knowledge,
        effects=tuple(e for e in knowledge.effects if not isinstance(e, Scatter)),
        inputs=tuple(i for i in knowledge.inputs if i.effect != Scatter.name),
    )


def _check_axes(chain: Chain | None, names: list[str] | None, problems: Problems, at: Location) -> None:
    """Check that structure and [axes] name the same axes."""
    if chain is None or names is None:
        return
    for letter in chain.letters:
        if letter not in names:
            problems.add(
                (*at, "structure"),
                f'structure = "{chain.structure}" names axis {letter}, but there is no [axes.{letter}]; '
                f'add it with its travel, for example travel = ["0 mm", "600 mm"]',
            )
    for letter in names:
        if letter not in chain.letters and is_axis(letter):
            problems.add(
                (*at, "axes", letter),
                f'axis {letter} is not in structure = "{chain.structure}"; add it there or remove [axes.{letter}]',
            )


def _axis(letter: str, table: AxisTable) -> Axis:
    if not is_axis(letter):
        raise UsageError(f'unknown axis "{letter}"; allowed are {AXIS_NAMES}')
    dynamics = _dynamics(letter, table.dynamics.model_dump())
    direction = _direction(letter, table)
    if table.travel == ["endless"]:
        if not is_rotary(letter):
            raise UsageError(
                f'travel of {letter} is "endless": only rotary axes turn on and on; write its ends, as in ["0 mm", "600 mm"]'
            )
        turn = (0.0, 2.0 * math.pi)
        return Axis(
            letter, turn, centre=table.centre, measured_at=table.measured_at, error_frame=table.error_frame, dynamics=dynamics, is_endless=True,
            direction=direction,
        )  # fmt: skip
    low, high = (
        quantity(t, "angle", "travel", "90 deg")
        if is_rotary(letter)
        else quantity(t, "length", "travel", "600 mm")
        for t in table.travel
    )
    if not low < high:
        raise UsageError(
            f"travel of {letter} runs from {table.travel[0]} to {table.travel[1]}; the first end must be the lower one"
        )
    return Axis(
        letter, (low, high), table.centre, table.measured_at, table.error_frame, dynamics, direction=direction
    )


def _direction(letter: str, table: AxisTable) -> tuple[float, float, float] | None:
    """Return the direction of a rotary axis that is not the one of its letter. Raises UsageError for a linear axis: programs and maps
    hold X, Y, Z."""
    if table.direction is None:
        return None
    if not is_rotary(letter):
        raise UsageError(
            f"direction of {letter}: only rotary axes have one of their own; programs, scales and maps hold X, Y and Z of the machine frame. "
            "Describe a slide that travels askew by the squareness, and leave direction out"
        )
    size = math.hypot(*table.direction)
    if not size:
        raise UsageError(
            f"direction of {letter} is zero; write the line that it turns about, as in [0, 1, 1]"
        )
    x, y, z = (v / size for v in table.direction)
    direction = tuple(float(v) for v in unit_vector(letter))
    return None if (x, y, z) == direction else (x, y, z)


def _dynamics(letter: str, table: dict[str, str | float | None]) -> dict[str, float]:
    """Return speed, acceleration and jerk in mm (rotary axes: rad) and s; gain in 1/s; feed-forward as a share."""
    out: dict[str, float] = {}
    for key, value in table.items():
        if isinstance(value, str):
            dimension = f"angular {key}" if is_rotary(letter) else key
            out[key] = quantity(value, dimension, f"dynamics.{key} of axis {letter}")
        elif value is not None:
            out[key] = value
    return out


__all__ = ["MachineFile", "load_machine", "machine_from"]


def repeatability_remarks(model: MachineFile, inputs: Sequence[Mapping[str, Any]]) -> tuple[str, ...]:
    """Return remarks on scatter out of the usual range, or stated twice. inputs: the tables [[inputs]] of the file."""
    if model.repeatability is None:
        return ()
    stated = model.repeatability
    key, spread = ("u", stated.u) if stated.u is not None else ("scale", stated.scale)
    out = []
    if spread is not None and spread > MOST_SCATTER:
        out.append(
            f'[repeatability] {key} = "{spread:g} mm": usual are 0.1 to 10 um, of arms up to 50 um: check the unit and the decimal point'
        )
    if any(i.get("effect") == ResidualField.name and i.get("parameter") == "random" for i in inputs):
        out.append(ResidualField.counted_twice)
    return tuple(out)
