"""Parallelism, perpendicularity and angularity to one datum (ISO 1101).

The value is the width of the zone, at the theoretical angle to the fitted datum, that holds the toleranced feature:

a plane, a line on a surface   the extracted one: all measured points between two parallel planes. Where the datum leaves the planes
                               a turn (square to a datum plane, parallel to an axis) they turn until they are nearest to one another;
                               a line is looked at in the plane of its direction and the normal of its surface
the same with a modifier       (criterion C, G or T) the associated element over the nominal extent: the height range of the tilted
                               rectangle or line; the form deviation is not in it
an axis                        |sin(tilt)| length of the associated axis: the straightness of the median line is not in it

For an axis square to a datum plane, an axis parallel to a datum axis and so on (two angles are free to err)
it is the diameter of a cylindrical zone; where the datum fixes only one angle, the distance of two parallel
planes.
"""

from __future__ import annotations

import math

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.pose import Array, dot, length, unit
from vcmm.part.fit.exchange import least_largest
from vcmm.part.gps.criteria import is_extracted
from vcmm.part.gps.elements import AXES, MeasuredElement
from vcmm.part.part import Characteristic, Feature, frame, kind_text

FIXED = 1e-6  # sine, mm: below it the datum leaves the planes no turn
DATUMS = ("plane", "circle", "torus", *AXES)


def orientation(c: Characteristic, e: MeasuredElement, datum: MeasuredElement) -> Array:
    """Return the zone width (...) mm. UsageError: an element without direction or extent, or a drawing at another
    angle.
    """
    check_directions(c, e.feature, datum.feature)
    angle, turned = nominal_angle(c, e.feature, datum.feature)
    direction = turned * e.axis
    ideal = _ideal(direction, datum.axis, angle)
    if is_extracted(c, e.feature.kind) and not _is_perfect(c, e):
        return _extracted_width(e, datum.axis, ideal, angle)
    if e.feature.kind == "plane":
        return _plane_width(e.feature, direction, ideal)
    return np.asarray(length(direction - dot(direction, ideal)[..., None] * ideal) * e.feature.extent[0])


def _is_perfect(c: Characteristic, e: MeasuredElement) -> bool:
    """Return whether the element is the surface itself. Raises UsageError where it is not and its points are missing."""
    if e.points.shape[-2]:
        return False
    if np.any(e.residuals):
        raise UsageError(
            f'{c.type} of "{e.feature.name}" is of its measured points, which this calculation does not keep; '
            'criterion = "G" asks for the orientation of the least-squares element.'
        )
    return True


def _extracted_width(e: MeasuredElement, datum: Array, ideal: Array, angle: float) -> Array:
    """Return the distance (...) of two parallel planes that hold all points; ideal (..., 3): their normal, or the direction of a line."""
    middle = e.points.mean(axis=-2, keepdims=True)
    normal = ideal
    if e.feature.kind == "line":
        outward = frame(e.feature)[0]
        normal = unit(outward - dot(ideal, outward)[..., None] * ideal)
    heights = dot(e.points - middle, normal[..., None, :])
    way = np.cross(datum, ideal)
    if e.feature.kind == "line" or math.sin(angle) < FIXED:
        return np.asarray(heights.max(axis=-1) - heights.min(axis=-1))
    arms = (e.points - middle).reshape(-1, *e.points.shape[-2:])[0]  # places of one part are those of all
    slide = arms @ way.reshape(-1, 3)[0]
    columns = np.stack([np.ones(len(slide)), slide], axis=1)[:, : 1 + bool(np.ptp(slide) > FIXED)]
    basis = np.linalg.qr(columns)[0]
    left = heights - (heights @ basis) @ basis.T
    return 2.0 * least_largest(left, basis)


def check_directions(c: Characteristic, feature: Feature, datum: Feature) -> None:
    """Raise UsageError unless the feature is a plane or an axis with a length, and the datum has a direction."""
    if feature.kind not in ("plane", *AXES):
        raise UsageError(
            f'"{c.name}": {c.type} is for a plane, {", ".join(AXES)}, not for {kind_text(feature.kind)}.'
        )
    if datum.kind not in DATUMS:
        raise UsageError(f'"{c.name}": a {datum.kind} gives no datum direction; use {", ".join(DATUMS)}.')


def nominal_angle(c: Characteristic, feature: Feature, datum: Feature) -> tuple[float, float]:
    """Return the angle 0..pi/2 rad between the nominal directions, and the sign that turns the feature's direction for
    it.
    """
    along = float(feature.axis @ datum.axis)
    turned = -1.0 if along < 0.0 else 1.0
    drawn = math.atan2(float(length(np.cross(feature.axis, datum.axis))), abs(along))
    if c.type == "angularity":
        return drawn, turned
    same = (feature.kind == "plane") == (datum.kind == "plane")
    wanted = 0.0 if same == (c.type == "parallelism") else 0.5 * math.pi
    if abs(drawn - wanted) > 1e-6:
        off = math.degrees(abs(drawn - wanted))
        raise UsageError(
            f'"{c.name}": the drawing has "{feature.name}" {off:.4g} deg off {c.type} to "{datum.name}"; '
            "use angularity or correct the direction."
        )
    return wanted, turned


def _ideal(direction: Array, datum: Array, angle: float) -> Array:
    """Return the direction at `angle` to the datum that is nearest to `direction`."""
    beside = direction - dot(direction, datum)[..., None] * datum
    size = length(beside)[..., None]
    beside = np.divide(beside, size, out=np.zeros_like(beside), where=size > 0.0)
    return np.asarray(math.cos(angle) * datum + math.sin(angle) * beside)


def _plane_width(feature: Feature, direction: Array, ideal: Array) -> Array:
    """Return the height range of the nominal rectangle: each size times the slope along it."""
    u, v, _ = frame(feature)
    u = u - dot(ideal, u)[..., None] * ideal
    v = v - dot(ideal, v)[..., None] * ideal
    return np.asarray(
        np.abs(dot(direction, u)) * feature.extent[0] + np.abs(dot(direction, v)) * feature.extent[1]
    )
