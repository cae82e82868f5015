"""Recording: the observations on a machine, with the Run in which they were made.

    value = actual error seen along `direction`, plus nuisance, plus noise

    probe         touches of a surface, along its outward normal or as x y z          mm
    displacement  an instrument (laser, indicator) along a fixed direction            mm
    length        the distance of two ends: ball bar, tracker, length artefact        mm
    angle         an instrument for rotations (autocollimator, level) about an axis   rad
    path          the path of the tool, or the part that it left                      mm

`measuring` says in which sense: True is indicated - true, False is actual - commanded (vcmm.task.response.observe has the signs).
Several observations may belong to one row of the run (x, y and z of one point); `row` says which.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from typing import TYPE_CHECKING, Any

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.laws import Law
from vcmm.core.run import Array, Run, encode_labels
from vcmm.core.views import draw

if TYPE_CHECKING:
    from matplotlib.axes import Axes


Ints = npt.NDArray[np.intp]
RECORDING_KINDS = ("probe", "displacement", "length", "angle", "path")
NUISANCES = (
    "rigid", "offset", "radius", "zero", "slope", "centre", "station", "dead_path", "alignment", "index",
    "profile", "tool",
)  # fmt: skip
UNKNOWN = "unknown "  # begins the name of a known covariance that represents physics without a name
SOURCE_LABEL = "recording"  # the label that says of several which recording a row is of
ALL_ROWS = ("", "run")  # label words for one value in all rows


@dataclass(frozen=True, eq=False)
class Recording:
    """m observations in a run of n rows; see the docstring of this module.

    value (m,) mm, rad for kind angle.   row (m,) run row of each.   direction (m, 3) unit, workpiece axes: sensitive
    direction, for length from the second end to the first, for angle the axis of rotation.
    other (m,) run row of the second end of a length, -1 where that end is a fixed station.
    u (m,) standard uncertainty of each observation or None.   nuisance: name -> label column ("" = all rows).
    missing: columns of the run that the file did not hold.   lines (n,): line of the data file of each run row, or None.
    index: "C" or "C[setup=2]" -> mm or rad that was added to the readings of that axis (see vcmm.task.response.indexing).
    known: (Input id, columns (m, r)): what is known to be uncertain here, mm or rad per draw of unit variance; it takes the place of the
    machine's Input of that id, and of the errors of setting that no machine file states.
    chosen_from: of how many observations these were chosen evenly (see vcmm.learn.diagnosis.thinning); 0: they are all.
    notes: what was set aside when the file was read, in words: rows or columns with gaps of a sensor.
    unread: (column, rows (n,)): run rows in which a sensor has no reading; the number there is held from another row and is not used.
    record: who, when, serial numbers, in words for reports.
    Raises UsageError for shapes, words and numbers that do not fit.
    """

    name: str
    kind: str
    run: Run
    value: Array
    measuring: bool
    row: Ints
    direction: Array
    other: Ints
    u: Array | None = None
    nuisance: Mapping[str, str] = field(default_factory=dict)
    noise: Law | None = None
    missing: tuple[str, ...] = ()
    lines: Ints | None = None
    index: Mapping[str, float] = field(default_factory=dict)
    known: tuple[tuple[str, Array], ...] = ()
    chosen_from: int = 0
    notes: tuple[str, ...] = ()
    unread: tuple[tuple[str, npt.NDArray[np.bool_]], ...] = ()
    record: Mapping[str, str] = field(default_factory=dict)

    def __post_init__(self) -> None:
        if self.kind not in RECORDING_KINDS:
            raise UsageError(
                f'unknown kind of recording "{self.kind}".{choose_from(self.kind, RECORDING_KINDS)}'
            )
        for word in self.nuisance:
            if word not in NUISANCES:
                raise UsageError(f'unknown nuisance "{word}".{choose_from(word, NUISANCES)}')
        self._check_shapes()
        self._check_numbers()
        self._check_senses()

    def _check_shapes(self) -> None:
        m = self.value.shape[0] if self.value.ndim == 1 else -1
        shapes = {
            "row": (self.row.shape, (m,)),
            "direction": (self.direction.shape, (m, 3)),
            "other": (self.other.shape, (m,)),
        } | {f"known {name}": (columns.shape[:1], (m,)) for name, columns in self.known}
        if self.u is not None:
            shapes["u"] = (self.u.shape, (m,))
        for name, (given, due) in shapes.items():
            if given != due:
                raise UsageError(f"recording {self.name}: {name} has shape {given}, expected {due}")

    def _check_numbers(self) -> None:
        finite = np.isfinite(self.value).all() and np.isfinite(self.direction).all()
        if not finite or (np.abs(_length(self.direction) - 1.0) > 1e-9).any():
            raise UsageError(f"recording {self.name}: values must be finite and directions of length 1")
        if (self.row < 0).any() or (self.row >= self.run.n).any() or (self.other >= self.run.n).any():
            raise UsageError(
                f"recording {self.name}: an observation names a row beyond the {self.run.n} rows"
            )
        if self.u is not None and not ((self.u > 0) & np.isfinite(self.u)).all():
            raise UsageError(f"recording {self.name}: standard uncertainties must be finite and above zero")
        if self.kind != "length" and (self.other >= 0).any():
            raise UsageError(f"recording {self.name}: only a length has a second end (other >= 0)")

    def _check_senses(self) -> None:
        for name in (c for c in self.run.columns if c.startswith("sense_")):
            values = self.run.columns[name]
            for row in np.flatnonzero(~np.isin(values, (-1.0, 0.0, 1.0)))[:1]:
                raise UsageError(
                    f"recording {self.name}: {name} is {values[row]:g} in row {row + 1}; a sense is -1, 1, or 0 where it is not known"
                )

    def plot(self, ax: Any = None) -> Axes:
        """Plot the observations over the axis that moves furthest, by its sense of motion where that was recorded."""
        drawn: Axes = draw(self, ax)
        return drawn

    @property
    def m(self) -> int:
        """Number of observations."""
        return len(self.value)

    @property
    def sign(self) -> float:
        """Sign of the tip motion in the value: -1 for indicated - true, +1 for actual - commanded."""
        return -1.0 if self.measuring else 1.0

    @property
    def of_cut_part(self) -> bool:
        """Whether a part that was cut is measured: readings that act on it (Effect.about.on_cut_part) count as on the finished part."""
        return self.kind == "path" and not self.measuring and {"feature", "clamp"} <= self.run.labels.keys()

    def groups(self, label: str) -> tuple[tuple[str, ...], Ints]:
        """Return the values of a label column and the code (m,) of each observation.

        "" means all rows, and so does a label that the run does not have (`missing` names it).
        """
        if label not in self.run.labels:
            return ("",), np.zeros(self.m, dtype=np.intp)
        values, codes = encode_labels(self.run.labels[label][self.row])
        return tuple(str(v) for v in values), codes.astype(np.intp)

    def places(self, observations: Ints | npt.NDArray[np.bool_], most: int = 6) -> str:
        """Name the places of observations, 'lines 12, 17 and 30 more', in the data file; rows (from 1) without a file."""
        rows = np.unique(self.row[observations])
        has_lines = self.lines is not None and bool((rows < len(self.lines)).all())
        numbers = self.lines[rows] if self.lines is not None and has_lines else rows + 1
        word = ("line" if has_lines else "row") + ("" if len(numbers) == 1 else "s")
        shown = [str(k) for k in numbers[:most]]
        if len(numbers) > most:
            return f"{word} {', '.join(shown)} and {len(numbers) - most} more"
        return f"{word} {' and '.join([', '.join(shown[:-1]), shown[-1]] if len(shown) > 1 else shown)}"

    def touching(self, rows: npt.NDArray[np.bool_]) -> npt.NDArray[np.bool_]:
        """Return the observations (m,) with an end in some of the run rows (n,)."""
        return np.asarray(rows[self.row] | np.where(self.other >= 0, rows[np.maximum(self.other, 0)], False))

    def take(self, observations: Ints | npt.NDArray[np.bool_] | slice) -> Recording:
        """Return a copy with some of the observations (hold-out folds); the run stays whole."""
        return replace(
            self,
            value=self.value[observations],
            row=self.row[observations],
            direction=self.direction[observations],
            other=self.other[observations],
            u=None if self.u is None else self.u[observations],
            known=tuple((name, columns[observations]) for name, columns in self.known),
        )


def _length(vectors: Array) -> Array:
    """Return the lengths (n,) of vectors (n, 3), without a copy of them."""
    return np.asarray(np.sqrt(np.einsum("ij,ij->i", vectors, vectors)))
