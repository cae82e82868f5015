"""Compute where a probing tip touches a surface when the machine has errors.

The tip, a ball of radius r, is commanded along start + t direction (a unit vector into the surface) and is
displaced by an error e: actual = commanded + e. Contact is the first t at which the ball meets the surface:

    signed_distance(start + t direction + e) = r

The machine indicates the commanded centre start + t direction and corrects it by r against the nominal
outward normal n. On a plane the corrected point departs from the true one by -(e . n) / (direction . n) along
the direction; for an approach along the normal that is -e . n along n, the first-order rule (error = -tip
error). On a surface of radius R the part e_t of e square to the normal adds a curvature term; for a shaft
|(R + r + x) n + e| = R + r gives x, the departure along n:

    shaft, ball:   x = -e_n - e_t^2 / (2 (R + r))       the shaft reads smaller
    bore, socket:  x = -e_n + e_t^2 / (2 (R - r))       the bore reads smaller too: n points to the axis
"""

from __future__ import annotations

import numpy as np
import numpy.typing as npt

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.core.pose import Array, dot, length
from vcmm.part.mesh import Mesh, sweep
from vcmm.part.part import Feature, normal, signed_distance


def touch(
    surface: Feature | Mesh,
    start: npt.ArrayLike,
    direction: npt.ArrayLike,
    tip_radius: float,
    displacement: npt.ArrayLike | None = None,
    search: float = 100.0,
) -> Array:
    """Return the travel (..., n) mm to the first contact, to rounding (about 1e-13 mm), in the frame of the surface.

    start (n, 3), direction (n, 3) or (3,) unit, displacement (..., n, 3) mm. Nominal surfaces are unbounded
    (part.signed_distance); a mesh ends where it ends and is touched on faces, edges and corners.
    ModelLimit: a point, named by its number, starts in the material or misses the surface within `search` mm;
    the tip does not fit into the bore. UsageError: shapes, direction not of length 1, mesh with tip radius 0.
    """
    begin, way = _check_start(start, direction)
    error = np.zeros_like(begin) if displacement is None else np.asarray(displacement, dtype=np.float64)
    try:
        actual = begin + error
    except ValueError as mismatch:
        raise UsageError(
            f"displacement {error.shape} does not fit {len(begin)} points; use (..., n, 3)."
        ) from mismatch
    if not (np.all(np.isfinite(actual)) and np.isfinite(tip_radius) and tip_radius >= 0.0):
        raise UsageError("Start, displacement and tip radius must be finite, the radius not negative.")
    travel = _travel(surface, actual, way, float(tip_radius), search)
    _check_contact(surface, travel, search)
    return travel


def _check_start(start: npt.ArrayLike, direction: npt.ArrayLike) -> tuple[Array, Array]:
    begin = np.asarray(start, dtype=np.float64)
    if begin.ndim != 2 or begin.shape[1] != 3:
        raise UsageError(f"start must have the shape (n, 3), got {begin.shape}.")
    way = np.asarray(direction, dtype=np.float64)
    if way.shape not in ((3,), begin.shape):
        raise UsageError(f"direction must have the shape (3,) or {begin.shape}, got {way.shape}.")
    if not np.all(np.abs(length(way) - 1.0) < 1e-9):
        raise UsageError("direction must hold unit vectors; divide it by its length.")
    return begin, np.broadcast_to(way, begin.shape)


def _travel(surface: Feature | Mesh, actual: Array, way: Array, radius: float, search: float) -> Array:
    """Return the travel; inf where there is no contact, -inf where the ball starts in the material."""
    if isinstance(surface, Mesh):
        return _on_mesh(surface, actual, way, radius, search)
    if surface.kind in ("circle", "cylinder", "sphere"):
        travel = _on_round(surface, actual, way, radius)
    elif surface.kind == "cone":
        travel = _on_cone(surface, actual, way, radius)
    elif surface.kind == "torus":
        travel = _on_torus(surface, actual, way, radius)
    else:
        travel = _on_plane(surface, actual, way, radius)
    begins_in = signed_distance(surface, actual) < radius
    return np.where(begins_in, -np.inf, np.where(travel <= search, travel, np.inf))


def _on_plane(surface: Feature, actual: Array, way: Array, radius: float) -> Array:
    closing = -dot(way, normal(surface, actual))
    gap = signed_distance(surface, actual) - radius
    return np.where(closing > 0.0, gap / np.where(closing > 0.0, closing, 1.0), np.inf)


def _on_round(surface: Feature, actual: Array, way: Array, radius: float) -> Array:
    """Return the travel to a circle, cylinder or sphere: the tip centre meets the surface of radius R + r, in a bore R - r."""
    reach = surface.sizes[0] + (-radius if surface.inside else radius)
    if reach <= 0.0:
        raise ModelLimit(_too_large(surface, radius, surface.sizes[0]))
    arm, across = actual - surface.point, way
    if surface.kind != "sphere":
        arm = arm - dot(arm, surface.axis)[..., None] * surface.axis
        across = way - dot(way, surface.axis)[..., None] * surface.axis
    square = dot(across, across)
    moves = square > 1e-24
    nearest = -dot(arm, across) / np.where(moves, square, 1.0)
    beside = arm + nearest[..., None] * across
    rest = reach**2 - dot(beside, beside)  # at the nearest place: no cancellation of large squares
    back = np.sqrt(np.maximum(rest, 0.0) / np.where(moves, square, 1.0))
    travel = nearest + back if surface.inside else nearest - back
    return np.where(moves & (rest >= 0.0) & (travel >= 0.0), travel, np.inf)


def _on_cone(surface: Feature, actual: Array, way: Array, radius: float) -> Array:
    """Return the travel to a cone, by a quadratic: the tip centre meets the cone of a radius larger (bore: smaller) by r / cos(half angle)."""
    slope = float(np.tan(surface.sizes[1]))
    grown = surface.sizes[0] + (-radius if surface.inside else radius) * np.hypot(1.0, slope)
    arm = actual - surface.point
    along, climb = dot(arm, surface.axis), dot(way, surface.axis)
    arm, across = arm - along[..., None] * surface.axis, way - climb[..., None] * surface.axis
    size, grows = grown + slope * along, slope * climb
    a = dot(across, across) - grows**2
    b = dot(arm, across) - size * grows
    c = dot(arm, arm) - size**2
    root = np.sqrt(np.maximum(b * b - a * c, 0.0))
    q = -(b + np.where(b < 0.0, -root, root))  # no cancellation: the two roots are q / a and c / q
    pair = np.stack([_ratio(q, a), _ratio(c, q)], axis=-1)
    pair = np.where(size[..., None] + grows[..., None] * pair >= 0.0, pair, np.inf)  # not beyond the apex
    return _first(surface, actual, way, radius, pair)


def _on_torus(surface: Feature, actual: Array, way: Array, radius: float) -> Array:
    """Return the travel to a torus, by a quartic: the tip centre meets the torus whose tube is larger (bore: smaller) by r.

    With p = o + t d, o square to d and s = |o|^2 + R^2 - q^2:  (t^2 + s)^2 = 4 R^2 |p square to the axis|^2.
    """
    ring, tube = surface.sizes
    grown = tube + (-radius if surface.inside else radius)
    if grown <= 0.0:
        raise ModelLimit(_too_large(surface, radius, tube))
    arm = actual - surface.point
    nearest = -dot(arm, way)
    near = arm + nearest[..., None] * way
    flat = near - dot(near, surface.axis)[..., None] * surface.axis
    across = way - dot(way, surface.axis)[..., None] * surface.axis
    rest = dot(near, near) + ring**2 - grown**2
    matrix = np.zeros((*nearest.shape, 4, 4))  # companion matrix of the quartic in t / ring
    matrix[..., 1:, :3] = np.eye(3)
    matrix[..., 2, 3] = 4.0 * dot(across, across) - 2.0 * rest / ring**2
    matrix[..., 1, 3] = 8.0 * dot(flat, across) / ring
    matrix[..., 0, 3] = 4.0 * dot(flat, flat) / ring**2 - (rest / ring**2) ** 2
    roots = np.linalg.eigvals(matrix)
    real = nearest[..., None] + ring * np.where(np.abs(roots.imag) < 1e-6, roots.real, np.inf)
    return _first(surface, actual, way, radius, real)


def _first(surface: Feature, actual: Array, way: Array, radius: float, candidates: Array) -> Array:
    """Return the smallest true root among candidates (..., n, k), after Newton steps that remove their rounding."""
    travel = np.where(np.isfinite(candidates), candidates, 0.0)
    for _ in range(3):
        place = actual[..., None, :] + travel[..., None] * way[..., None, :]
        closing = -dot(normal(surface, place), way[..., None, :])
        gap = signed_distance(surface, place) - radius
        travel = travel + np.where(np.abs(closing) > 1e-6, gap / np.where(closing == 0.0, 1.0, closing), 0.0)
    place = actual[..., None, :] + travel[..., None] * way[..., None, :]
    missed = np.abs(signed_distance(surface, place) - radius) > 1e-9 * (1.0 + np.abs(travel))
    wrong = missed | ~np.isfinite(candidates) | (travel < 0.0)
    return np.asarray(np.where(wrong, np.inf, travel).min(axis=-1))


def _ratio(a: Array, b: Array) -> Array:
    return np.divide(a, b, out=np.full_like(a, np.inf), where=b != 0.0)


def _too_large(surface: Feature, radius: float, room: float) -> str:
    return f'The tip of {2.0 * radius:g} mm does not fit into "{surface.name}" of {2.0 * room:g} mm.'


def _on_mesh(mesh: Mesh, actual: Array, way: Array, radius: float, search: float) -> Array:
    if radius <= 0.0:
        raise UsageError("Touching a mesh needs a tip radius above zero.")
    flat = actual.reshape(-1, *actual.shape[-2:])
    return sweep(mesh, flat, way, radius, search).reshape(actual.shape[:-1])


def _check_contact(surface: Feature | Mesh, travel: Array, search: float) -> None:
    bad = np.argwhere(~np.isfinite(travel))
    if len(bad) == 0:
        return
    name = "the mesh" if isinstance(surface, Mesh) else f'"{surface.name}"'
    trial = f" of trial {tuple(bad[0][:-1].tolist())}" if travel.ndim > 1 else ""
    where = f"Point {bad[0][-1] + 1}{trial}"
    if travel[tuple(bad[0])] < 0.0:
        raise ModelLimit(f"{where} starts in contact with {name}; start further out, along the normal.")
    raise ModelLimit(
        f"{where} does not meet {name} within {search:g} mm; check approach direction and clearance."
    )
