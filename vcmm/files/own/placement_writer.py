"""Write a scenario file with a new [pose], and its set-up with moved work offsets: the owner's comments and layout stay."""

from __future__ import annotations

import os
from pathlib import Path

import numpy as np

from vcmm.core.pose import Array
from vcmm.files.toml_edits import editable, move_names, with_comment_under, with_value_for_table
from vcmm.task.measuring.cut_scenario import CutScenario


def placed_text(
    source: Path, target: Path, pose: Array, machine: Path | None = None, convenient: Array | None = None
) -> str:
    """Return the text of the scenario with the pose (6: mm, rad), to be written to `target`.

    Names of files that lie beside the source are rewritten as seen from the new folder. machine: a file that takes the
    place of the scenario's machine. convenient (6,): a pose in round numbers that is nearly as good, named in a comment.
    Raises DataError where the source is no valid TOML.
    """
    document = editable(source)
    move_names(document, source.parent, target.parent)
    if machine is not None:
        with_value_for_table(document, "machine", os.path.relpath(machine, target.parent))
    _set_pose(document, pose)
    text = str(document.as_string())
    if convenient is None:
        return text
    shift, turn = pose_texts(convenient)
    return with_comment_under(
        text, ("pose",), f'in round numbers and nearly as good: shift = "{shift}", turn = "{turn}"'
    )


def _set_pose(document: dict[str, dict[str, str]], pose: Array) -> None:
    import tomlkit

    if "pose" not in document:
        document.add(tomlkit.nl())  # type: ignore[attr-defined]
        document["pose"] = {}
    for key, value in zip(("shift", "turn"), pose_texts(pose)):
        document["pose"][key] = value


def pose_texts(pose: Array) -> tuple[str, str]:
    """Shift and turn of a pose (6,) as values of a file."""
    turns = " ".join(number_text(v, 9) for v in np.degrees(pose[3:]))
    return f"{' '.join(number_text(v, 6) for v in pose[:3])} mm", f"{turns} deg"


def number_text(value: float, digits: int) -> str:
    text = f"{value:.{digits}f}".rstrip("0").rstrip(".")
    return "0" if text in ("-0", "") else text


def placed_cut(source: Path, scenario: CutScenario, folder: Path, pose: Array, by: Array) -> dict[str, str]:
    """Return file name -> text: placed.toml and the set-up that it names, part and work offsets moved by `by` (3,) mm.

    pose (6,): the pose found. Raises DataError where a file is no valid TOML.
    """
    setup, name = scenario.setup.path, "placed-setup.toml"
    assert setup is not None
    document = editable(source)
    move_names(document, source.parent, folder)
    if "pose" in document:
        _set_pose(document, pose)
    document["cut"]["setup"] = name
    if "at" in document["cut"].get("work_offset", {}) and scenario.set_at is not None:
        document["cut"]["work_offset"]["at"] = _point(scenario.set_at, by)
    offsets = editable(setup)
    move_names(offsets, setup.parent, folder)
    for key, point in scenario.setup.offsets.items():
        if key in offsets.get("offsets", {}):
            offsets["offsets"][key] = _point(point, by)
    return {"placed.toml": document.as_string(), name: offsets.as_string()}


def _point(point: tuple[float, float, float], by: Array) -> list[str]:
    return [f"{number_text(p + d, 6)} mm" for p, d in zip(point, by)]
