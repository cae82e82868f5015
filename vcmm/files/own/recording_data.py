"""Read the data of a recording file in the format that it states, as a Recording: one reader for each format;
poses of a tracker against joint angles, as written; and the recordings of a folder.
"""

from __future__ import annotations

from difflib import get_close_matches
from pathlib import Path

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.errors import DataError, ModelLimit, UsageError
from vcmm.core.machine import MOVE_IT, Machine
from vcmm.core.pose import Pose
from vcmm.files.foreign.iso230 import read_iso230, recording_of_runs
from vcmm.files.foreign.klipper import read_klipper, recording_of_homings
from vcmm.files.foreign.point_table import read_points
from vcmm.files.foreign.pointing_lists import read_altaz, read_tpoint, recording_of_pointings
from vcmm.files.foreign.rtl import read_rtl
from vcmm.files.observations import Sense, read_observations
from vcmm.files.own.pose_tables import PosesTable, read_poses
from vcmm.files.own.recording_tables import (
    LineTable,
    RecordingFile,
    ScopeTable,
    StylusTable,
    check_words,
    noise_law,
    other_positions,
)
from vcmm.files.own.scope import read_scope, recording_of_scope
from vcmm.files.own.touch_tables import read_touches
from vcmm.files.problems import Problems
from vcmm.files.schema import checked_model
from vcmm.files.toml import check_version, read_toml
from vcmm.task.response.poses import PoseReadings, as_recording
from vcmm.task.response.recording import Recording

ALIKE = 0.8  # of the letters, from which "recordings" or "recoding" is a recording mistyped


def recordings_in(folder: Path) -> list[Path]:
    """Return recording files in a folder and below it: TOML files that state so, those that cannot be read and may be some, and those
    whose first line is
    mistyped or missing: reading them refuses them, where passing them over would leave a recording out in silence.

    Raises UsageError where there is none.
    """
    files = [p for p in sorted(folder.rglob("*.toml")) if p.is_file() and _may_be_recording(p)]
    if not files:
        raise UsageError(
            f'{folder} holds no recording: no .toml file there says vcmm = "recording/1"; name another folder, or the file itself'
        )
    return files


def _may_be_recording(path: Path) -> bool:
    try:
        data = read_toml(path).data
    except DataError:
        return b"recording/" in path.read_bytes()[:100_000]
    tag = str(data.get("vcmm", ""))
    if not tag:
        return {"data", "kind", "machine"} <= data.keys()
    return bool(get_close_matches(tag.partition("/")[0].lower(), ["recording"], cutoff=ALIKE))


def is_poses(path: Path) -> bool:
    """Return whether a file is a recording of poses; False for a file that cannot be read."""
    try:
        data = read_toml(path).data
    except DataError:
        return False
    return str(data.get("vcmm", "")).startswith("recording/") and data.get("kind") == "pose"


def load_poses(path: Path, machine: Machine) -> PoseReadings:
    """Read a recording of poses of this arm. Raises DataError: every problem with its line; a joint outside its travel."""
    document = read_toml(path)
    check_version(document, "recording")
    problems = Problems(document)
    model = checked_model(RecordingFile, document.data, problems)
    poses = None
    if model is not None:
        check_words(model, problems)
        if not problems.found:
            file = path.parent / model.data
            poses = problems.attempt(("data",), lambda: poses_of(model, file, machine))
    problems.raise_if_any()
    assert poses is not None
    assert model is not None
    try:
        machine.check_travels(poses.run)
    except ModelLimit as error:
        where = "" if error.row is None or poses.lines is None else f":{poses.lines[error.row]}"
        reason = str(error).removesuffix(MOVE_IT)
        raise DataError(
            f"{path.parent / model.data}{where}: {reason}; check the order, the unit and the direction of the joint columns, and travel in the machine file"
        ) from None
    return poses


def read_data(
    model: RecordingFile, path: Path, machine: Machine | None, problems: Problems
) -> Recording | None:
    """Read the data in their format; None where the machine is not known."""
    if model.kind == "pose":
        return None if machine is None else as_recording(poses_of(model, path, machine), machine)
    if model.shape == "table":
        fixed = bool({"station", "centre"} & set(model.nuisance))
        return read_observations(path, machine, Sense(model.kind, model.measuring, fixed), model.name)
    if machine is None:
        return None
    if model.shape == "points":
        stylus = model.stylus or StylusTable()
        pose = model.pose and Pose.from_turns(np.array(model.pose.shift), np.array(model.pose.turn))
        radius = stylus.tip_diameter / 2
        return read_points(path, machine, pose or Pose.identity(), offset=np.array(stylus.offset), tip_radius=radius, kind=model.kind, measuring=model.measuring)  # fmt: skip
    if model.shape == "scope":
        return _read_scope(model, path, machine, problems)
    if model.shape in ("tpoint", "altaz"):
        _check_kind(model, "angle")
        pointings = read_altaz(path) if model.shape == "altaz" else read_tpoint(path, model.equinox or "date")
        return recording_of_pointings(pointings, machine, model.measuring)
    if model.shape == "touches":
        _check_kind(model, "probe")
        if model.touch is None or not model.measuring:
            raise UsageError(
                'format = "touches" needs the table [touch] with tip_diameter and features, and observed = "indicated - true"'
            )
        touch = model.touch
        return problems.attempt(("touch",), lambda: read_touches(touch, path, machine))
    if model.shape == "klipper":
        return _read_klipper(model, path, machine, problems)
    runs = read_rtl(path) if model.shape == "rtl" else read_iso230(path)
    line = model.line or LineTable()
    if "axis" in line.model_fields_set and not line.axis:
        problems.add(("line", "axis"), "axis is empty; write the letter of the axis, or leave the key out")
        return None
    axis = line.axis or runs.axis
    if not axis:
        raise UsageError(f'{path.name} does not name its axis; add [line] with axis = "X"')
    _check_kind(model, "angle" if is_rotary(axis) else "displacement")
    at = problems.attempt(("line",), lambda: other_positions(line, machine.chain.letters, (axis,)))
    return (
        None
        if at is None
        else recording_of_runs(runs, machine, axis, at, np.array(line.offset), model.measuring)
    )


def poses_of(model: RecordingFile, path: Path, machine: Machine) -> PoseReadings:
    """Read poses as the tracker recorded them, with their orientations."""
    u = noise_law(model.noise, False).u if model.noise is not None else 0.0
    return read_poses(model.poses or PosesTable(), path, machine, model.name or path.stem, float(u))


def _read_scope(model: RecordingFile, path: Path, machine: Machine, problems: Problems) -> Recording | None:
    scope = read_scope(path, model.scope or ScopeTable())
    axes = tuple(scope.command)
    _check_kind(model, "angle" if is_rotary(axes[0]) else "path")
    line = model.line or LineTable()
    at = problems.attempt(("line",), lambda: other_positions(line, machine.chain.letters, axes))
    return (
        None if at is None else recording_of_scope(scope, machine, at, np.array(line.offset), model.measuring)
    )


def _read_klipper(model: RecordingFile, path: Path, machine: Machine, problems: Problems) -> Recording | None:
    _check_kind(model, "displacement")
    if not model.measuring:
        raise UsageError('a switch that does not move is a reference: write observed = "indicated - true"')
    homings = read_klipper(path, model.counter.step if model.counter else None)
    line = model.line or LineTable()
    at = problems.attempt(
        ("line",), lambda: other_positions(line, machine.chain.letters, ()) if line.at else {}
    )
    return None if at is None else recording_of_homings(homings, machine, at, np.array(line.offset))


def _check_kind(model: RecordingFile, due: str) -> None:
    if model.kind != due:
        raise UsageError(f'{model.data} holds a recording of kind "{due}"; write kind = "{due}"')
