"""Rows of a cut: the state of the machine at the moment at which each inspection point gets its final surface."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vcmm.cutting.envelope import CutSurface
from vcmm.machining.contacts import Contacts, Ints
from vcmm.machining.toolside import SETTING
from vcmm.pose import Pose
from vcmm.run import Array, Run

GRAZING = 1e-6
Words = np.typing.NDArray[np.str_]


def contacts_of(surface: CutSurface) -> tuple[Contacts, Ints, Ints]:
    """Contacts of the points that were cut, the index of the point and of the candidate (rows,) of each row of the run."""
    known = surface.row >= 0
    point, candidate = np.nonzero(known)
    row = np.full(surface.row.shape, -1, dtype=np.intp)
    row[point, candidate] = np.arange(len(point))
    height = np.where(known, surface.contact_s, np.inf)
    along = np.einsum("pki,pi->pk", np.where(known[:, :, None], surface.normal, 0.0), surface.normals)
    steep = (
        np.abs(along) < GRAZING
    )  # the ray leaves a gouge through its side: moving the tool does not move that end
    cutter = np.where((known & ~steep)[:, :, None], surface.normal, surface.normals[:, None, :])
    return Contacts(height, cutter, surface.normals, row), point, candidate


def cut_run(
    states: Run, surface: CutSurface, point: Ints, candidate: Ints, touch: Words, feature: Words, pose: Pose,
    tips: Array, constants: Mapping[str, float],
) -> Run:  # fmt: skip
    """The run of all contacts: `states` are those of the machine, the tip replaced by the cutting point.

    The offset of each row leads to the point where the cutter meets the surface, so that the lever arms of all error
    motions, and with them the tilt of the tool, count to there.
    """
    n = surface.normals[point]
    contact = surface.points[point] + surface.contact_s[point, candidate][:, None] * n
    columns = {f"n{c}": n[:, i] for i, c in enumerate("xyz")}
    columns |= {f"part_{c}_mm": (contact - pose.shift)[:, i] for i, c in enumerate("xyz")}
    columns |= {name: np.full(len(point), value) for name, value in constants.items()}
    kept = {k: v for k, v in states.columns.items() if not k.startswith("tip_")}
    labels = {**states.labels, "touch": touch[point], "feature": feature[point]}
    offset = states.offset + (contact - tips[point, candidate])
    return Run(states.position, offset, {**kept, **columns}, labels, states.series)


def setting_rows(run: Run, tools: Words, offsets: Mapping[str, Array], at: Array) -> Run:
    """One row per tool with its tip at `at` (3,), as when the work offset and the tool length were set: at rest, cold."""
    names = list(dict.fromkeys(tools.tolist()))
    count = len(names)
    offset = np.array([offsets[name] for name in names]).reshape(count, 3)
    position = {
        letter: at["XYZ".index(letter)] - offset[:, "XYZ".index(letter)]
        if letter in "XYZ"
        else np.zeros(count)
        for letter in run.position
    }
    columns = {name: _at_rest(name, values, count) for name, values in run.columns.items()}
    labels = {name: np.full(count, str(values[0])) for name, values in run.labels.items()}
    labels |= {"tool": np.array(names), "touch": np.full(count, SETTING), "feature": np.full(count, SETTING)}
    return Run(position, offset, columns, labels, run.series)


def _at_rest(name: str, values: Array, count: int) -> Array:
    if name == "nz":
        return np.ones(count)
    if name.startswith(("temp_", "reading_", "pressure", "humidity")):
        return np.full(count, values[0])
    return np.zeros(count)


def joined(first: Run, second: Run) -> Run:
    """The rows of both, which have the same columns and labels."""
    return Run(
        {k: np.concatenate([v, second.position[k]]) for k, v in first.position.items()},
        np.concatenate([first.offset, second.offset]),
        {k: np.concatenate([v, second.columns[k]]) for k, v in first.columns.items()},
        {k: np.concatenate([v, second.labels[k]]) for k, v in first.labels.items()},
        first.series,
    )


def setting_of(tool: Words, first: int) -> Ints:
    """For each row the number of the setting row of its tool; they follow from row `first` on, in order of appearance."""
    names = list(dict.fromkeys(tool.tolist()))
    return np.array([first + names.index(t) for t in tool.tolist()], dtype=np.intp)
