"""Position, coaxiality and symmetry (ISO 1101), from the associated elements: twice the largest departure.

position     spherical zone for sphere, torus and their centres; cylindrical for circles and, at the worse of
             the two ends, for axes; two parallel planes for planes (worst corner), points and lines (along
             their normal). Moved as its datums leave it free, until the zone is smallest.
coaxiality   cylindrical zone about the fitted datum axis, worse end.
symmetry     two parallel planes about the fitted datum plane, worst end or corner. Two planes in `of` or
             `datums` stand for the plane midway between them (slot, tongue).
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.pose import Array, dot, length, unit
from vcmm.part.gps.elements import AXES, CENTRES, MeasuredElement, anchor, axis_ends, from_axis
from vcmm.part.gps.freedom import free_motions, largest_left, rows_for
from vcmm.part.gps.orientation import DATUMS
from vcmm.part.part import Characteristic, Feature, ends, frame, kind_text

DRAWING_TOLERANCE = 1e-6  # mm by which the drawing itself may be off coaxial or symmetrical


def position(c: Characteristic, e: MeasuredElement, datums: Sequence[Feature] = ()) -> Array:
    """Return the zone (...) mm of an element in the drawing frame. Motions that a system of `datums` leaves free minimise it (ISO 1101:2017, 4;
    ISO 5459:2011, 6: a tolerance zone is locked by its datums alone); without datums the frame is that of the alignment.
    """
    drawn, rows, off = departures(c, e)
    middle = drawn.mean(axis=0)
    scale = max(float(np.ptp(drawn, axis=0).max()), 1.0)
    free = np.zeros((6, 0))
    if datums and not any(d.free for d in datums):
        free = free_motions(datums, middle, scale)
    moved = np.stack([rows_for(drawn, np.broadcast_to(r, drawn.shape), middle, scale) for r in rows], axis=1)
    return 2.0 * largest_left(off, moved @ free, minimax=True)


def departures(c: Characteristic, e: MeasuredElement) -> tuple[Array, Array, Array]:
    """Return the drawn places (k, 3) of an element, the directions (r, 3) that count, and how far it lies off along them (..., k, r) mm."""
    feature = e.feature
    axes = frame(feature)
    if feature.kind in ("plane", "cylinder", "cone"):
        out = corners(e) if feature.kind == "plane" else axis_ends(e)
        drawn = _nominal_corners(feature) if feature.kind == "plane" else ends(feature)
        rows = axes[2:] if feature.kind == "plane" else axes[:2]
        return drawn, rows, (out - drawn) @ rows.T
    if feature.kind == "line":
        return ends(feature), axes[:1], (axis_ends(e) - ends(feature)) @ axes[:1].T
    if feature.free:
        raise UsageError(
            f'"{c.name}": "{feature.name}" is a free-form surface and has no position; name another feature.'
        )
    rows = {"point": axes[2:], "circle": axes[:2]}.get(feature.kind, axes)
    return feature.point[None], rows, ((e.point - feature.point) @ rows.T)[..., None, :]


def coaxiality(c: Characteristic, e: MeasuredElement, datum: MeasuredElement) -> Array:
    """Return the zone (...) mm of an axis (its worse end) or a centre about the datum axis. UsageError: see
    `_check_drawing`.
    """
    if datum.feature.kind not in DATUMS or datum.feature.kind == "plane":
        raise UsageError(
            f'"{c.name}": a {datum.feature.kind} gives no datum axis; name a cylinder, cone or line.'
        )
    if e.feature.kind not in ("circle", "sphere", "torus", *AXES):
        raise UsageError(
            f'"{c.name}": {kind_text(e.feature.kind)} has no axis or centre; name a cylinder, circle or sphere.'
        )
    if e.feature.kind in AXES:
        drawn, points = ends(e.feature), axis_ends(e)
    else:
        drawn, points = e.feature.point[None], e.point[..., None, :]
    arm = drawn - datum.feature.point
    _check_drawing(c, length(arm - np.outer(arm @ datum.feature.axis, datum.feature.axis)))
    return np.asarray(2.0 * from_axis(points, datum).max(axis=-1))


def symmetry(c: Characteristic, of: list[MeasuredElement], datums: list[MeasuredElement]) -> Array:
    """Return the zone (...) mm about the datum plane, or the plane midway between two datum planes."""
    pairs = [*datums, *(of if len(of) == 2 else [])]
    if any(e.feature.kind != "plane" for e in pairs):
        raise UsageError(
            f'"{c.name}": symmetry takes planes as datums, and one feature or two planes in "of".'
        )
    e, datum = _middle(of), _middle(datums)
    _check_drawing(c, np.abs((_nominal_places(e.feature) - datum.feature.point) @ datum.feature.axis))
    out = _places(e) - datum.point[..., None, :]
    return np.asarray(2.0 * np.abs(dot(out, datum.axis[..., None, :])).max(axis=-1))


def corners(e: MeasuredElement) -> Array:
    """Return where the fitted plane (..., 4, 3) passes the four corners of the nominal rectangle, along the nominal
    normal.
    """
    drawn = _nominal_corners(e.feature)
    height = dot(e.point[..., None, :] - drawn, e.axis[..., None, :]) / dot(e.axis, e.feature.axis)[..., None]
    return np.asarray(drawn + height[..., None] * e.feature.axis)


def _nominal_corners(feature: Feature) -> Array:
    u, v, _ = frame(feature)
    a, b = 0.5 * feature.extent[0] * u, 0.5 * feature.extent[1] * v
    return feature.point + np.stack([a + b, a - b, -a + b, -a - b])


def _places(e: MeasuredElement) -> Array:
    """Return the corners, ends or centre (..., k, 3) of an element."""
    if e.feature.kind == "plane":
        return corners(e)
    return anchor(e)[..., None, :] if e.feature.kind in CENTRES else axis_ends(e)


def _nominal_places(feature: Feature) -> Array:
    if feature.kind == "plane":
        return _nominal_corners(feature)
    return feature.point[None] if feature.kind in CENTRES else ends(feature)


def _middle(elements: list[MeasuredElement]) -> MeasuredElement:
    """Return the element itself, or of two planes the one midway between them, over the extent of the first."""
    first, last = elements[0], elements[-1]
    if first is last:
        return first
    facing = -1.0 if first.feature.axis @ last.feature.axis < 0.0 else 1.0
    point = 0.5 * (anchor(first) + anchor(last))
    feature = replace(first.feature, point=0.5 * (first.feature.point + last.feature.point))
    return replace(first, feature=feature, point=point, axis=unit(first.axis + facing * last.axis))


def _check_drawing(c: Characteristic, off: Array) -> None:
    worst = float(np.max(off))
    if worst > DRAWING_TOLERANCE:
        raise UsageError(
            f'"{c.name}": in the drawing the feature is {worst:.4g} mm off {c.type}; '
            "use position or correct the point."
        )
