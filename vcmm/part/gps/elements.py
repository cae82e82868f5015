"""Fitted elements in the drawing frame, with their nominal features: the input of every evaluation."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError, choose_from
from vcmm.core.pose import Array, Pose, dot, length
from vcmm.part.fit import FittedElement
from vcmm.part.gps.criteria import POINTS, by_criterion
from vcmm.part.part import FEATURE_KINDS, Feature, centre, ends

AXES = ("line", "cylinder", "cone")
CENTRES = ("point", "circle", "sphere", "torus")
MAX_TILT = 0.2  # rad between a fitted and its nominal direction; more means that the pose is missing


@dataclass(frozen=True, eq=False)
class MeasuredElement:
    """A fitted element in the drawing frame; its axis points as the nominal one does. `offsets` (..., n, 3):
    the residuals of a line as vectors, from the element to each measured point. places, normals (n, 3): of a mesh, where its
    points lie in the drawing.
    """

    feature: Feature
    point: Array
    axis: Array
    sizes: Array
    residuals: Array
    offsets: Array
    points: Array = field(default_factory=lambda: np.zeros((0, 3)))
    places: Array = field(default_factory=lambda: np.zeros((0, 3)))
    normals: Array = field(default_factory=lambda: np.zeros((0, 3)))


def nominal_element(feature: Feature) -> MeasuredElement:
    """Return the feature itself as an element without residuals."""
    return MeasuredElement(
        feature, centre(feature), feature.axis, feature.sizes, np.zeros(1), np.zeros((1, 3))
    )


def place(
    name: str,
    features: Mapping[str, Feature],
    fitted: Mapping[str, FittedElement],
    pose: Pose | None,
    criterion: str = "G",
    pointwise: bool = True,
) -> MeasuredElement:
    """Return the element `name` by a criterion, moved to the drawing frame by `pose` = part_from_measured (None: it is
    there already). pointwise: with its measured points, where they are kept.

    UsageError: the feature is unknown or not measured. ModelLimit: its direction is more than MAX_TILT off
    nominal.
    """
    if name not in features:
        raise UsageError(f'Unknown feature "{name}".{choose_from(name, features)}')
    if name not in fitted:
        raise UsageError(f'Feature "{name}" is not measured; add a step for it to the plan.')
    feature, raw = features[name], by_criterion(name, fitted[name], criterion)
    by = Pose.identity() if pose is None else pose
    measured = fitted[name].also[POINTS].points if pointwise and POINTS in fitted[name].also else None
    if feature.free and measured is not None and raw.points is not None:
        return replace(
            nominal_element(feature), points=by.apply(measured), places=raw.points, normals=raw.normals
        )
    axis = _sign_axis(feature, by.turn_each(raw.axis))
    # only a line needs them: its residuals have a direction, those of surfaces a sign
    offsets = by.turn(raw.residuals[..., None] * raw.normals) if feature.kind == "line" else np.zeros((1, 3))
    points = np.zeros((0, 3)) if measured is None else by.apply(measured)
    return MeasuredElement(
        feature=feature, point=by.apply_each(raw.point), axis=axis, sizes=raw.sizes, residuals=raw.residuals,
        offsets=offsets, points=points,
    )  # fmt: skip


def _sign_axis(feature: Feature, axis: Array) -> Array:
    if feature.kind == "point" or not FEATURE_KINDS[feature.kind].direction:
        return axis
    along = dot(axis, feature.axis)
    tilt = float(np.max(np.arccos(np.minimum(np.abs(along), 1.0)), initial=0.0))
    if tilt > MAX_TILT:
        raise ModelLimit(
            f'The fitted direction of "{feature.name}" is {np.degrees(tilt):.1f} deg off the drawing: the '
            "pose of the part is missing or wrong; give an alignment or the pose."
        )
    return np.where(along < 0.0, -1.0, 1.0)[..., None] * axis


def anchor(e: MeasuredElement) -> Array:
    """Return the centre (..., 3) of an element: of a plane or axis the point nearest to the feature's nominal
    centre.
    """
    if e.feature.kind in CENTRES:
        return e.point
    near = centre(e.feature) - e.point
    along = dot(near, e.axis)[..., None] * e.axis
    return np.asarray(e.point + (near - along if e.feature.kind == "plane" else along))


def axis_ends(e: MeasuredElement) -> Array:
    """Return where the axis (..., 2, 3) passes the sections square to the nominal axis at the feature's two nominal
    ends.
    """
    out = ends(e.feature) - e.point[..., None, :]
    share = dot(out, e.feature.axis) / dot(e.axis, e.feature.axis)[..., None]
    return np.asarray(e.point[..., None, :] + share[..., None] * e.axis[..., None, :])


def from_axis(points: Array, e: MeasuredElement) -> Array:
    """Return the distance (..., k) of points (..., k, 3) from the axis of an element."""
    arm = points - e.point[..., None, :]
    axis = e.axis[..., None, :]
    return length(arm - dot(arm, axis)[..., None] * axis)
