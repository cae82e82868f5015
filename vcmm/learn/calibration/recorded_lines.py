"""Compute ISO 230-2 figures of one axis and ISO 230-6 figures of a diagonal from recordings: targets on a line, approached from both
sides run after run."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.learn.calibration.acceptance import Figure
from vcmm.learn.calibration.deviations import SAME, Limits, RecordedTest, figure_of, limit_of
from vcmm.learn.calibration.standards import diagonal, positioning
from vcmm.task.response.recording import Ints, Recording

BENT = 0.1  # mm: targets that lie further from their line are on none
ALONG = 0.9  # cosine of a reading with the diagonal


@dataclass(frozen=True, eq=False)
class TargetLine:
    """Observations of one line: q (m,) along it, sense (m,) +1 or -1 along it."""

    recording: Recording
    which: Ints
    q: Array
    sense: Array
    what: str

    def runs(self) -> tuple[Ints, Ints, Array]:
        """Return the numbers of the observations (targets, runs) approached in + and in -, and the targets in order.

        Raises UsageError for targets short of approaches.
        """
        targets = np.unique(np.round(self.q / SAME) * SAME)
        groups = []
        for way in (1.0, -1.0):
            rows = [self.which[(np.abs(self.q - t) < 10 * SAME) & (self.sense == way)] for t in targets]
            counts = {len(r) for r in rows}
            if len(counts) != 1 or counts == {0}:
                least = int(np.argmin([len(r) for r in rows]))
                raise UsageError(
                    f"{self.recording.name}: target {targets[least]:g} was approached {len(rows[least])} times in "
                    f"{'+' if way > 0 else '-'}, others {max(counts)} times; {self.what} takes each equally often: complete the runs "
                    "or leave a run out"
                )
            groups.append(np.array(rows))
        return groups[0], groups[1], targets


def recorded_positioning(
    tests: Sequence[RecordedTest], limits: Limits | None = None
) -> tuple[list[Figure], list[str]]:
    """Return ISO 230-2 figures of one axis per recording, approached from both sides run after run.

    Raises UsageError for a recording of another shape: kind, missing senses or runs, targets that were not approached equally often.
    """
    out = []
    for test in tests:
        axis = axis_of(test.recording)
        up, down, targets = axis_line(test.recording, axis).runs()
        out += test.figures(
            lambda value, up=up, down=down: positioning(value[..., up], value[..., down]),  # type: ignore[misc]
            axis, limits or {}, float(targets[-1] - targets[0]),
        )  # fmt: skip
    return out, []


def axis_of(recording: Recording) -> str:
    """Return the one axis that moves. Raises UsageError where none or several do."""
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


def axis_line(recording: Recording, axis: str) -> TargetLine:
    """Return the line of one axis. Raises UsageError for senses that are missing or contradict the order of the rows."""
    q = recording.run.q(axis)[recording.row]
    sense = _senses(recording, axis, q, "ISO 230-2")
    return TargetLine(recording, np.arange(recording.m), q, sense, "ISO 230-2")


def _senses(recording: Recording, axis: str, q: Array, what: str) -> Array:
    """Return the senses (m,) +1 or -1, as in the file; contradictions with the order of the rows are refused."""
    name = f"sense_{axis}"
    if name not in recording.run.columns:
        raise UsageError(
            f"{recording.name}: the direction of approach is missing; add the column {name} (+1, -1)"
        )
    sense = recording.run.column(name)[recording.row]
    if not np.isin(sense, (1.0, -1.0)).all():
        raise UsageError(f"{recording.name}: {name} must be +1 or -1 in every row of an {what} test")
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


def recorded_diagonals(
    tests: Sequence[RecordedTest], limits: Limits | None = None
) -> tuple[list[Figure], list[str]]:
    """Return ISO 230-6:2002 figures: E, B, R of every diagonal (label `setup`, or one per recording), and the largest E of them.

    A diagonal is named by the senses of X Y Z on its way: PPP, PPN, PNP, PNN through the body (largest: Ed), PP0 ... on a face
    (Ef). Raises UsageError for readings that do not lie along a diagonal, and as `recorded_positioning` does.
    """
    limits, out, notes = limits or {}, [], []
    largest: dict[str, list[tuple[float, Array | None]]] = {"Ed": [], "Ef": []}
    names: list[str] = []
    for test in tests:
        for which in _setups(test.recording):
            name, line = _diagonal(test.recording, which)
            if name in names:
                raise UsageError(
                    f"{test.recording.name}: the diagonal {name} was recorded twice; evaluate one of them, or mark runs with the label run"
                )
            names.append(name)
            up, down, targets = line.runs()

            def compute(value: Array, up: Ints = up, down: Ints = down) -> Mapping[str, Array]:
                return diagonal(value[..., up], value[..., down])

            out += test.figures(compute, name, limits, float(targets[-1] - targets[0]))
            drawn = None if test.draws is None else compute(test.draws)["E"]
            largest["Ef" if "0" in name else "Ed"].append((float(compute(test.value)["E"]), drawn))
    for name, figures in largest.items():
        if figures:
            draws = [d for _, d in figures if d is not None]
            spread = np.max(draws, axis=0) if len(draws) == len(figures) else None
            limit = limit_of(limits, name, "")
            out.append(figure_of(name, max(v for v, _ in figures), spread, limit and limit(0.0)))
    body = [n for n in names if "0" not in n]
    if body and len(body) < 4:
        notes.append(f"ISO 230-6 takes four body diagonals; here: {', '.join(body)}")
    return out, notes


def _setups(recording: Recording) -> list[Ints]:
    _, codes = recording.groups("setup")
    return [np.flatnonzero(codes == code) for code in np.unique(codes)]


def _diagonal(recording: Recording, which: Ints) -> tuple[str, TargetLine]:
    if recording.kind != "displacement":
        raise UsageError(
            f'{recording.name} is of kind "{recording.kind}"; ISO 230-6 takes displacements along a diagonal'
        )
    rows = recording.row[which]
    place = {a: recording.run.q(a)[rows] for a in recording.run.position}
    moving = [a for a, q in place.items() if float(np.ptp(q)) > SAME]
    if len(moving) < 2 or any(is_rotary(a) for a in moving):
        raise UsageError(
            f"{recording.name}: the axes {' '.join(moving) or 'none'} move; on a diagonal two or three linear axes move together"
        )
    points = np.stack([place.get(a, np.zeros(len(rows))) for a in "XYZ"], axis=1)
    middle = points.mean(axis=0)
    way = np.linalg.svd(points - middle, full_matrices=False)[2][0]
    way = way * np.sign(way[np.flatnonzero(np.abs(way) > 1e-3)[0]])
    q = (points - middle) @ way
    away = float(np.linalg.norm(points - middle - q[:, None] * way, axis=1).max())
    if away > BENT:
        raise UsageError(
            f"{recording.name}: the targets lie up to {away:.3g} mm beside a line; give every diagonal its own value of the label "
            "setup, or its own recording"
        )
    if (np.abs(recording.direction[which] @ way) < ALONG).any():
        raise UsageError(
            f"{recording.name}: its readings are not along the diagonal; ISO 230-6 takes the displacement along it (nx ny nz)"
        )
    name = "".join("0" if abs(w) < 1e-3 else "P" if w > 0 else "N" for w in way)
    part = recording.take(which)
    sense = None
    for axis in (a for a in moving if abs(way["XYZ".index(a)]) > 1e-3):
        mine = _senses(part, axis, place[axis], "ISO 230-6") * np.sign(way["XYZ".index(axis)])
        if sense is not None and (mine != sense).any():
            raise UsageError(
                f"{recording.name}: sense_{axis} contradicts the other axes in {part.places(mine != sense)}; along the diagonal {name} "
                "all axes move at once"
            )
        sense = mine
    assert sense is not None
    return name, TargetLine(recording, which, q - q.min(), sense, "ISO 230-6")
