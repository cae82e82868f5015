"""Nuisance: free parameters of a recording that are no errors of the machine, as columns over its observations.

    rigid, alignment  6 per value   where the artefact (part) lies: shift, and turn about the centroid of its points
    offset            3 per value   tip offset of a stylus; of an angle: orientation of the tool in its head
    tool              3 per value   where the target of a tracker sits on the tool, in the axes of the last joint
    index             1 per axis    and value: where the counter is zero, the axis is at reading + index
    radius            1 per value   tip radius, along the outward normal; of a length: a constant (both ends)
    zero              1 per value   the instrument was set to zero anywhere
    slope             1 per value   in proportion to the distance along the line of the points (reference line of a
                                    straightness, gain of a laser); to the length, for a length; to the time, where all
                                    points are one place
    centre, station   3 per value   where the centre cup of a ball bar, the tracker or another fixed end is
    dead_path         1 per value   change of the air's index times an unknown dead path; with dead_path_mm times an
                                    unknown share of it; with dead_path_mm alone in proportion to it
    profile           1 per place   what the reference itself has at every place, the same from both sides: scale of a sensor, shape of
                                    a surface. Reversals, time and temperature remain

One set of columns per value of the label. Columns that change no observation (the artefact's shift, for a length on it)
are left out. Coefficients are in mm and rad; for slope mm/mm or mm/s.
"""

from __future__ import annotations

from collections.abc import Iterator, Mapping
from dataclasses import dataclass

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.effect import COLUMN
from vcmm.core.errors import ModelLimit
from vcmm.core.kinematics import Motion, tip_motion
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.task.response.recording import Ints, Recording

# Air near 20 degC, 1013.25 hPa, 50 %: d(index)/d(...) from Ciddor, Applied Optics 35 (1996) 1566, 633 nm
INDEX_PER = {"temp_air_C": -0.93e-6, "pressure_hPa": 0.27e-6, "humidity_pct": -0.0085e-6}
NO_COPY = "-"  # value of a label in whose rows there is no such nuisance
SAME_PLACE = 1e-2  # mm: targets are repeated to a few um
# numbers that the columns of one nuisance may be; rows that a diagnosis takes
TABLE = 250_000_000
ROWS = 100_000
LEAST_COLUMN = 1e-10  # a column below this, in units of its arm, changes nothing


@dataclass(frozen=True, eq=False)
class _LabelGroup:
    """The observations (g,) of one value of a label; run prepared."""

    recording: Recording
    run: Run
    which: Ints
    machine: Machine

    @property
    def row(self) -> Ints:
        return self.recording.row[self.which]

    @property
    def direction(self) -> Array:
        return self.recording.direction[self.which]

    def across_ends(self, field: Array) -> Array:
        """Return n . field (n rows, 3, k) at the first end, less the same at the second end of a length: (g, k)."""
        out = np.asarray(np.einsum("gi,gik->gk", self.direction, field[self.row]))
        other = self.recording.other[self.which]
        two = other >= 0
        out[two] -= np.einsum("gi,gik->gk", self.direction[two], field[other[two]])
        return out

    def column(self, name: str) -> Array:
        return self.run.column(name)[self.row]


Columns = list[tuple[str, Array]]


def nuisance_columns(recording: Recording, machine: Machine) -> tuple[Array, tuple[str, ...]]:
    """Return the columns (m, p) of the recording's nuisance, and their names such as rigid[pose=2].turn_z.

    Raises ModelLimit when a nuisance needs columns that the run lacks.
    """
    columns = list(named_nuisance(recording, machine))
    matrix = np.stack([c for _, c in columns], axis=1) if columns else np.zeros((recording.m, 0))
    return matrix, tuple(name for name, _ in columns)


def named_nuisance(recording: Recording, machine: Machine) -> Iterator[tuple[str, Array]]:
    """Yield the nuisance one name and column (m,) after the other."""
    run = machine.prepare(recording.run)
    for word, label in recording.nuisance.items():
        values, codes = recording.groups(label)
        if len(values) * min(recording.m, ROWS) > TABLE:
            raise ModelLimit(
                f'{word} = "{label}" has {len(values)} values in {recording.m} observations, a table of at least '
                f"{len(values) * min(recording.m, ROWS) * 8e-9:.1f} GB, and at most {TABLE * 8e-9:.0f} GB are held; name a label with "
                f"fewer values, or diagnose a part of the rows"
            )
        for code, value in enumerate(values):
            if value == NO_COPY:
                continue
            group = _LabelGroup(recording, run, np.flatnonzero(codes == code), machine)
            where = f"[{label}={value}]" if value else ""
            for part, values_here in _columns(word, group):
                full = np.zeros(recording.m)
                full[group.which] = values_here
                yield f"{word}{where}{part}", full


def _columns(word: str, group: _LabelGroup) -> Columns:
    """Return (name ending, (g,)) of one nuisance for one group."""
    if word in ("rigid", "alignment"):
        return _rigid(group)
    if word == "profile":
        return _profile(group)
    if word == "index":
        return _link_columns(group, {f".{a}": (a, COLUMN[a[0]]) for a in group.machine.chain.letters})
    if word == "tool":
        return _link_columns(group, {f".{c}": ("tool", i) for i, c in enumerate("xyz")})
    heads = any(is_rotary(a) for a in group.machine.chain.tool)
    if word == "offset" and group.recording.kind == "angle" and heads:
        return _link_columns(group, {f".turn_{c}": ("tool", 3 + i) for i, c in enumerate("xyz")})
    if word in ("offset", "centre", "station"):
        return _shift(group)
    if word == "radius":
        return [("", _radius(group))]
    if word == "zero":
        return [("", np.ones(len(group.which)))]
    return [("", _slope(group) if word == "slope" else _dead_path(group))]


def _shift(group: _LabelGroup) -> Columns:
    if group.recording.kind == "angle":
        return []
    columns = group.across_ends(np.broadcast_to(np.eye(3), (group.run.n, 3, 3)))
    return [
        (f".shift_{c}", columns[:, i])
        for i, c in enumerate("xyz")
        if np.abs(columns[:, i]).max() > LEAST_COLUMN
    ]


def _link_columns(group: _LabelGroup, links: Mapping[str, tuple[str, int]]) -> Columns:
    """Return the change of the observations when a link moves by one unit of one of its six error motions; columns of zeros are left out."""
    out = []
    chain, axes, sign = group.machine.chain, group.machine.axes, group.recording.sign
    for name, (link, j) in links.items():
        six = np.zeros((group.run.n, 6))
        six[:, j] = 1.0
        motion = tip_motion(chain, axes, group.run, [Motion(link, "motion", six)])
        moved = motion[:, 3:] if group.recording.kind == "angle" else motion[:, :3]
        columns = sign * group.across_ends(moved[:, :, None])[:, 0]
        if np.abs(columns).max(initial=0.0) > LEAST_COLUMN:
            out.append((name, columns))
    return out


def _rigid(group: _LabelGroup) -> Columns:
    """Shift, and w x (p - centroid) for a small turn w; an angle sees the turn itself."""
    tip = group.run.tip
    arm = tip - tip[group.row].mean(axis=0)
    if group.recording.kind == "angle":
        columns, reach = group.direction, 1.0
    else:
        turned = np.stack([np.cross(axis, arm) for axis in np.eye(3)], axis=2)
        columns, reach = group.across_ends(turned), float(np.abs(arm[group.row]).max())
    kept = [i for i in range(3) if np.abs(columns[:, i]).max() > LEAST_COLUMN * max(reach, 1.0)]
    return _shift(group) + [(f".turn_{'xyz'[i]}", columns[:, i]) for i in kept]


def _profile(group: _LabelGroup) -> Columns:
    """Return one free value per place of the tip and direction, for places that were visited twice; a place visited once carries no information.

    Places nearer than SAME_PLACE are one. Raises ModelLimit where no place was visited twice.
    """
    there = np.round(np.column_stack([group.run.tip[group.row] / SAME_PLACE, group.direction * 1e3])).astype(
        int
    )
    _, place, count = np.unique(there, axis=0, return_inverse=True, return_counts=True)
    if not (count > 1).any():
        raise ModelLimit(
            "the nuisance profile needs places that were visited twice, from both sides or in two runs; there are none, and it "
            "would take up every reading: remove profile"
        )
    return [(f".place_{k + 1}", (place.ravel() == k).astype(float)) for k in range(len(count))]


def _radius(group: _LabelGroup) -> Array:
    if group.recording.kind == "length":
        return np.ones(len(group.which))
    if not all(f"n{c}" in group.run.columns for c in "xyz"):
        raise ModelLimit("the nuisance radius needs the normal nx ny nz; add these columns or remove radius")
    return np.asarray((group.direction * group.run.normal[group.row]).sum(axis=1))


def _slope(group: _LabelGroup) -> Array:
    """Return the distance (g,) from the centroid along the line of the points, seen from the workpiece or else from the tool; the length;
    or the time from its mean."""
    place = group.run.tip[group.row]
    other = group.recording.other[group.which]
    if group.recording.kind == "length" and (other >= 0).all():
        return np.linalg.norm(place - group.run.tip[other], axis=1)
    if group.recording.kind == "length" and "length_mm" in group.run.columns:
        return group.column("length_mm")
    for points in (
        place,
        group.run.offset[group.row],
    ):  # a reflector on the table does not move in the workpiece
        from_centre = points - points.mean(axis=0)
        if np.abs(from_centre).max(initial=0.0) > 1e-6:
            line = np.linalg.svd(from_centre, full_matrices=False)[2][0]
            line = line * np.sign(line[np.abs(line).argmax()])
            return np.asarray(from_centre @ line)
    if "time_s" not in group.run.columns:
        raise ModelLimit(
            "the nuisance slope has no line: all points are one place and there is no time_s; add time_s or remove slope"
        )
    time = group.column("time_s")
    return time - time.mean()


def _dead_path(group: _LabelGroup) -> Array:
    present = [name for name in INDEX_PER if name in group.run.columns]
    change = np.ones(len(group.which))
    if present:
        index = np.sum([INDEX_PER[name] * group.column(name) for name in present], axis=0)
        change = index - index[0]
    if "dead_path_mm" in group.run.columns:
        return change * group.column("dead_path_mm")
    if not present:
        raise ModelLimit(
            "the nuisance dead_path needs dead_path_mm, or the change of the air's index from "
            f"{', '.join(INDEX_PER)}; add one of them or remove dead_path"
        )
    return change
