"""Evaluate a characteristic from fitted elements, for whole batches of trials.

    value = evaluate(characteristic, part.features, fitted, part_from_measured)      # (...) mm or rad

Everything is evaluated in the drawing frame. All types but position do not depend on the pose beyond the
second order; it tells which side is which and where the nominal centres and ends of features lie.

size         diameter of circle, sphere, cylinder; tube diameter of a torus; local sizes by rank (criteria.py)
distance     of two centres; or of the second feature's centre from the first feature's plane or axis. The
             centre of a plane or axis is its point nearest to the nominal centre of the feature. From a plane it has
             a sign: plus on the side where the drawing has it, along the normal where it lies in the plane.
angle        between normals, between axes; of an axis to a plane: to the surface, not to its normal. Acute
             or obtuse does not depend on how directions are drawn: the nominal angle is at most 90 deg.
run-out, profile   pointwise.py · patterns, projected zones, material requirements: drawing.py · common datums: common.py
form         range of the residuals of the element by the criterion: least squares (G), minimum zone (C), ...; filters.py
orientation  orientation.py · location: location.py
"""

from __future__ import annotations

import math
from collections.abc import Mapping
from dataclasses import replace

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.pose import Array, Pose, dot, length
from vcmm.part.fit import FittedElement
from vcmm.part.gps import criteria
from vcmm.part.gps.common import with_common
from vcmm.part.gps.datums import has_system, system_pose
from vcmm.part.gps.drawing import pattern, project, with_material
from vcmm.part.gps.elements import (
    AXES,
    CENTRES,
    MeasuredElement,
    anchor,
    centre,
    from_axis,
    nominal_element,
    place,
)
from vcmm.part.gps.filters import apply_filter, check_filter, minimum_zone
from vcmm.part.gps.location import coaxiality, position, symmetry
from vcmm.part.gps.orientation import orientation
from vcmm.part.gps.pointwise import (
    POINTWISE,
    PROFILE,
    RUNOUT,
    check_pointwise,
    profile,
    runout,
    turning_datum,
)
from vcmm.part.part import Characteristic, Feature, frame, kind_text

FORM = {
    "straightness": ("line",),
    "flatness": ("plane",),
    "roundness": ("circle", "sphere"),
    "cylindricity": ("cylinder",),
}
LOCATED_TYPES = ("parallelism", "perpendicularity", "angularity", "position", "coaxiality", "symmetry")
SAME_PLANE = 1e-9  # mm
SIZES = {"circle": 0, "sphere": 0, "cylinder": 0, "torus": 1}  # which of Fitted.sizes is the radius


def evaluate(
    characteristic: Characteristic,
    features: Mapping[str, Feature],
    fitted: Mapping[str, FittedElement],
    pose: Pose | None = None,
) -> Array:
    """Evaluate a characteristic: return its value (...) in mm or rad. `pose` = part_from_measured, one or a batch; None: fitted in the drawing
    frame.

    A position with datums is evaluated in the system of its datums, and moved as they leave it free; without datums it follows `pose`.
    UsageError: unknown or unmeasured feature, a feature that does not suit the type. ModelLimit: fitted directions far from the drawing (the pose is missing).
    """
    c = characteristic
    check(c)
    choice = criteria.choose_criteria(c)
    of, datums = measured_elements(c, features, fitted, pose)
    if c.type in RUNOUT and has_system(c):  # the datums lie where the drawing has them
        datums = [nominal_element(turning_datum(d.feature for d in datums))]
    if c.type in PROFILE:
        return profile(c, of[0], [d.feature for d in datums], choice.fit == "C")
    return with_material(c, of[0], _value(c, of, datums)) if c.material else _value(c, of, datums)


def measured_elements(
    c: Characteristic,
    features: Mapping[str, Feature],
    fitted: Mapping[str, FittedElement],
    pose: Pose | None = None,
) -> tuple[list[MeasuredElement], list[MeasuredElement]]:
    """Return the elements of a characteristic in the frame in which it is evaluated, and those of its datums."""
    choice = criteria.choose_criteria(c)
    features, fitted = with_common(c, features, fitted, choice.datums)
    pose = system_pose(c, features, fitted, choice, pose)
    pointwise = c.type in (*POINTWISE, *criteria.ORIENTATION_TYPES) or c.filter is not None
    of = [place(n, features, fitted, pose, k, pointwise) for n, k in zip((*c.of, *c.between), choice.of)]
    return of, [place(n, features, fitted, pose, k, False) for n, k in zip(c.datums, choice.datums)]


def nominal(characteristic: Characteristic, features: Mapping[str, Feature]) -> float:
    """Return the value of the drawing itself, mm or rad: 0 for form, orientation and location.

    Raises what `evaluate` would raise, so it also checks a characteristic before anything is measured.
    """
    c = characteristic
    check(c)
    criteria.check_kinds(c, features)
    if c.filter is not None:
        check_filter(c, features[c.of[0]])
        c = replace(c, filter=None)  # the drawing has no profile to filter
    features, _ = with_common(c, features)
    if c.type in POINTWISE:
        check_pointwise(c, features[c.of[0]], [features[d] for d in c.datums])
        return 0.0
    of, datums = ([nominal_element(features[n]) for n in names] for names in ((*c.of, *c.between), c.datums))
    return float(_value(c, of, datums))


def check(characteristic: Characteristic) -> None:
    """Raise UsageError for words that are no criterion of the type."""
    c = characteristic
    criteria.choose_criteria(c)


def needs(characteristic: Characteristic) -> tuple[str, ...]:
    """Return the names of the features that must be measured, without repetition."""
    return characteristic.features


def is_linear(characteristic: Characteristic, features: Mapping[str, Feature] | None = None) -> bool:
    """Return whether the value is smooth with a gradient other than zero: size, distance, angle of least-squares elements.

    False for extreme values and roots (form, orientation, location; any criterion of contact, local sizes) and, when
    `features` are given, for a distance of centres or angle that is 0 in the drawing.
    """
    if (
        characteristic.type not in ("size", "distance", "angle")
        or not criteria.choose_criteria(characteristic).gauss
    ):
        return False
    if features is None or nominal(characteristic, features) > 1e-6:
        return True
    return characteristic.type == "distance" and features[characteristic.between[0]].kind == "plane"


def unit(characteristic: Characteristic) -> str:
    """Return the unit: rad for an angle, else mm."""
    return "rad" if characteristic.type == "angle" else "mm"


def tolerance(characteristic: Characteristic, nominal: float) -> tuple[float, float] | None:
    """Lower and upper limit in the unit of the value: nominal + limits, or (0, zone); None without a
    requirement.
    """
    c = characteristic
    if c.zone is not None:
        return 0.0, c.zone
    return None if c.limits is None else (nominal + c.limits[0], nominal + c.limits[1])


def is_one_sided(characteristic: Characteristic) -> bool:
    """Return whether the lower limit 0 is a bound of nature and not a requirement: the type has a zone."""
    return characteristic.type not in ("size", "distance", "angle")


def _value(c: Characteristic, of: list[MeasuredElement], datums: list[MeasuredElement]) -> Array:
    """Return the value of a characteristic. of: the features of `of`, then those of `between`."""
    if c.type == "size":
        return _size(c, of[0])
    if c.type in ("distance", "angle"):
        return _distance(c, of[0], of[1]) if c.type == "distance" else _angle(c, of[0], of[1])
    if c.type in FORM:
        return _form(c, of[0])
    if c.type == "position":
        system = [d.feature for d in datums]
        return pattern(c, of, system) if len(of) > 1 else position(c, project(c, of[0]), system)
    if c.type in RUNOUT:
        return runout(c, of[0], datums[0])
    if c.type == "coaxiality":
        return coaxiality(c, of[0], datums[0])
    return symmetry(c, of, datums) if c.type == "symmetry" else orientation(c, of[0], datums[0])


def _size(c: Characteristic, e: MeasuredElement) -> Array:
    if e.feature.kind == "cone":
        raise UsageError(
            f'"{c.name}": a cone has no one size; use type = "angle" between its axis and a plane, or a '
            "circle at the section you need."
        )
    if e.feature.kind not in SIZES:
        raise UsageError(
            f'"{c.name}": {kind_text(e.feature.kind)} has no size; size is for {", ".join(SIZES)}.'
        )
    which = SIZES[e.feature.kind]
    if criteria.choose_criteria(c).of[0] in criteria.LOCAL:
        return criteria.local_size(c, 2.0 * e.sizes, 2.0 * float(e.feature.sizes[which]))
    return np.asarray(2.0 * e.sizes[..., which])


def _distance(c: Characteristic, a: MeasuredElement, b: MeasuredElement) -> Array:
    second = anchor(b)
    if a.feature.kind == "plane":
        over = float(dot(centre(b.feature) - a.feature.point, a.feature.axis))
        side = (
            -1.0 if over < -SAME_PLANE else 1.0
        )  # decided by the drawing: a step of 0 may come out either way
        return np.asarray(side * dot(second - a.point, a.axis))
    if a.feature.kind in AXES:
        return np.asarray(from_axis(second[..., None, :], a)[..., 0])
    if b.feature.kind not in CENTRES:
        hint = f'between = ["{b.feature.name}", "{a.feature.name}"]'
        raise UsageError(
            f'"{c.name}": name the {b.feature.kind} first, its distance to a centre is meant: {hint}.'
        )
    return length(second - anchor(a))


def _angle(c: Characteristic, a: MeasuredElement, b: MeasuredElement) -> Array:
    directed = ("plane", *AXES)
    for e in (a, b):
        if e.feature.kind not in directed:
            raise UsageError(
                f'"{c.name}": {kind_text(e.feature.kind)} has no direction; angle is for {", ".join(directed)}.'
            )
    turned = (
        -1.0 if a.feature.axis @ b.feature.axis < -1e-9 else 1.0
    )  # decided by the drawing: 90.01 deg stays so
    first, second = np.broadcast_arrays(a.axis, turned * b.axis)
    between = np.arctan2(length(np.cross(first, second)), dot(first, second))
    same = (a.feature.kind == "plane") == (b.feature.kind == "plane")
    return np.asarray(between if same else 0.5 * math.pi - between)


def _form(c: Characteristic, e: MeasuredElement) -> Array:
    if e.feature.kind not in FORM[c.type]:
        suits = " or ".join(kind_text(kind) for kind in FORM[c.type])
        raise UsageError(f'"{c.name}": {c.type} is for {suits}, not for {kind_text(e.feature.kind)}.')
    # a line lies on a surface: its deviation counts along the outward normal of that surface
    signed = e.offsets @ frame(e.feature)[0] if e.feature.kind == "line" else e.residuals
    if c.filter is not None:
        at = e.points.reshape(-1, *e.points.shape[-2:])[0]
        signed = apply_filter(c.filter, e.feature, at, signed)
        if criteria.choose_criteria(c).fit == "C":
            return minimum_zone(e.feature, at, signed)
    return np.asarray(signed.max(axis=-1) - signed.min(axis=-1))
