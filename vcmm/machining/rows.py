"""Rows of a cut: the state of the machine at the moment at which each inspection point gets its final surface."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vcmm.core.pose import Pose
from vcmm.core.run import Array, Run
from vcmm.cutting.contactmap import Contacts, Ints, Solids, upright
from vcmm.cutting.envelope import CutSurface
from vcmm.cutting.sweeps import Sweep
from vcmm.machining.neighbours import Candidates
from vcmm.machining.polish import TurnedSolids
from vcmm.machining.rotary import Motion
from vcmm.machining.tool_errors import SETTING

OF_ROW = ("touch", "feature", "mode")  # labels of a row itself: setting is another row
Words = np.typing.NDArray[np.str_]


def contacts_of(
    surface: CutSurface, found: Candidates, sweep: Sweep, motion: Motion | None = None
) -> tuple[Contacts, Ints, Ints]:
    """Contacts of the points that were cut, the index of the point and of the candidate (rows,) of each row of the run."""
    known = found.row >= 0
    point, candidate = np.nonzero(known)
    row = np.full(found.row.shape, -1, dtype=np.intp)
    row[point, candidate] = np.arange(len(point))
    # where the ray ends in the side of a gouge the tool moves that end as it moves itself
    cutter = upright(found.cutter, surface.normals, known)
    which = np.where(known, sweep.tool[np.maximum(found.row, 0)], -1).astype(np.intp)
    arm = surface.points[:, None, :] - found.tip
    solids = Solids(sweep.tools, which, arm)
    if motion is not None:
        frame = np.broadcast_to(np.eye(3), (*row.shape, 3, 3)).copy()
        frame[point, candidate] = motion.standing(found.row[point, candidate], found.share[point, candidate])[
            1
        ]
        solids = TurnedSolids(sweep.tools, which, arm, frame)
    return Contacts(found.height, cutter, surface.normals, row, solids), point, candidate


def contact_points(surface: CutSurface, found: Candidates, point: Ints, candidate: Ints) -> Array:
    """Where the cutter meets the surface in each row of the run (rows, 3), workpiece axes."""
    height = found.height[point, candidate][:, None]
    return np.asarray(surface.points[point] + height * surface.normals[point])


def cut_run(
    states: Run, surface: CutSurface, contact: Array, point: Ints, touch: Words, feature: Words, pose: Pose,
    constants: Mapping[str, float],
) -> Run:  # fmt: skip
    """The run of all contacts: `states` are those of the machine, with the cutting point (rows, 3) as their tip.

    The offset of each row leads to the point where the cutter meets the surface, so that the lever arms of all error
    motions, and with them the tilt of the tool, count to there.
    """
    n = surface.normals[point]
    columns = {f"n{c}": n[:, i] for i, c in enumerate("xyz")}
    columns |= {f"part_{c}_mm": (contact - pose.shift)[:, i] for i, c in enumerate("xyz")}
    columns |= {name: np.full(len(point), value) for name, value in constants.items()}
    kept = {k: v for k, v in states.columns.items() if not k.startswith("tip_")}
    labels = {**states.labels, "touch": touch[point], "feature": feature[point]}
    return Run(states.position, states.offset, {**kept, **columns}, labels, states.series)


def setting_rows(run: Run, chosen: Ints, offset: Array, at: Array, pose: Pose) -> Run:
    """The rows `chosen` (k,) again with the tool tip at `at` (k, 3), as when offset and tool length were set: at rest, cold.

    offset (k, 3): tip in the frame of the last tool-side axis. Labels are those of the chosen rows, so that what is drawn
    per tool or set-up is the same draw; the column `setting` is 1.
    """
    count = len(chosen)
    position = {
        letter: (at - offset)[:, "XYZ".index(letter)] if letter in "XYZ" else np.zeros(count)
        for letter in run.position
    }
    columns = {name: _at_rest(name, values, count) for name, values in run.columns.items()}
    columns |= {f"part_{c}_mm": (at - pose.shift)[:, i] for i, c in enumerate("xyz")} | {
        "setting": np.ones(count)
    }
    labels = {name: values[chosen] for name, values in run.labels.items()}
    labels |= {name: np.full(count, SETTING) for name in OF_ROW if name in labels}
    return Run(position, offset, columns, labels, run.series)


def _at_rest(name: str, values: Array, count: int) -> Array:
    if name in ("nz", "tool_axis_z"):
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


def settings_of(run: Run) -> tuple[Ints, Ints]:
    """(first row of each way of setting, number of the way of each row): rows differ in it by tool, work offset, event."""
    names = [run.labels[n] for n in sorted(run.labels) if n not in OF_ROW]
    keys = np.array(["\0".join(words) for words in zip(*names)]) if names else np.full(run.n, "")
    _, first, number = np.unique(keys, return_index=True, return_inverse=True)
    return first.astype(np.intp), number.astype(np.intp)
