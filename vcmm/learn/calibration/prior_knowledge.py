"""Prior knowledge of a machine file about the errors, at the nodes of a calibration: numbers and a factor of their covariance.

Remarks of a calibration: assumptions, contradicted statements, unchanged errors.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.axes import LETTERS, is_rotary
from vcmm.core.effect import COLUMN, Effect, basis, known_range, own_nodes
from vcmm.core.inputs import EVERY, Input
from vcmm.core.laws import MultivariateNormal, MultivariateSamples
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.learn.calibration.identifiability import Identifiability
from vcmm.learn.calibration.model import Curve, ErrorModel, gauge
from vcmm.learn.calibration.readings import Readings
from vcmm.learn.calibration.solve import ErrorPosterior
from vcmm.physics.structure.component import CalibrationModes, ComponentSpline, ComponentTable
from vcmm.physics.structure.lost_motion_table import LostMotionTable
from vcmm.task.response.observe import missing_columns

TABLES = (ComponentTable, ComponentSpline)


@dataclass(frozen=True, eq=False)
class PriorKnowledge:
    """theta (size,): errors of the file by the conventions of the model; factor (size, r): of their covariance.

    names: errors that the file states.
    """

    theta: Array
    factor: Array
    names: tuple[str, ...]


def known_errors_of(machine: Machine, model: ErrorModel) -> PriorKnowledge:
    """Return errors and their covariance as the machine file has them. Raises ModelLimit where its tables do not reach the nodes."""
    calibrated = [e for e in machine.effects if e.about.is_calibrated]
    names = tuple(n for n in model.names if any(name_of(e) == n for e in calibrated))
    theta = np.zeros(model.size)
    for effect in calibrated:
        place = _place(model, effect)
        if place is not None:
            part, run, column = place
            theta[part] += effect.error_motion(run)[:, column] * _reading_of(effect)
    blocks = [b for item in machine.inputs if (b := _input(machine, model, item)) is not None]
    factor = np.concatenate(blocks, axis=1) if blocks else np.zeros((model.size, 0))
    if not names and not blocks:
        return PriorKnowledge(theta, factor, names)
    convention = gauge(model, machine)
    for curve in (
        c for c in model.curves if c.rotary
    ):  # about the line that the file states: nothing is taken off
        convention[model.slices[curve.component], model.slices[curve.component]] = np.eye(len(curve.nodes))
    return PriorKnowledge(convention @ theta, convention @ factor, names)


def known_ranges(machine: Machine) -> dict[str, tuple[float, float]]:
    """Return linear axis -> (low, high) mm over which the machine file tabulates errors: where all its tables reach."""
    out: dict[str, tuple[float, float]] = {}
    for effect in machine.effects:
        for span in known_range(effect) if effect.about.is_calibrated else ():
            if "XYZ"[span.direction] == effect.link:
                low, high = out.get(effect.link, (-np.inf, np.inf))
                out[effect.link] = (max(low, span.low), min(high, span.high))
    return out


def known_turns(machine: Machine) -> dict[str, Array]:
    """Return rotary axis -> nodes (k,) rad of the errors that the machine file tabulates over it; of tables that differ the longest."""
    out: dict[str, Array] = {}
    for effect in machine.effects:
        nodes = (
            own_nodes(effect)
            if effect.about.is_calibrated and is_rotary(effect.link) and isinstance(effect, TABLES)
            else None
        )
        if nodes is not None and len(nodes) > len(out.get(effect.link, ())):
            out[effect.link] = np.asarray(nodes)
    return out


def known_nodes(machine: Machine) -> int:
    """Return the largest number of nodes of an error over its linear axis in the machine file; 0 where it tabulates none."""
    nodes_of = [own_nodes(e) for e in machine.effects if e.about.is_calibrated and e.link in "XYZ"]
    return max((len(nodes) for nodes in nodes_of if nodes is not None), default=0)


def name_of(effect: Effect) -> str:
    """Return the name of an error: EXX, C0Y; BX for a lost motion."""
    return f"B{effect.link}" if isinstance(effect, LostMotionTable) else effect.where


def _reading_of(effect: Effect) -> float:
    """Return the factor of the reading: a lost motion shows as -1/2 of its gap in positive sense."""
    return -2.0 if isinstance(effect, LostMotionTable) else 1.0


def _place(model: ErrorModel, effect: Effect) -> tuple[slice, Run, int] | None:
    """Return (numbers of theta, run over the nodes, column of the six error motions) of an effect; None for another error."""
    name = name_of(effect)
    if name not in model.slices:
        return None
    curve = next((c for c in model.curves if c.component == name), None)
    nodes = np.zeros(1) if curve is None else curve.nodes
    axis = effect.link
    letters = {*LETTERS, axis}
    position = {a: nodes if a == axis else np.zeros(len(nodes)) for a in letters}
    run = Run(position, np.zeros((len(nodes), 3)), {f"sense_{axis}": np.ones(len(nodes))})
    return model.slices[name], run, COLUMN[_letter(name, curve)]


def _letter(name: str, curve: Curve | None) -> str:
    if curve is None:
        return name[0]
    return name[1]


def _input(machine: Machine, model: ErrorModel, item: Input) -> Array | None:
    """Return how one draw of unit variance of an Input moves theta, (size, r); None where it does not."""
    if item.is_channel or item.redraw != "machine":
        return None
    total = _parameter_shift(machine, model, item)
    return None if total is None else total @ _factor(item, total.shape[1])


def _parameter_shift(machine: Machine, model: ErrorModel, item: Input) -> Array | None:
    """Return theta per unit of each element of an Input, (size, k); None where it does not move."""
    if item.members:
        parts = [_parameter_shift(machine, model, m) for m in item.members]
        whole = [
            np.zeros((model.size, width)) if part is None else part
            for part, width in zip(parts, item.member_widths)
        ]
        return None if all(part is None for part in parts) else item.join_responses(whole)
    total: Array | None = None
    for effect in machine.effects:
        if effect.name != item.effect or item.where not in (EVERY, effect.where):
            continue
        place = (
            _place(model, effect)
            if effect.about.is_calibrated or isinstance(effect, CalibrationModes)
            else None
        )
        if place is None or missing_columns(effect, place[1]):
            continue
        part, run, column = place
        unit = basis(effect, item.parameter, run)[:, column, :] * _reading_of(effect)
        block = np.zeros((model.size, unit.shape[1]))
        block[part] = unit
        total = block if total is None else total + block
    return total


def _factor(item: Input, k: int) -> Array:
    law, factor = item.spread(k)
    if isinstance(law, MultivariateSamples):
        return MultivariateNormal(law.covariance).factor
    return factor * law.u


WRONG_UNIT = {"angle": "arcsec taken for urad are 4.848 times too small"}  # of lengths: mm taken for um


def as_before(identifiability: Identifiability, prior: PriorKnowledge) -> list[str]:
    """Return the errors that are taken over from the machine file unchanged."""
    kept = [n for n in prior.names if n not in identifiability.names]
    if not kept:
        return []
    return [
        f"{', '.join(kept)}: no reading of the recordings shows whether they changed; the values of the machine file are kept"
    ]


def assumption_remarks(
    parts: Sequence[Readings], post: ErrorPosterior, only: Sequence[str], stated: bool
) -> list[str]:
    """Return sentences about assumptions and contradicted statements."""
    out = [a for p in parts for a in p.assumptions]
    if only:
        rest = "stays as the machine file has it" if stated else "was taken as zero"
        out.append(f"only {', '.join(only)} were looked for; every other error {rest}")
    for part, noise in zip(parts, post.noise):
        name = part.recording.name
        if not part.stated:
            unit, scale = ("urad", 1e6) if part.recording.kind == "angle" else ("um", 1e3)
            out.append(
                f"{name}: the noise is not stated; the residuals say {noise.u * part.u[0] * scale:.2g} {unit}"
            )
        elif noise.scale > 1.0 and np.isinf(noise.dof):
            out.append(
                f"{name}: the residuals are {noise.scale:.2f} times the stated noise, which was raised by that"
            )
        if noise.quiet < 1.0:
            unit = WRONG_UNIT.get(part.recording.kind, "mm taken for um are 1000 times too small")
            out.append(
                f"{name}: the residuals are only {noise.quiet:.2g} times the stated noise: check the unit of its values ({unit}), or state "
                "the noise that it has"
            )
        if noise.outliers.any():
            out.append(
                f"{name}: {int(noise.outliers.sum())} outliers carry little weight: {part.recording.places(noise.outliers)}"
            )
    for name, value in zip(post.instrument_names, post.instrument_errors):
        if abs(value) > 3:
            out.append(
                f"{name}: the readings pull it by {value:+.1f} times its stated u; check its certificate"
            )
    return out
