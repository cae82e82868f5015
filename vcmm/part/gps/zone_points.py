"""Points for the picture of a tolerance zone: where points or axes lie in it, by the elements from which the value is evaluated.

Reference circles of a roundness profile (ISO 12181-1): least squares (LSC) and minimum zone (MZC), as deviations from the nominal circle.

A circle whose centre lies (x, y) off has the profile radius + x cos t + y sin t, exact to offset^2 / diameter: nanometres for profiles of
micrometres.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass

import numpy as np

from vcmm.core.pose import Pose
from vcmm.core.run import Array
from vcmm.part.fit import FittedElement
from vcmm.part.gps.characteristics import measured_elements
from vcmm.part.gps.drawing import paid_by_size, project
from vcmm.part.gps.elements import AXES, axis_ends
from vcmm.part.gps.filters import apply_filter, profile_places
from vcmm.part.part import Characteristic, Feature, ends, frame


@dataclass(frozen=True, eq=False)
class FlatPoints:
    """Residuals (n,) mm from the associated plane at places (n,) mm along its longer side."""

    along: Array
    residual: Array


@dataclass(frozen=True, eq=False)
class RoundPoints:
    """Deviations (n,) mm from the associated circle at angles (n,) rad; filtered: what the filter of the drawing keeps, or None."""

    angle: Array
    residual: Array
    filtered: Array | None


@dataclass(frozen=True, eq=False)
class PlacedAxis:
    """Place of the centre, or of both ends of the axis, (k, 2) mm about the nominal place; size_bonus: the bonus of the size for the zone
    (ISO 2692)."""

    off: Array
    size_bonus: float


def zone_points(
    c: Characteristic,
    features: Mapping[str, Feature],
    fitted: Mapping[str, FittedElement],
    places: Mapping[str, Array],
    pose: Pose | None = None,
) -> FlatPoints | RoundPoints | PlacedAxis | None:
    """Return the points of a flatness, of the roundness of a circle, or of the position of one hole, pin or centre; None for all else.

    places: where every feature was touched (n, 3) mm in the drawing frame.
    """
    if c.type not in ("flatness", "roundness", "position") or len(c.of) != 1:
        return None
    feature = features[c.of[0]]
    if c.type == "roundness" and feature.kind != "circle":
        return None
    if c.type == "position" and feature.kind not in ("cylinder", "cone", "circle"):
        return None
    element = measured_elements(c, features, fitted, pose)[0][0]
    at = places[c.of[0]]
    if c.type == "flatness":
        sides = (at - feature.point) @ frame(feature)[:2].T
        return FlatPoints(sides[:, int(np.argmax(np.ptp(sides, axis=0)))], element.residuals)
    if c.type == "roundness":
        kept = None if c.filter is None else apply_filter(c.filter, feature, at, element.residuals)
        return RoundPoints(profile_places(feature, at)[0], element.residuals, kept)
    element = project(c, element)
    axes = frame(feature)[:2]
    measured, drawn = (
        (axis_ends(element), ends(element.feature)) if feature.kind in AXES else (element.point[None], feature.point[None])
    )  # fmt: skip
    paid = float(paid_by_size(c, element)) if c.material else 0.0
    return PlacedAxis((measured - drawn) @ axes.T, paid)


def least_squares_circle(angle: Array, deviation: Array) -> tuple[Array, float]:
    """Return ((radius, x, y), roundness) of deviations (n,) at angles (n,) rad; in the unit of the deviations."""
    columns = _columns(angle)
    solution: Array = np.asarray(np.linalg.lstsq(columns, deviation, rcond=None)[0], dtype=np.float64)
    return solution, float(np.ptp(deviation - columns @ solution))


def minimum_zone_circles(angle: Array, deviation: Array) -> tuple[Array, float]:
    """Return ((radius, x, y) of the middle of both circles, their distance): the least h with |deviation - circle| <= h / 2, a linear programme."""
    from scipy.optimize import linprog

    scale = float(np.ptp(deviation)) or 1.0
    columns, target = _columns(angle), deviation / scale
    ones = np.ones((len(angle), 1))
    sides = np.block([[columns, -ones], [-columns, -ones]])
    ends = np.concatenate([target, -target])
    solution = linprog([0.0, 0.0, 0.0, 1.0], A_ub=sides, b_ub=ends, bounds=[(None, None)] * 3 + [(0.0, None)])
    circle = np.asarray(solution.x, dtype=np.float64)[:3] * scale
    return circle, float(np.ptp(deviation - columns @ circle))


def _columns(angle: Array) -> Array:
    return np.column_stack([np.ones_like(angle), np.cos(angle), np.sin(angle)])
