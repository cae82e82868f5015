"""Indexing: large offsets of counters (nuisance `index`) are taken out on the exact chain before anything is linearised.

A first-order method errs by half the square of an angle: 5 deg leave 4 mrad. The index of every axis is therefore
fitted by Gauss-Newton: the nuisance is fitted to the residual, the readings move by the result, and the nominal
positions, directions and observations are worked out anew by multiplying the transforms, until nothing moves. What is
left is small; the nuisance keeps its column, so the index stays free in every later fit.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import nominal_tip
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.task.response.nuisance import nuisance_columns
from vcmm.task.response.observe import Observer
from vcmm.task.response.pointing import POINTING_COLUMNS, pointing_observations
from vcmm.task.response.recording import Recording

ROUNDS = 100
NO_AXIS_MOTION = 1e-9  # mm or rad
MOST_FIRST_ORDER = 1e-3  # rad or mm up to which first order will do, where nothing better can be had


def settle_index(recording: Recording, machine: Machine) -> Recording:
    """Return the recording about the indices that fit it best (`recording.index`); unchanged without the nuisance `index`.

    Raises ModelLimit where the fit does not settle, where the moved axes leave their travel, or where an angle or a length
    is known about one axis only and the index is not small.
    """
    if "index" not in recording.nuisance:
        return recording
    if "tip_x_mm" in recording.run.columns:
        raise UsageError("index moves the axes, but tip_x_mm states where the tip is; remove these columns")
    total: dict[str, float] = {}
    for _ in range(ROUNDS):
        step = _step(recording, machine)
        if max(map(abs, step.values()), default=0.0) < NO_AXIS_MOTION:
            return replace(recording, index=total)
        total = {name: total.get(name, 0.0) + d for name, d in step.items()}
        _check_exact(recording, total)
        recording = move_readings(recording, machine, step)
    raise ModelLimit(
        f"the index of the axes does not settle ({_text(total)} after {ROUNDS} rounds); check structure, senses and units"
    )


def _step(recording: Recording, machine: Machine) -> dict[str, float]:
    """Change of every index by the least-squares fit of the whole nuisance."""
    columns, names = nuisance_columns(recording, machine)
    rest = recording.value - Observer(recording, machine).baseline()
    length = np.linalg.norm(columns, axis=0)
    scaled = columns / np.where(length > 0, length, 1.0)
    fit = np.linalg.lstsq(scaled, rest, rcond=1e-9)[0] / np.where(length > 0, length, 1.0)
    return {
        _place(name): float(c) for name, c, s in zip(names, fit, length) if name.startswith("index") and s > 0
    }


def _place(name: str) -> str:
    """Convert a nuisance to a place: index[setup=2].C -> C[setup=2]."""
    label, axis = name.removeprefix("index").rsplit(".", 1)
    return axis + label


def move_readings(recording: Recording, machine: Machine, step: dict[str, float]) -> Recording:
    """Return the same observations with the readings moved, exactly: nominal tip, direction and value are computed anew."""
    run, label = recording.run, recording.nuisance["index"]
    position = {a: np.array(q, dtype=float) for a, q in run.position.items()}
    for name, d in step.items():
        axis, word = name.partition("[")[0], name.partition("=")[2].removesuffix("]")
        rows = run.labels[label] == word if word else np.ones(run.n, dtype=bool)
        position[axis][rows] += d
    there = replace(run, position=position)
    if POINTING_COLUMNS[0] in run.columns:
        value, direction = pointing_observations(there, machine, recording.sign)
        return replace(recording, run=there, value=value, direction=direction)
    if recording.kind in ("angle", "length"):
        return replace(recording, run=there, value=recording.value - _first_order(recording, machine, step))
    way = _tip(there, machine) - _tip(run, machine)
    reading = recording.sign * (recording.direction * way[recording.row]).sum(axis=1)
    return replace(recording, run=there, value=recording.value - reading)


def _tip(run: Run, machine: Machine) -> Array:
    return nominal_tip(machine.chain, machine.axes, run)


def _first_order(recording: Recording, machine: Machine, step: dict[str, float]) -> Array:
    columns, names = nuisance_columns(recording, machine)
    return np.asarray(columns @ [step.get(_place(n), 0.0) if n.startswith("index") else 0.0 for n in names])


def _check_exact(recording: Recording, total: dict[str, float]) -> None:
    if POINTING_COLUMNS[0] in recording.run.columns or recording.kind not in ("angle", "length"):
        return
    if max(map(abs, total.values()), default=0.0) > MOST_FIRST_ORDER:
        raise ModelLimit(
            f"index {_text(total)}: a {recording.kind} seen along one direction cannot be moved that far exactly; give the "
            "observed direction pointed_x pointed_y pointed_z (kind angle), or the tip itself (kind path)"
        )


def _text(index: dict[str, float]) -> str:
    parts = [
        f"{name} {np.degrees(v):.4g} deg" if is_rotary(name.partition("[")[0]) else f"{name} {v:.4g} mm"
        for name, v in index.items()
    ]
    return ", ".join(parts) or "none"


def index_text(recording: Recording) -> str:
    """Return what was added to the readings as text, 'C -5.226 deg, B -0.955 deg'; '' for nothing."""
    return _text(dict(recording.index)) if recording.index else ""
