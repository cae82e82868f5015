"""A calibrated machine as files: machine.toml, its error table, and the joint covariance of the table."""

from __future__ import annotations

import re
from collections.abc import Sequence

import numpy as np

from vcmm.calibrating.result import Calibration, rms
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.files.isg import ErrorFile, ErrorTable
from vcmm.files.isg_writer import isg_text
from vcmm.files.joint_covariance import JointCovariance, covariance_text


def machine_texts(found: Calibration, stem: str, sources: Sequence[str], prior: str = "") -> dict[str, str]:
    """File name -> text: STEM.toml, STEM_errors.csv, STEM_covariance.csv.

    sources: names of the recordings. prior: text of the machine file that the calibration started from; what it says beside
    the error table stays.
    """
    table, covariance = f"{stem}_errors.csv", f"{stem}_covariance.csv"
    said = f"calibrated from {', '.join(sources)}"
    names, nodes = found.kept.labels
    return {
        f"{stem}.toml": _toml(found, table, covariance, said, prior),
        table: isg_text(error_file(found), said),
        covariance: covariance_text(JointCovariance(names, nodes, found.covariance)),
    }


def error_file(found: Calibration) -> ErrorFile:
    """One table per axis over its nodes, and the squareness."""
    tables, model = [], found.kept
    for axis in dict.fromkeys(c.axis for c in model.curves):
        mine = [c for c in model.curves if c.axis == axis]
        values: dict[str, Array] = {c.component: found.theta[model.slices[c.component]] for c in mine}
        tables.append(ErrorTable((axis,), (mine[0].nodes,), values, 0))
    return ErrorFile(tuple(tables), {p: float(found.theta[model.slices[p]][0]) for p in model.pairs})


def _toml(found: Calibration, table: str, covariance: str, said: str, prior: str) -> str:
    missing = "".join(f"# not identified: {c.text}\n" for c in found.identified.combinations)
    errors = (
        f'{missing}[errors]\ntable = "{table}"\ninterpolation = "cubic"\nstate = "{found.machine.state}"\n'
        f'covariance = "{covariance}"\nevidence = "{said}"\n'
    )
    if prior:
        return _without_errors(prior).rstrip() + "\n\n" + errors
    return _head(found.machine) + errors + _repeatability(found)


def _head(machine: Machine) -> str:
    lines = ['vcmm = "machine/1"', f'name = "{machine.name}"', f'kind = "{machine.kind}"']
    lines.append(f'structure = "{machine.chain.structure}"')
    for letter, axis in machine.axes.items():
        unit, scale = ("deg", 180 / np.pi) if axis.rotary else ("mm", 1.0)
        low, high = (f'"{q * scale:.10g} {unit}"' for q in axis.travel)
        lines += [f"[axes.{letter}]", f"travel = [{low}, {high}]"]
    return "\n".join(lines) + "\n"


def _repeatability(found: Calibration) -> str:
    """Scatter of a touch, where the machine itself probed."""
    touches = [e for r, e in zip(found.readings, found.posterior.residual) if r.recording.kind == "probe"]
    if not touches:
        return ""
    left = sum(r.m for r in found.readings) / max(sum(r.m for r in found.readings) - found.posterior.used, 1.0)
    u = rms(np.concatenate(touches)) * np.sqrt(left)
    return f'[repeatability]                # scatter of the touches of this calibration\nlaw = "normal"\nu = "{u * 1e3:.3g} um"\n'


def _without_errors(text: str) -> str:
    """A machine file without [errors] and without what is said of single components elsewhere."""
    kept, skip = [], False
    blocks = re.split(r"(?m)^(?=\s*\[)", text)
    for block in blocks:
        head = block.strip().split("\n", 1)[0].strip()
        skip = head.startswith("[errors") or (
            head.startswith(("[[inputs]]", "[[effects]]"))
            and re.search(r'(?m)^\s*effect\s*=\s*"(component_table|component_spline|squareness)"', block) is not None
        )
        if not skip:
            kept.append(block)
    return "".join(kept)
