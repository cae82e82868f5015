"""A calibrated machine as files: machine.toml, its error table, and the joint covariance of the table."""

from __future__ import annotations

import json
from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vcmm.core.axes import is_location
from vcmm.core.effect import place_fields
from vcmm.core.errors import UsageError
from vcmm.core.inputs import Input, JointCovariance
from vcmm.core.kinematics import Axis
from vcmm.core.laws import MultivariateNormal, Normal, StudentT
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.files.foreign.isg import ErrorFile, ErrorTable, isg_text
from vcmm.files.learned.effect_text import effect_toml, input_toml
from vcmm.files.own.joint_covariance import covariance_text
from vcmm.files.own.known_errors import read_error_file
from vcmm.files.toml_edits import editable, move_names, without_table
from vcmm.learn.calibration.model import LINEAR, Curve, curve_effect, number_of
from vcmm.learn.calibration.result import Calibration, rms
from vcmm.physics import BY_NAME
from vcmm.physics.structure.lost_motion_table import LostMotionTable
from vcmm.physics.structure.scatter import Scatter

CHANCE = 0.01  # a lost motion that chance would make so often is none


def residual_texts(
    calibration: Calibration, target: Path, sources: Sequence[str], prior: Path | None, switched_on: str
) -> dict[str, str]:
    """Return the machine with the compensated errors: tables of zeros with the covariance of the remainder, state "residual".

    switched_on: name of the compensation. A lost motion stays: no table of errors over a travel compensates it.
    """
    names, _ = calibration.kept_model.labels
    left = np.where([name[0] == "B" and len(name) == 2 for name in names], calibration.theta, 0.0)
    machine = replace(
        calibration.machine, state="residual", compensation=(*calibration.machine.compensation, switched_on)
    )
    return machine_texts(replace(calibration, theta=left, machine=machine), target, sources, prior)


def machine_texts(
    calibration: Calibration, target: Path, sources: Sequence[str], prior: Path | None = None
) -> dict[str, str]:
    """Return file name -> text: STEM.toml as `target` says, STEM_errors.csv, STEM_covariance.csv beside it.

    sources: names of the recordings. prior: the machine file that the calibration started from; its content beside the error
    table stays, with its comments.
    """
    table, covariance = f"{target.stem}_errors.csv", f"{target.stem}_covariance.csv"
    evidence = f"calibrated from {', '.join(sources)}"
    names, nodes = calibration.kept_model.labels
    stored = np.array([not (n[0] == "B" and len(n) == 2) for n in names])
    joint = JointCovariance(
        tuple(n for n, s in zip(names, stored) if s),
        nodes[stored],
        calibration.covariance[np.ix_(stored, stored)],
    )
    errors = _errors(calibration, table, covariance, evidence)
    if prior is None:
        text = bare_text(calibration.machine) + errors + _repeatability(calibration)
    else:
        text = f"{_without_errors(prior, target.parent, calibration.kept_model.names).rstrip()}\n\n{errors}"
    reversals = "".join(_reversal(calibration, c) for c in calibration.kept_model.curves if c.reversal)
    return {
        f"{target.stem}.toml": text + reversals,
        table: isg_text(error_file(calibration), evidence),
        covariance: covariance_text(joint),
    }


def error_file(calibration: Calibration) -> ErrorFile:
    """Return one table per axis over its nodes, and the squareness."""
    tables, model = [], calibration.kept_model
    curves = [c for c in model.curves if not c.reversal]
    for axis in dict.fromkeys(c.axis for c in curves):
        mine = [c for c in curves if c.axis == axis]
        values: dict[str, Array] = {c.component: calibration.theta[model.slices[c.component]] for c in mine}
        tables.append(ErrorTable((axis,), (mine[0].nodes,), values, 0))
    return ErrorFile(tuple(tables), {p: float(calibration.theta[model.slices[p]][0]) for p in model.pairs})


def _errors(calibration: Calibration, table: str, covariance: str, evidence: str) -> str:
    """Return [errors], with errors that are not identified in comments."""
    named = ", ".join(f'"{c}"' for c in calibration.machine.compensation)
    on = f"compensation = [{named}]\n" if named else ""
    missing = "".join(f"# not identified: {c.text}\n" for c in calibration.identified.combinations)
    return (
        f'{missing}[errors]\ntable = "{table}"\ninterpolation = "{between(calibration)}"\nstate = "{calibration.machine.state}"\n'
        f'{on}covariance = "{covariance}"\nevidence = "{evidence}"\n'
    )


def between(calibration: Calibration) -> str:
    """Return the interpolation of the file between its nodes: that of the fit."""
    return "linear" if any(c.kind == LINEAR for c in calibration.kept_model.curves) else "cubic"


def _reversal(calibration: Calibration, curve: Curve) -> str:
    """Return a lost motion as an effect with its Input; nothing where it does not differ from zero by more than chance."""
    from scipy.special import chdtrc

    part = calibration.kept_model.slices[curve.component]
    value, covariance = calibration.theta[part], calibration.covariance[part, part]
    if chdtrc(len(value), float(value @ np.linalg.pinv(covariance, rcond=1e-6) @ value)) > CHANCE:
        return f"# lost motion of {curve.axis}: none beyond chance\n"
    effect = curve_effect(curve, value)
    reversal_input = Input(
        effect.name, curve.axis, number_of(effect), MultivariateNormal(covariance), "machine", ""
    )
    return effect_toml(effect) + input_toml(effect, reversal_input, "this calibration").replace(
        "diagnosed from", "fitted in"
    )


def bare_text(machine: Machine) -> str:
    """Return a machine file without errors: structure, travels, dynamics, places of rotary axes and of measured errors."""
    lines = ['vcmm = "machine/1"', f'name = "{machine.name}"', f'kind = "{machine.kind}"']
    lines.append(f'structure = "{machine.chain.structure}"')
    for letter, axis in machine.axes.items():
        unit, scale = ("deg", 180 / np.pi) if axis.rotary else ("mm", 1.0)
        low, high = (f'"{q * scale:.10g} {unit}"' for q in axis.travel)
        travel = '"endless"' if axis.is_endless else f"[{low}, {high}]"
        lines += [f"[axes.{letter}]", f"travel = {travel}"]
        for key, place in (
            ("centre", axis.centre if any(axis.centre) else None),
            ("measured_at", axis.measured_at),
        ):
            if place is not None:
                texts = [f'"{c:.10g} mm"' for c in place]
                lines.append(f"{key} = [{', '.join(texts)}]")
        if axis.direction is not None:
            lines.append(f"direction = [{', '.join(f'{c:.17g}' for c in axis.direction)}]")
        lines += [f'error_frame = "{axis.error_frame}"'] if axis.error_frame != "moving" else []
        lines += [f"dynamics = {{ {_dynamics_text(axis)} }}"] if axis.dynamics else []
    if machine.record:
        lines += ["[record]", *(f"{key} = {json.dumps(text)}" for key, text in machine.record.items())]
    return "\n".join(lines) + "\n"


def _dynamics_text(axis: Axis) -> str:
    """Return speed, acceleration, jerk, gain and feed-forward in the form in which they are read, such as speed = "500 mm/s"."""
    length = "rad" if axis.rotary else "mm"
    units = {"speed": f"{length}/s", "acceleration": f"{length}/s^2", "jerk": f"{length}/s^3", "gain": "1/s"}
    texts = {k: f"{v:.10g}" if k not in units else f'"{v:.10g} {units[k]}"' for k, v in axis.dynamics.items()}
    return ", ".join(f"{k} = {v}" for k, v in texts.items())


def stated_repeatability(machine: Machine) -> str:
    """Return [repeatability] of a machine that states it by a normal or t law of one number; nothing for another."""
    for item in machine.inputs:
        if item.effect == Scatter.name and isinstance(item.law, Normal | StudentT):
            t = item.law.dof if isinstance(item.law, StudentT) else None
            key, law = ("u", "normal") if t is None else ("scale", "t")
            dof = "" if t is None else f"dof = {t:.10g}\n"
            return f'[repeatability]\nlaw = "{law}"\n{key} = "{item.law.scale * 1e3:.10g} um"\n{dof}'
    return ""


def _repeatability(calibration: Calibration) -> str:
    """Return the scatter of a touch, where the machine itself probed."""
    touches = [
        e for r, e in zip(calibration.readings, calibration.posterior.residual) if r.recording.kind == "probe"
    ]
    if not touches:
        return ""
    left = sum(r.m for r in calibration.readings) / max(
        sum(r.m for r in calibration.readings) - calibration.posterior.numbers_used, 1.0
    )
    u = rms(np.concatenate(touches)) * np.sqrt(left)
    return f'[repeatability]                # scatter of the touches of this calibration\nlaw = "normal"\nu = "{u * 1e3:.3g} um"\n'


def _without_errors(prior: Path, folder: Path, names: Sequence[str]) -> str:
    """Return a machine file without [errors] and without its other statements about these errors, as a file in `folder`."""
    document = editable(prior)
    _check_locations(document, prior, names)
    without_table(document, "errors")
    for key in ("inputs", "effects"):
        stated = document.get(key, [])
        for i in reversed(range(len(stated))):
            if _says_of(stated[i], names):
                del stated[i]
        if key in document and not len(stated):
            document.remove(key)
    move_names(document, prior.parent, folder)
    return str(document.as_string())


def _check_locations(document: Any, prior: Path, names: Sequence[str]) -> None:
    """Raise UsageError where the error table of a machine file places a rotary axis, and the new one would not."""
    table = document.get("errors", {}).get("table")
    constants = read_error_file(prior.parent / str(table)).constants if table else {}
    located = [name for name in constants if is_location(name) and name not in names]
    if located:
        raise UsageError(
            f"{prior}: the error table states {' '.join(located)}, which the new table would not; state it as "
            '[[effects]] effect = "rotary_location" instead'
        )


def _says_of(table: Mapping[str, object], names: Sequence[str]) -> bool:
    """Return whether an [[effects]] or [[inputs]] table states one of the errors of these names (EXX, C0Y, BX)."""
    kind = BY_NAME.get(str(table.get("effect")))
    if kind is None or not kind.about.is_calibrated:
        return False
    where = [str(table[f.name]) for f in place_fields(kind) if f.name in table]
    return not where or (f"B{where[0]}" if issubclass(kind, LostMotionTable) else where[0]) in names
