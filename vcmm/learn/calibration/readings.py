"""Readings: one recording made ready to be fitted, as columns of errors, instrument and nuisance.

    value = baseline of the machine as far as known + G theta + C c + N n + noise

G errors (m, size), C own errors of the instrument in units of their u (m, c), by name, N nuisance (m, p). Unknowns that a recording must leave
free so that the conventions of `model` cost nothing (the zero of a counter, the line of a straightness, the placement of
an artefact) is added where the file does not state it, and `assumed` says so.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.kinematics import Motion, tip_motion
from vcmm.core.laws import Normal, StudentT
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.learn.calibration.model import ErrorModel, number_of
from vcmm.learn.calibration.touching import free_probe_errors
from vcmm.task.instruments.instrument import InstrumentCertificate
from vcmm.task.instruments.probe_frame import with_probe_frame
from vcmm.task.instruments.tracker import locate_stations
from vcmm.task.response.nuisance import nuisance_columns
from vcmm.task.response.observe import Observer, missing_columns, noise_u
from vcmm.task.response.recording import Recording

UNKNOWN_NOISE = {"angle": 1e-6}  # rad; lengths 1 um: only a start, the residuals decide
ALONG, ACROSS = 0.9, 0.1  # |direction . travel| of a reading along, across the travel
FEW = 3  # readings in either sense that tell a lost motion
SETUP_NUISANCES = ("zero", "rigid", "alignment")


@dataclass(frozen=True, eq=False)
class Readings:
    """See the head of this file. u (m,) noise, mm or rad; stated: whether it was; dof: of a stated t law, else None."""

    recording: Recording
    errors: Array
    instrument_errors: tuple[tuple[str, Array], ...]
    nuisance: Array
    names: tuple[str, ...]
    value: Array
    u: Array
    stated: bool
    dof: float | None
    assumptions: tuple[str, ...]
    station_moves: Mapping[str, float]

    @property
    def m(self) -> int:
        return len(self.value)


def readings(
    recording: Recording,
    machine: Machine,
    model: ErrorModel,
    certificate: InstrumentCertificate | None = None,
) -> Readings:
    """Make a recording ready. machine: what is known, its own effects are the baseline.

    Raises ModelLimit and UsageError for recordings that cannot be used, naming them.
    """
    recording, assumed = free_nuisance(recording, machine)
    recording, way = locate_stations(recording, machine)
    observer = Observer(recording, machine)
    nuisance, names = nuisance_columns(recording, machine)
    turns = _tool_turns(recording, machine, observer)
    in_frame = with_probe_frame(observer.run, machine)
    unknowns = certificate.unknowns(recording, in_frame) if certificate else []
    probe, remarks = free_probe_errors(recording, in_frame, certificate)
    u, stated, dof = _noise(recording, machine)
    return Readings(
        recording=recording,
        errors=error_columns(observer, model),
        instrument_errors=tuple(unknowns),
        nuisance=np.concatenate([nuisance, turns, probe], axis=1),
        names=names,
        value=recording.value - observer.baseline(),
        u=u,
        stated=stated,
        dof=dof,
        assumptions=(*assumed, *remarks),
        station_moves=way,
    )


def error_columns(observer: Observer, model: ErrorModel) -> Array:
    """Return the observations per unit of every number of theta, as (m, size)."""
    out = np.zeros((observer.recording.m, model.size))
    for name, effect in zip(model.names, model.effects()):
        if not missing_columns(effect, observer.run):
            out[:, model.slices[name]] = observer.of_parameter(effect, number_of(effect))
    return out


def read_both_ways(recording: Recording) -> list[str]:
    """Return the linear axes along which this recording reads from both sides, by its columns sense_X ..."""
    out = []
    for axis in "XYZ":
        name = f"sense_{axis}"
        if recording.kind in ("displacement", "path") and name in recording.run.columns:
            sense = recording.run.column(name)[recording.row]
            along = np.abs(recording.direction[:, "XYZ".index(axis)]) > ALONG
            if min(int((along & (sense > 0)).sum()), int((along & (sense < 0)).sum())) >= FEW:
                out.append(axis)
    return out


def free_nuisance(recording: Recording, machine: Machine) -> tuple[Recording, tuple[str, ...]]:
    """Return the recording with the nuisance that its kind always has, and the additions in words."""
    added: dict[str, str] = {}
    has = recording.nuisance
    setup = "setup" if "setup" in recording.run.labels else ""
    if recording.kind in ("displacement", "angle") and not any(w in has for w in SETUP_NUISANCES):
        added["zero"] = setup
    if recording.kind == "displacement" and not {"slope", "rigid", "alignment"} & set(has):
        sides = _sides(recording, machine)
        if sides == {"across"}:
            added["slope"] = setup
        elif "across" in sides:
            raise UsageError(
                f"{recording.name}: some rows read along the travel and some across it; across it the line of the instrument is "
                'unknown: put them into two recordings, or state [nuisance] alignment = "..." where both share one artefact'
            )
    placed = bool({"rigid", "alignment"} & set(has)) or has.get("offset") == "feature"
    if recording.kind in ("probe", "path") and not placed:
        added["rigid"] = "pose" if "pose" in recording.run.labels else ""
    words = tuple(
        f"{recording.name}: {word} is taken as unknown ({f'one per {label}' if label else 'one for all rows'}); "
        "the file does not state it in [nuisance]"
        for word, label in added.items()
    )
    return replace(recording, nuisance={**has, **added}), words


def _sides(recording: Recording, machine: Machine) -> set[str]:
    """Return "along" and "across": the relation of the directions to the travel of the tip, set-up by set-up."""
    tip = machine.prepare(recording.run).tip[recording.row]
    _, codes = recording.groups("setup")
    out = set()
    for code in np.unique(codes):
        mine = codes == code
        way = tip[mine] - tip[mine].mean(axis=0)
        if np.abs(way).max(initial=0.0) < 1e-6:
            continue
        line = np.linalg.svd(way, full_matrices=False)[2][0]
        share = np.abs(recording.direction[mine] @ line)
        out |= {"along"} if (share > ACROSS).any() else set()
        out |= {"across"} if (share < ACROSS).any() else set()
    return out


def _tool_turns(recording: Recording, machine: Machine, observer: Observer) -> Array:
    """Return the turns of the tool in its holder, only those that several tip offsets in one placement would show; and shifts, where
    a rotary axis turns it (its length, the pivot length of the head), (m, 0 to 6).
    """
    offset = recording.run.offset
    ways: list[Array] = []
    if recording.kind != "angle" and np.abs(offset - offset[0]).max(initial=0.0) >= 1e-9:
        ways += [np.cross(axis, offset) for axis in np.eye(3)]
    turning = (a for a in machine.chain.tool if is_rotary(a))
    if recording.kind != "angle" and any(float(np.ptp(recording.run.q(a))) > 1e-9 for a in turning):
        ways += [np.tile(axis, (recording.run.n, 1)) for axis in np.eye(3)]
    if not ways:
        return np.zeros((recording.m, 0))
    out = []
    for way in ways:
        six = np.zeros((recording.run.n, 6))
        six[:, :3] = way
        moved = tip_motion(machine.chain, machine.axes, observer.run, [Motion("tool", "motion", six)])[:, :3]
        along = (recording.direction * moved[recording.row]).sum(axis=1)
        two = recording.other >= 0
        along[two] -= (recording.direction[two] * moved[recording.other[two]]).sum(axis=1)
        out.append(along)
    return np.stack(out, axis=1)


def _noise(recording: Recording, machine: Machine) -> tuple[Array, bool, float | None]:
    """Return (u (m,), stated, dof of a stated t law). Unknown noise starts at 1 um or 1 urad."""
    if isinstance(recording.noise, StudentT):
        return np.full(recording.m, recording.noise.scale), True, recording.noise.dof
    if isinstance(recording.noise, Normal) or recording.u is not None:
        return noise_u(recording, machine), True, None
    if recording.noise is not None:
        raise UsageError(
            f"{recording.name}: noise of the law {recording.noise.name} cannot be fitted; use normal or t"
        )
    try:
        return noise_u(recording, machine), True, None
    except ModelLimit:
        return np.full(recording.m, UNKNOWN_NOISE.get(recording.kind, 1e-3)), False, None
