"""Setting of zeros: the rows of a run in which each zero was set, and the errors made there, which are subtracted.

The machine's errors where its zero was set are in the zero, and so are subtracted, draw by draw. The zero is a number of the
machine axes: what was taken into it stays along them while a table turns the part. X and Y of a work offset are one number for
all tools of a mill: the tool that set it carries them. Z was set with each tool (its length), on a lathe every axis.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from vcmm.core.pose import Pose
from vcmm.core.run import Array, Run
from vcmm.task.response.trials import Draws

Ints = npt.NDArray[np.intp]
OF_ROW = ("touch", "feature", "mode")  # labels of a row itself: setting is another row
SETTING = "setting"  # label value of the rows in which a zero was set


@dataclass(frozen=True, eq=False)
class ProbedRows:
    """Touches of a program itself: its K touches are rows `first` (the first of them) and those behind it.

    weight (n, 3, K): mm by which a row lies further per mm that a touch reads further; reads (K, 3): what an error of the tip takes
    off its reading (vcmm.shop.machining.touched_zero).
    """

    first: int
    weight: Array
    reads: Array

    def follow(self, errors: Array) -> Array:
        """Return how far the path follows (..., n, 3) the errors (..., n, 3) of the touches, to be subtracted."""
        k = len(self.reads)
        read = np.einsum("...ki,ki->...k", errors[..., self.first : self.first + k, :], self.reads)
        return np.asarray(np.einsum("nik,...k->...ni", self.weight, read))

    def follow_response(self, response: Array, *codes: Ints) -> Array:
        """Return the same for responses (n, 3, ...), only where row and touch are one draw."""
        k = len(self.reads)
        rows = np.arange(self.first, self.first + k)
        weight = self.weight
        for code in codes:
            weight = weight * (code[:, None] == code[rows])[:, None, :]
        read = np.einsum("ki...,ki->k...", response[rows], self.reads)
        return np.asarray(np.einsum("nik,k...->ni...", weight, read))


@dataclass(frozen=True, eq=False)
class ZeroRows:
    """first (n, 3): for each row and each of X, Y, Z the first of the rows in which that zero was set, -1: nothing is taken off.

    touches: what the program itself probed. count: rows that belong together, whose mean is taken off (angles of a spindle). turn (n, 3, 3): from the axes of the
    machine to those of the workpiece, None while all rotary axes stand at zero.
    """

    first: Ints
    count: int = 1
    turn: Array | None = None
    touches: ProbedRows | None = None

    @property
    def any(self) -> bool:
        return bool((self.first >= 0).any()) or self.touches is not None

    def off_errors(self, errors: Array) -> Array:
        """Return errors (..., n, 3) less those in the rows of setting."""
        if not self.any:
            return errors
        taken = np.stack([errors[..., self._back(i), i].mean(axis=-1) for i in range(3)], axis=-1)
        taken = np.where(self.first >= 0, taken, 0.0)
        if self.touches is not None:
            taken = taken + self.touches.follow(errors)
        if self.turn is not None:
            taken = np.einsum("nij,...nj->...ni", self.turn, taken)
        return np.asarray(errors - taken)

    def off_response(self, response: Array, *codes: Ints) -> Array:
        """Return responses (n, 3, ...) less those in the rows of setting, where all draws (codes, n each) are the same there."""
        if not self.any:
            return response
        same = self.first >= 0
        for code in codes:
            same = same & (code[:, None] == code[np.maximum(self.first, 0)])
        taken = np.stack([response[self._back(i), i].mean(axis=1) for i in range(3)], axis=1)
        taken = np.where(same.reshape(*same.shape, *(1,) * (response.ndim - 2)), taken, 0.0)
        if self.touches is not None:
            taken = taken + self.touches.follow_response(response, *codes)
        if self.turn is not None:
            taken = np.einsum("nij,nj...->ni...", self.turn, taken)
        return np.asarray(response - taken)

    def quiet(self, draws: Draws) -> Draws:
        """Set draws of copies that only rows of setting have to zero: they belong to the uncertainty of the zero."""
        codes = draws.influence.codes
        rows = (np.unique(self.first[self.first >= 0])[:, None] + np.arange(self.count)).ravel()
        if self.touches is not None:
            rows = np.concatenate([rows, self.touches.first + np.arange(len(self.touches.reads))])
        used = np.unique(codes[~np.isin(np.arange(len(codes)), rows)])
        keep = np.isin(np.arange(draws.departures.shape[1]), used)
        return replace(draws, departures=draws.departures * keep[None, :, None])

    def _back(self, axis: int) -> Ints:
        """Return the rows (n, count) in which the zero of X, Y or Z (0, 1, 2) of each row was set."""
        return np.maximum(self.first[:, axis], 0)[:, None] + np.arange(self.count)


def setting_rows(run: Run, chosen: Ints, offset: Array, at: Array, pose: Pose) -> Run:
    """Return the rows `chosen` (k,) again with the tool tip at `at` (k, 3), as when offset and tool length were set: at rest, cold.

    offset (k, 3): tip in the frame of the last tool-side axis. Labels are those of the chosen rows, so that draws
    per tool or set-up are the same; the column `setting` is 1.
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


def join_runs(first: Run, second: Run) -> Run:
    """Return the rows of both, which have the same columns and labels."""
    return Run(
        {k: np.concatenate([v, second.position[k]]) for k, v in first.position.items()},
        np.concatenate([first.offset, second.offset]),
        {k: np.concatenate([v, second.columns[k]]) for k, v in first.columns.items()},
        {k: np.concatenate([v, second.labels[k]]) for k, v in first.labels.items()},
        first.series,
    )


def ways_of_setting(run: Run) -> tuple[Ints, Ints]:
    """Return (first row of each way of setting, number of the way of each row): rows differ in it by tool, work offset, event."""
    names = [run.labels[n] for n in sorted(run.labels) if n not in OF_ROW]
    keys = np.array(["\0".join(words) for words in zip(*names)]) if names else np.full(run.n, "")
    _, first, number = np.unique(keys, return_index=True, return_inverse=True)
    return first.astype(np.intp), number.astype(np.intp)
