"""Run-out and profile (ISO 1101): characteristics that are evaluated from the measured points themselves.

circular run-out   the range of the distances from the datum axis in a section, the worst section counts; of a plane the range of the
                   heights along the axis on a circle, of a cone square to its surface
total run-out      the same over the whole surface
profile            twice the largest distance of a point from the nominal surface, which lies where the datums put it; motions that
                   they leave (all six without datums) are fitted, by criterion G or C. Sizes are theoretically exact: they are not fitted.
                   Of a free-form surface (mesh, points) the distances count along its normals at the places that the plan names
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.pose import Array, dot, length
from vcmm.part.gps.elements import AXES, MeasuredElement
from vcmm.part.gps.freedom import free_motions, largest_left, rows_for
from vcmm.part.part import Characteristic, Feature, centre, kind_text, normal, signed_distance

Ints = npt.NDArray[np.intp]
RUNOUT, PROFILE = ("circular_runout", "total_runout"), ("line_profile", "surface_profile")
POINTWISE = (*RUNOUT, *PROFILE)
TOGETHER = 0.5  # mm: points whose heights (radii of a face) differ by less lie in one section
COAXIAL = 1e-6  # mm by which the drawing itself may be off coaxial


def check_pointwise(c: Characteristic, feature: Feature, datums: Sequence[Feature]) -> None:
    """Raise UsageError: a feature or datum that does not suit the type, or a drawing that does not."""
    if c.type in PROFILE:
        if c.type == "line_profile" and feature.kind == "plane":
            raise UsageError(
                f'"{c.name}": line_profile is of a line or section; use surface_profile for a plane.'
            )
        return
    datum = turning_datum(datums)
    if datum.kind not in AXES:
        raise UsageError(f'"{c.name}": {c.type} turns about a datum axis; a {datum.kind} gives none.')
    if feature.kind not in ("circle", "cylinder", "cone", "sphere", "plane", "torus"):
        raise UsageError(
            f'"{c.name}": {c.type} is not for {kind_text(feature.kind)}; name a round feature or a face.'
        )
    if feature.kind == "plane":
        off = length(np.cross(feature.axis, datum.axis)) * max(feature.extent)
    else:
        arm = centre(feature) - datum.point
        off = length(arm - (arm @ datum.axis) * datum.axis)
    if float(off) > COAXIAL:
        raise UsageError(
            f'"{c.name}": in the drawing "{feature.name}" does not turn about "{datum.name}"; use position or profile.'
        )


def turning_datum(datums: Iterable[Feature]) -> Feature:
    """Return the datum about which a run-out turns: the first with an axis; the first of all where there is none."""
    names = list(datums)
    return next((d for d in names if d.kind in AXES), names[0])


def runout(c: Characteristic, e: MeasuredElement, datum: MeasuredElement) -> Array:
    """Return the range (...) mm of a run-out. ModelLimit where no section has two points."""
    arm = e.points - datum.point[..., None, :]
    axis = datum.axis[..., None, :]
    height = dot(arm, np.broadcast_to(axis, arm.shape))
    radius = length(arm - height[..., None] * axis)
    face = e.feature.kind == "plane"
    reading = height if face else radius
    if e.feature.kind == "cone":
        half = float(e.feature.sizes[1])
        way = 1.0 if e.feature.axis @ datum.feature.axis > 0 else -1.0
        reading = radius * np.cos(half) - way * height * np.sin(half)
    if c.type == "total_runout":
        return np.asarray(np.ptp(reading, axis=-1))
    groups = [g for g in _together(_first(radius if face else height)) if len(g) > 1]
    if e.feature.kind in ("circle", "sphere", "torus"):
        groups = [np.arange(reading.shape[-1], dtype=np.intp)]
    if not groups:
        raise ModelLimit(
            f'"{c.name}": no section of "{e.feature.name}" has two points; measure several on each section.'
        )
    return np.asarray(np.max([np.ptp(reading[..., g], axis=-1) for g in groups], axis=0))


def profile(c: Characteristic, e: MeasuredElement, datums: Sequence[Feature], minimax: bool) -> Array:
    """Return the width (...) mm of the zone about the nominal surface, points in the drawing frame."""
    feature, first = e.feature, _first(e.points, 2)
    middle = first.mean(axis=0)
    scale = max(float(np.ptp(first, axis=0).max()), 1.0)
    free = free_motions(datums, middle, scale)
    outward = e.normals if feature.free else normal(feature, first)
    moved = (rows_for(first, outward, middle, scale) @ free)[:, None, :]
    return 2.0 * largest_left(_departures(e)[..., None], moved, minimax)


def _departures(e: MeasuredElement) -> Array:
    """Return the distance (..., n) of the points from the nominal surface, + outwards; of a free-form surface along its normals at the
    nominal places."""
    if not e.feature.free:
        return np.asarray(signed_distance(e.feature, e.points))
    return dot(e.points - e.places, np.broadcast_to(e.normals, e.points.shape))


def _first(values: Array, tail: int = 1) -> Array:
    """Return the first member of a batch (..., n) or (..., n, 3)."""
    return values.reshape(-1, *values.shape[-tail:])[0]


def _together(values: Array) -> list[Ints]:
    order = np.argsort(values, kind="stable")
    breaks = np.flatnonzero(np.diff(values[order]) > TOGETHER) + 1
    return list(np.split(order, breaks))
