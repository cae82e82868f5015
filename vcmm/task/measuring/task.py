"""Task: a plan placed in a machine, with the steps from errors of the machine to measured characteristics.

    indicated - true of each touch -> measured points (contact) -> fitted elements -> characteristics

Every step takes leading batch dimensions, one row per trial.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property

import numpy as np

from vcmm.core.errors import ModelLimit
from vcmm.core.inputs import Input
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.core.run import Array
from vcmm.part.alignment import align
from vcmm.part.fit import FittedElement, gauss
from vcmm.part.form import Lobes
from vcmm.part.gps import characteristics as gps
from vcmm.part.gps.criteria import criteria_needed, with_criteria
from vcmm.part.gps.datums import constrained_features
from vcmm.part.gps.filters import check_density
from vcmm.part.nominal import travel_onto
from vcmm.part.part import Feature, Part, frame
from vcmm.task.measuring.contact import touch
from vcmm.task.measuring.plan import Ints, Plan, Touches


@dataclass(frozen=True, eq=False)
class Task:
    """A measuring task: machine, part, plan placed in the machine, and what is known."""

    machine: Machine
    part: Part
    plan: Plan
    touches: Touches
    inputs: tuple[Input, ...]
    form: Array  # (n,) mm: departure of the real surface from nominal at each touch, along the outward normal
    forms: Mapping[str, Lobes] = field(
        default_factory=dict
    )  # stated ones, of which `form` holds what is known
    from_points: bool = (
        False  # `form` is what measured points lie beside the nominal surface, stated forms included
    )

    @cached_property
    def without_errors(self) -> Array:
        """Characteristics (C,) that a perfect machine would measure, mm or rad."""
        still = np.zeros((self.touches.run.n, 3))
        return evaluate_all(self, fit_features(self, measured_points(self, still)))


def measured_points(task: Task, indication_error: Array) -> Array:
    """Return the measured points (..., n, 3) in the drawing frame for errors indicated - true (..., n, 3) in workpiece axes.

    The tip runs along its approach, displaced by -error, until it touches the nominal surface; the indication
    there, less the qualified tip radius along the nominal normal, is the measured point.
    """
    t = task.touches
    bumps = per_normal(t) * task.form[:, None]
    displacement = -t.pose.inverse().turn(indication_error)
    out = np.empty(np.broadcast_shapes(indication_error.shape, t.points.shape))
    for name, rows in t.rows.items():
        out[..., rows, :] = _touch(task, name, rows, displacement[..., rows, :])
    return out + bumps


def per_normal(t: Touches) -> Array:
    """Return how far a measured point moves along its approach per mm that the surface lies further out, (n, 3)."""
    return np.asarray(t.approach / (t.normals * t.approach).sum(axis=1)[:, None])


def _touch(task: Task, name: str, rows: Ints, displacement: Array) -> Array:
    t, feature = task.touches, task.part.features[name]
    surface = task.part.mesh if feature.kind == "mesh" else feature
    assert surface is not None
    radius = t.tip_radius[rows, None]
    if feature.nominal is not None:
        feet, way = (t.points[rows], t.normals[rows]), t.approach[rows]
        start = feet[0] + radius * feet[1] + displacement
        travel = travel_onto(feature.nominal, feet, start, way, radius[:, 0])
        return np.asarray(feet[0] + travel[..., None] * way)
    # start clear of the surface, whatever the error, but not beyond the middle of a bore that the tip nearly fills
    back = np.full(radius.shape, 0.1 + 2 * float(np.abs(displacement).max(initial=0.0)))
    if feature.inside and len(feature.sizes):
        room = feature.sizes[-1 if feature.kind == "torus" else 0] - radius
        back = np.minimum(back, np.maximum(room, 0.0))
    begin = t.points[rows] + radius * t.normals[rows] - back * t.approach[rows]
    travel = np.empty(displacement.shape[:-1])
    for r in np.unique(t.tip_radius[rows]):
        same = t.tip_radius[rows] == r
        if r == 0.0 and feature.kind == "mesh":
            travel[..., same] = _onto_tangent_plane(t, rows[same], begin[same] + displacement[..., same, :])
            continue
        travel[..., same] = touch(
            surface, begin[same], t.approach[rows][same], float(r), displacement[..., same, :]
        )
    return np.asarray(begin + travel[..., None] * t.approach[rows] - radius * t.normals[rows])


def _onto_tangent_plane(t: Touches, rows: Ints, start: Array) -> Array:
    """Return the travel (..., m) of a tip of no size from start (..., m, 3) to the plane of the nominal point and normal: an error e beside it on a
    surface of curvature 1/R lies off that plane by e^2 / 2R, 4 nm for 10 um and 12 mm.
    """
    n = t.normals[rows]
    return np.asarray(((t.points[rows] - start) * n).sum(axis=-1) / (t.approach[rows] * n).sum(axis=-1))


def fit_features(task: Task, points: Array) -> dict[str, FittedElement]:
    """Return the Gauss elements of all measured features, with those by other criteria that the characteristics require."""
    out, read = {}, criteria_needed(task.part.characteristics, task.part.features)
    for name, rows in task.touches.rows.items():
        feature = task.part.features[name]
        if feature.free:
            if name in read:
                out[name] = _nominal_places(task, name)
            continue
        fixed = feature.axis if feature.kind == "circle" else None
        try:
            fitted = gauss(feature.kind, points[..., rows, :], nominal_element(feature), fixed_axis=fixed)
        except ModelLimit as error:
            raise ModelLimit(f'points of "{name}": {error}') from None
        out[name] = (
            _sign_residuals(fitted, feature, points[..., rows, :]) if feature.kind == "line" else fitted
        )
    rows_of, part = task.touches.rows, task.part
    pointed = constrained_features(part.characteristics, part.features)
    return with_criteria(
        part.characteristics, part.features, lambda name: points[..., rows_of[name], :], out, pointed=pointed
    )


def _nominal_places(task: Task, name: str) -> FittedElement:
    """Return the nominal places and normals of points on a free-form surface, which have no associated element."""
    t, none = task.touches, np.zeros(0)
    rows = t.rows[name]
    return FittedElement("mesh", np.zeros(3), np.zeros(3), none, none, t.normals[rows], points=t.points[rows])


def _sign_residuals(fitted: FittedElement, feature: Feature, points: Array) -> FittedElement:
    """Return a line with its residuals counted along the outward normal of the surface it lies on: straightness in that plane."""
    apart = points - fitted.point[..., None, :]
    along = (apart * fitted.axis[..., None, :]).sum(axis=-1, keepdims=True)
    outward = frame(feature)[0]
    residuals = (apart - along * fitted.axis[..., None, :]) @ outward
    return replace(fitted, residuals=residuals, normals=np.tile(outward, (residuals.shape[-1], 1)))


def nominal_element(feature: Feature) -> FittedElement:
    """Return the nominal feature as the start of a fit."""
    return FittedElement(
        feature.kind,
        feature.point,
        feature.axis,
        np.asarray(feature.sizes, dtype=float),
        np.zeros(0),
        np.zeros((0, 3)),
    )


def evaluate_all(task: Task, fitted: Mapping[str, FittedElement]) -> Array:
    """Evaluate characteristics (..., C) of fitted elements; the alignment is computed anew from them."""
    scheme, features = task.plan.alignment, task.part.features
    pose = None if scheme is None else align(scheme, features, fitted, Pose.identity())
    if not task.part.characteristics:
        return np.zeros((0,))
    columns = [gps.evaluate(c, features, fitted, pose) for c in task.part.characteristics]
    return np.stack(np.broadcast_arrays(*columns), axis=-1)


def check_densities(task: Task) -> None:
    """Raise UsageError where the touches of a filtered profile are too few for its cut-off, or not spaced as its filter needs."""
    for c in task.part.characteristics:
        if c.filter is not None and c.of[0] in task.touches.rows:
            check_density(c, task.part.features[c.of[0]], task.touches.points[task.touches.rows[c.of[0]]])
