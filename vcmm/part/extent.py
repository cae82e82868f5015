"""Compute whether points lie within the nominal extent of a feature."""

from __future__ import annotations

import numpy as np

from vcmm.core.pose import Array
from vcmm.part.nominal import distance_beside_known
from vcmm.part.part import Feature, frame

EDGE = 0.5  # mm beyond the nominal extent of a feature; edges of real parts are broken and lie a little elsewhere


def beyond_extent(feature: Feature, points: Array) -> Array:
    """Return how far (n,) mm points (n, 3) lie beyond the nominal ends or edges of a feature; negative or 0 within."""
    if feature.nominal is not None:
        return distance_beside_known(feature.nominal, points)
    u, v, w = frame(feature)
    arm = points - feature.point
    if feature.kind == "plane":
        half = np.array(feature.extent) / 2
        return np.asarray((np.abs(np.stack([arm @ u, arm @ v], axis=1)) - half).max(axis=1))
    if feature.kind in ("line", "cylinder", "cone"):
        along = arm @ w
        return np.maximum(-along, along - feature.extent[0])
    if feature.kind == "circle":
        return np.abs(arm @ w)
    return np.zeros(len(points))
