"""Reversals of a straightness beside other recordings: the separated curves as readings of one joint fit.

The artefact is in no other recording, so the separated curve with its covariance holds all information of the scans about the machine:

    curve m = G theta + zero + slope x + noise of covariance C      L L' = C / u^2, then L^-1 m has independent noise u
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.axes import unit_vector
from vcmm.core.errors import UsageError
from vcmm.core.laws import Normal
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.learn.calibration.readings import Readings
from vcmm.learn.calibration.reversal import ReversalFile, ReversalResult, separate, student_variance
from vcmm.task.response.recording import Recording

LINES = ("zero", "slope")


def reversed_recordings(
    files: Sequence[ReversalFile], machine: Machine
) -> tuple[list[Recording], dict[str, Array]]:
    """Return per file the separated straightness as a recording, and recording name -> its covariance (k, k) mm^2.

    Raises UsageError for other reversals, and for an axis that the machine lacks.
    """
    for file in files:
        if file.kind != "straightness":
            raise UsageError(
                f'{file.name}: a reversal with test = "{file.kind}" separates by itself; beside other recordings only a straightness reversal '
                "is fitted. Calibrate it alone with --out spindle.toml, then the other recordings with --machine spindle.toml"
            )
        if file.axis not in machine.chain.letters:
            raise UsageError(
                f'{file.name} is about axis {file.axis}, which structure = "{machine.chain.structure}" lacks'
            )
    results = [separate(file) for file in files]
    recordings = [_recording(result, machine) for result in results]
    return recordings, {r.name: _covariance(result) for r, result in zip(recordings, results)}


def whiten_readings(part: Readings, covariance: Array) -> Readings:
    """Return the readings with independent noise of their u, when it has this covariance (m, m); zero and slope among the nuisance."""
    lines = np.linalg.qr(part.nuisance)[0]
    full = (
        covariance + float(np.trace(covariance)) / part.m * lines @ lines.T
    )  # the lines are free: any variance serves
    size, ways = np.linalg.eigh(full / part.u[0] ** 2)
    half = ways / np.sqrt(np.maximum(size, 1e-6 * size[-1])) @ ways.T
    unknowns = tuple((name, half @ columns) for name, columns in part.instrument_errors)
    return replace(
        part,
        errors=half @ part.errors,
        instrument_errors=unknowns,
        nuisance=half @ part.nuisance,
        value=half @ part.value,
    )


def _recording(result: ReversalResult, machine: Machine) -> Recording:
    """Return the curve at its nodes, tip at the place from which the machine file counts its errors: without an arm of a rotation."""
    assert result.straight is not None
    file, nodes = result.file, result.straight.nodes
    k = len(nodes)
    position = {a: nodes if a == file.axis else np.zeros(k) for a in machine.chain.letters}
    sign = -1.0 if file.axis in machine.chain.work else 1.0  # the workpiece moves, the tip errs the other way
    direction = np.tile(sign * unit_vector(file.error[1]), (k, 1))
    columns = {f"n{c}": direction[:, i] for i, c in enumerate("xyz")}
    return Recording(
        name=file.name,
        kind="displacement",
        run=Run(position, np.zeros((k, 3)), columns),
        value=result.straight.machine,
        measuring=False,
        row=np.arange(k),
        direction=direction,
        other=np.full(k, -1, dtype=np.intp),
        nuisance=dict.fromkeys(LINES, ""),
        noise=Normal(float(np.sqrt(np.trace(_covariance(result)) / k))),
    )


def _covariance(result: ReversalResult) -> Array:
    assert result.straight is not None
    return result.straight.covariance * student_variance(result.straight.dof)


def read_jointly(parts: Sequence[Readings], correlated: Mapping[str, Array]) -> list[Readings]:
    """Return the readings, those with a joint covariance whitened by it. correlated: recording name -> (m, m) mm^2."""
    return [
        whiten_readings(p, correlated[p.recording.name]) if p.recording.name in correlated else p
        for p in parts
    ]
