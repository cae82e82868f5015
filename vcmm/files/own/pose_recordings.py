"""Recordings of kind "pose" as written: positions and orientations of a tracker against joint angles."""

from __future__ import annotations

from pathlib import Path

from vcmm.core.errors import DataError, ModelLimit
from vcmm.core.machine import MOVE_IT, Machine
from vcmm.files.own.recording_data import poses_of
from vcmm.files.own.recording_tables import RecordingFile, check_words
from vcmm.files.problems import Problems
from vcmm.files.schema import checked_model
from vcmm.files.toml import check_version, read_toml
from vcmm.task.response.poses import PoseReadings


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
