"""Compute ISO 230-4 figures from a recording of circles: a ball bar, or a grid plate read in two directions."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from itertools import pairwise

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.learn.calibration.acceptance import Figure
from vcmm.learn.calibration.deviations import SAME, Limits, RecordedTest
from vcmm.learn.calibration.standards import TURN, about_common_circle, about_own_circle, circular
from vcmm.task.response.recording import Ints, Recording

PLANES = {"XY": (0, 1), "YZ": (1, 2), "ZX": (2, 0)}
ROUND = 0.02  # of the radius: points that lie further off are on no circle about that centre
FULL = TURN - np.radians(10.0)
LEAST_READINGS = 8
RADIAL = 0.99  # square of the cosine between what is read and the radius


@dataclass(frozen=True, eq=False)
class Circle:
    """plane; centre (3,) mm; per observed row: its angle, its direction out of the circle, which way it went (+1 counter-clockwise)."""

    plane: str
    radius: float
    rows: Ints
    angle: Array
    out: Array
    way: Array


def recorded_circles(
    tests: Sequence[RecordedTest], limits: Limits | None = None
) -> tuple[list[Figure], list[str]]:
    """Return ISO 230-4 figures of one plane per recording, gone round in both senses.

    The centre is that of the least-squares circle; an arc is left where the instrument had it unless [nuisance] centre frees it.
    D and F need a calibrated radius. Raises UsageError for recordings that are no circle, and for one sense only.
    """
    out: list[Figure] = []
    notes: list[str] = []
    for test in tests:
        circle = circle_of(test)
        figures, more = _figures(test, circle, limits or {})
        out, notes = [*out, *figures], [*notes, *more]
    return out, notes


@dataclass(frozen=True, eq=False)
class CirclePaths:
    """Radial deviations mm at angles rad in both senses of rotation, about the centre from which G(b), F and H are stated."""

    plane: str
    angle: Array
    ahead: Array
    back_angle: Array
    back: Array


def circle_paths(test: RecordedTest) -> CirclePaths:
    """Return the paths from which the figures of a recorded circle are computed. Raises UsageError for recordings that are no circle."""
    circle = circle_of(test)
    ahead, back = (np.flatnonzero(circle.way == w) for w in (1.0, -1.0))
    radial = _radial(test.recording, circle) @ test.value
    angle, back_angle = circle.angle[ahead], circle.angle[back]
    paths = radial[ahead], radial[back]
    if len(ahead) and len(back) and _is_about_own_centre(test, circle):
        paths = about_common_circle(angle, paths[0], back_angle, paths[1])
    return CirclePaths(circle.plane, angle, paths[0], back_angle, paths[1])


def radial_of(test: RecordedTest, value: Array) -> tuple[Circle, Array]:
    """Return the circle of a recording and `value` (m,) of its observations as radial deviations, one per row of the circle."""
    circle = circle_of(test)
    return circle, _radial(test.recording, circle) @ value


def _is_about_own_centre(test: RecordedTest, circle: Circle) -> bool:
    """Return whether the centre is found from the readings: of full circles, and where [nuisance] frees it."""
    swept = min(_swept_angle(circle.angle[circle.way == w]) for w in np.unique(circle.way))
    return swept >= FULL or "centre" in test.recording.nuisance or "rigid" in test.recording.nuisance


def width_of_path(test: RecordedTest, circle: Circle, radial: Array, way: float) -> float:
    """Return, of radial deviations (rows,), the range of the path gone round that way, as G+ (way 1) and G- (-1) state it."""
    mine = circle.way == way
    if not _is_about_own_centre(test, circle):
        return float(np.ptp(radial[mine]))
    return float(np.ptp(about_own_circle(circle.angle[mine], radial[mine])))


def _figures(test: RecordedTest, circle: Circle, limits: Limits) -> tuple[list[Figure], list[str]]:
    recording = test.recording
    ahead, back = (np.flatnonzero(circle.way == w) for w in (1.0, -1.0))
    for which, word in ((ahead, "counter-clockwise"), (back, "clockwise")):
        if len(which) < LEAST_READINGS:
            raise UsageError(
                f"{recording.name}: {len(which)} readings were taken {word} (seen from + onto {circle.plane}); ISO 230-4 takes both "
                "senses of rotation, in one file, in the order made"
            )
    swept = min(_swept_angle(circle.angle[w]) for w in (ahead, back))
    free = _is_about_own_centre(test, circle)
    radius_free = "radius" in recording.nuisance
    notes = []
    if swept < FULL:
        notes.append(
            f"{recording.name}: an arc of {np.degrees(swept):.0f} degrees; ISO 230-4 states D and F of full circles only"
        )
    if radius_free:
        notes.append(
            f"{recording.name}: the length of the bar is free ([nuisance] radius), so D and F, which need a calibrated one, are left out"
        )
    radial = _radial(recording, circle)

    def compute(value: Array) -> Mapping[str, Array]:
        paths = value @ radial.T
        values = circular(
            circle.angle[ahead], paths[..., ahead], paths[..., back], circle.angle[back], centred=free
        )
        gone = ("D", "F max", "F min") if radius_free or swept < FULL else ()
        return {n: v for n, v in values.items() if n not in gone}

    return test.figures(compute, circle.plane, limits, circle.radius), notes


def circle_of(test: RecordedTest) -> Circle:
    """Return the circle of a recording. Raises UsageError where two linear axes do not go round one centre."""
    recording = test.recording
    if recording.kind not in ("length", "displacement", "probe"):
        raise UsageError(
            f'{recording.name} is of kind "{recording.kind}"; ISO 230-4 takes lengths of a ball bar, or a grid plate (displacement)'
        )
    rows = np.unique(recording.row)
    moving = [a for a, q in recording.run.position.items() if float(np.ptp(q[rows])) > SAME]
    plane = next((p for p in PLANES if set(p) == set(moving)), "")
    if not plane:
        raise UsageError(
            f"{recording.name}: the axes {' '.join(moving) or 'none'} move; ISO 230-4 takes circles of two linear axes, one plane per recording"
        )
    tip = test.machine.prepare(recording.run).tip[rows][:, PLANES[plane]]
    centre = _centre(recording, tip, rows, plane)
    way = tip - centre
    size = np.linalg.norm(way, axis=1)
    radius = float(np.median(size))
    far = np.abs(size - radius) > ROUND * radius
    if far.any():
        raise UsageError(
            f"{recording.name}: {int(far.sum())} points lie off the circle of {radius:.4g} mm (first at {size[far][0]:.4g} mm); leave out "
            "where the axes fed in and out"
        )
    out = np.zeros((len(rows), 3))
    out[:, PLANES[plane]] = way / size[:, None]
    angle = np.arctan2(way[:, 1], way[:, 0])
    return Circle(plane, radius, rows, angle, out, _ways(recording, rows, angle, plane))


def _centre(recording: Recording, tip: Array, rows: Ints, plane: str) -> Array:
    """Return the centre (2,): from_x_mm ... of a ball bar; else that of the commanded points."""
    run = recording.run
    if recording.kind == "length":
        if "from_x_mm" not in run.columns or (recording.other >= 0).any():
            raise UsageError(
                f'{recording.name}: a ball bar needs its centre in from_x_mm from_y_mm from_z_mm, and [nuisance] centre = ""'
            )
        return np.asarray(run.vector("from_x_mm", "from_y_mm", "from_z_mm")[rows][0, PLANES[plane]])
    columns = np.column_stack([2 * tip, np.ones(len(tip))])
    return np.asarray(np.linalg.lstsq(columns, (tip**2).sum(axis=1), rcond=None)[0][:2])


def _ways(recording: Recording, rows: Ints, angle: Array, plane: str) -> Array:
    """Return +1 counter-clockwise, -1 clockwise (rows,): by the order of the rows, which must not contradict the senses of the file."""
    step = (np.diff(angle) + np.pi) % TURN - np.pi
    labels = [recording.run.labels[n][rows] for n in ("setup", "run") if n in recording.run.labels]
    step = np.where([any(label[i] != label[i + 1] for label in labels) for i in range(len(step))], 0.0, step)
    arrived, left = np.concatenate([[0.0], step]), np.concatenate([step, [0.0]])
    way = np.sign(np.where(np.abs(arrived) > 1e-9, arrived, left))
    for axis, slope in zip(plane, (-np.sin(angle), np.cos(angle))):
        name = f"sense_{axis}"
        if name in recording.run.columns:
            stated = recording.run.column(name)[rows]
            clear = (stated != 0) & (np.abs(slope) > 0.2) & (way != 0)
            wrong = clear & (np.sign(slope) * way != stated)
            if clear.any() and wrong.sum() > 0.5 * clear.sum():
                raise UsageError(
                    f"{recording.name}: {int(wrong.sum())} of {int(clear.sum())} rows move against their {name}; the labels of the "
                    "directions are exchanged, or the rows are not in the order made"
                )
    return np.asarray(way)


def _swept_angle(angle: Array) -> float:
    """Return the swept angle in rad: all round less the widest gap between neighbours, that gap counted as one step of the others."""
    order = np.sort(angle % TURN)
    gaps = np.array([b - a for a, b in pairwise([*order, order[0] + TURN])])
    return TURN - float(gaps.max()) + float(np.median(gaps))


def _radial(recording: Recording, circle: Circle) -> Array:
    """Return the matrix (rows, m) from observations to the radial deviation of every row. Raises UsageError where a row does not determine it."""
    out = np.zeros((len(circle.rows), recording.m))
    where = np.searchsorted(circle.rows, recording.row)
    out[where, np.arange(recording.m)] = (recording.direction * circle.out[where]).sum(axis=1)
    square = (out**2).sum(axis=1)
    if (square < RADIAL).any():
        raise UsageError(
            f"{recording.name}: {recording.places(np.flatnonzero(square[where] < RADIAL))} not read along the radius; a circle takes the length of "
            "a ball bar, a displacement along nx ny nz = the radius, or both directions of the plane (dx_um dy_um)"
        )
    return out
