"""Figures of a test from its recording: ISO 230-2 with the uncertainty of the instrument."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vcmm.calibrating.acceptance import Figure, Limit
from vcmm.calibrating.standards import positioning
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.instruments.instrument import InstrumentCertificate
from vcmm.response.recording import Ints, Recording

TRIALS, SAME = 2000, 1e-6


def recorded_positioning(
    recording: Recording,
    machine: Machine,
    certificate: InstrumentCertificate | None = None,
    limits: Mapping[str, Limit] | None = None,
) -> list[Figure]:
    """ISO 230-2 figures of a recording of one axis, approached from both sides run after run.

    u: standard deviation of the figures when the instrument's own errors are drawn; None without a certificate. Raises
    UsageError for a recording of another shape: kind, missing senses or runs, targets that were not approached equally often.
    """
    axis = axis_of(recording)
    up, down, order = runs_of(recording, axis)
    value = -recording.value if recording.measuring else recording.value
    crisp = positioning(value[up], value[down])
    drawn = _drawn(recording, machine, certificate, value, up, down) if certificate else None
    length, out = float(order[-1] - order[0]), []
    for name, one in crisp.items():
        found = (limits or {}).get(f"{name} {axis}", (limits or {}).get(name))
        limit = None if found is None else found(length)
        u = None if drawn is None else float(drawn[name].std())
        sure = None if limit is None else float(one <= limit)
        if limit is not None and drawn is not None:
            sure = float((float(one) + drawn[name] - drawn[name].mean() <= limit).mean())
        scale = 1e6 if recording.kind == "angle" else 1e3
        out.append(
            Figure(
                f"{name} {axis}", float(one) * scale, None if u is None else u * scale,
                None if limit is None else limit * scale, sure,
            )
        )  # fmt: skip
    return out


def axis_of(recording: Recording) -> str:
    """The one axis that moves. Raises UsageError where none or several do."""
    if recording.kind not in ("displacement", "angle"):
        raise UsageError(
            f'{recording.name} is of kind "{recording.kind}"; ISO 230-2 takes a displacement along one axis'
        )
    moving = [a for a, q in recording.run.position.items() if float(np.ptp(q)) > SAME]
    if len(moving) != 1:
        raise UsageError(
            f"{recording.name}: the axes {' '.join(moving) or 'none'} move; ISO 230-2 takes one axis at a time"
        )
    return moving[0]


def runs_of(recording: Recording, axis: str) -> tuple[Ints, Ints, Array]:
    """Numbers of the observations (targets, runs) approached in + and in -, and the targets in order.

    Raises UsageError for senses that are missing or contradict the order of the rows, and for targets short of approaches.
    """
    q = recording.run.q(axis)[recording.row]
    sense = _senses(recording, axis, q)
    targets = np.unique(np.round(q / SAME) * SAME)
    groups = []
    for way in (1.0, -1.0):
        rows = [np.flatnonzero((np.abs(q - t) < 10 * SAME) & (sense == way)) for t in targets]
        counts = {len(r) for r in rows}
        if len(counts) != 1 or counts == {0}:
            least = int(np.argmin([len(r) for r in rows]))
            raise UsageError(
                f"{recording.name}: target {targets[least]:g} was approached {len(rows[least])} times in "
                f"{'+' if way > 0 else '-'}, others {max(counts)} times; ISO 230-2 takes each equally often: complete the runs "
                "or leave a run out"
            )
        groups.append(np.array(rows))
    return groups[0], groups[1], targets


def _senses(recording: Recording, axis: str, q: Array) -> Array:
    """(m,) +1 or -1: as the file says; contradictions with the order of the rows are refused."""
    name = f"sense_{axis}"
    if name not in recording.run.columns:
        raise UsageError(
            f"{recording.name}: the direction of approach is missing; add the column {name} (+1, -1)"
        )
    sense = recording.run.column(name)[recording.row]
    if not np.isin(sense, (1.0, -1.0)).all():
        raise UsageError(f"{recording.name}: {name} must be +1 or -1 in every row of an ISO 230-2 test")
    check_senses(recording, axis, q, sense)
    return np.asarray(sense)


def check_senses(recording: Recording, axis: str, q: Array, sense: Array) -> None:
    """Raises UsageError where most rows move against their label: the labels of the directions are exchanged."""
    step = np.diff(q)
    moved = np.flatnonzero(np.abs(step) > SAME) + 1
    wrong = moved[np.sign(step[moved - 1]) != sense[moved]]
    if len(moved) and len(wrong) > 0.5 * len(moved):
        raise UsageError(
            f"{recording.name}: {len(wrong)} of {len(moved)} moves of {axis} go against their direction label "
            f"(first in {recording.places(wrong[:1])}); the labels up and down are exchanged, or the rows are not in the order made"
        )


def _drawn(
    recording: Recording,
    machine: Machine,
    certificate: InstrumentCertificate,
    value: Array,
    up: Ints,
    down: Ints,
) -> dict[str, Array]:
    """Figures (TRIALS,) when the instrument errs as its certificate says."""
    rng = np.random.default_rng(0)
    moved = np.zeros((TRIALS, recording.m))
    for _, own in certificate.columns(recording, machine.prepare(recording.run)):
        moved += rng.standard_normal((TRIALS, own.shape[1])) @ own.T
    whole = value + moved
    return positioning(whole[:, up], whole[:, down])
