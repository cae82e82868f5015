"""Check points that are given one by one, in a file or a list, against the nominal surface."""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import UsageError
from vcmm.core.pose import Array, dot, unit
from vcmm.part.mesh import Mesh, closest
from vcmm.part.part import Feature, normal, signed_distance
from vcmm.task.measuring.strategies import check_enough, feature_text


def on_surface(
    feature: Feature,
    points: npt.ArrayLike,
    normals: npt.ArrayLike | None = None,
    mesh: Mesh | None = None,
    tolerance: float = 0.01,
) -> tuple[Array, Array]:
    """Return checked explicit points (n, 3) and their unit normals (n, 3), computed where not given.

    UsageError: a point lies further than `tolerance` mm from the nominal surface (kind mesh: from the mesh),
    a normal points into the material, a number is not finite, or there are too few points.
    """
    p = np.asarray(points, dtype=np.float64)
    if p.ndim != 2 or p.shape[1] != 3 or not np.all(np.isfinite(p)):
        raise UsageError(
            f"{feature_text(feature)}: points must be finite numbers (n, 3), got the shape {p.shape}."
        )
    check_enough(feature, len(p))
    distance, outward = _surface(feature, p, mesh)
    far = int(np.argmax(np.abs(distance)))
    if abs(distance[far]) > tolerance:
        raise UsageError(
            f"{feature_text(feature)}: point {far + 1} lies {distance[far]:.4g} mm from the nominal surface, "
            f"more than {tolerance:g} mm; correct the point or the feature."
        )
    return p, outward if normals is None else _checked_normals(feature, normals, outward)


def _surface(feature: Feature, points: Array, mesh: Mesh | None) -> tuple[Array, Array]:
    if feature.kind != "mesh":
        return signed_distance(feature, points), normal(feature, points)
    if mesh is None:
        raise UsageError(f"{feature_text(feature)}: it lies on a mesh; pass the mesh of the part.")
    return closest(mesh, points)


def _checked_normals(feature: Feature, normals: npt.ArrayLike, outward: Array) -> Array:
    given = np.asarray(normals, dtype=np.float64)
    if given.shape != outward.shape:
        raise UsageError(
            f"{feature_text(feature)}: {len(outward)} points need as many normals, got the shape {given.shape}."
        )
    given = unit(given)
    agree = dot(given, outward)
    worst = int(np.argmin(agree))
    if agree[worst] <= 0.0:
        raise UsageError(
            f"{feature_text(feature)}: the normal of point {worst + 1} points into the material; turn it round."
        )
    return given
