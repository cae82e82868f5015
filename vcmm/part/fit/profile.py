"""A line in a plane: straight through points of a surface, deviations counted along the normal of that surface.

The points are projected onto the plane that the nominal direction and the surface normal span; there the line is a
plane seen from the edge, with a height and one tilt. C is the minimum zone of two parallel lines (ISO 12780-1), T the
line on the free side of all points with the least sum of squares.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.part.fit.checks import check_convergence, element_of
from vcmm.part.fit.criteria import Association, check_criterion
from vcmm.part.fit.elements import RY, TZ, Array, FittedElement
from vcmm.part.fit.exchange import ContactGoal, ContactProblem, settle
from vcmm.part.fit.gauss import centre_points
from vcmm.part.fit.newton import State
from vcmm.part.fit.uniqueness import is_unique


def profile_line(
    criterion: str, points: Array, direction: Array, normal: Array, *, inside: bool = False
) -> Association:
    """Fit a line by criterion G, C or T through points (..., n, 3) mm in the plane of direction (3,) and normal (3,).

    residuals: distances in that plane, + on the side of the normal; the material is on the other side (inside: on
    this one). The element's point is the foot of the centroid of the points, its axis points along `direction`.
    UsageError: criterion, a normal along the direction. ModelLimit: fewer than two different places.
    """
    check_criterion("line", criterion)
    points = np.asarray(points, dtype=np.float64)
    batch, n = points.shape[:-2], points.shape[-2]
    axes = _axes(direction, normal)
    local = points.reshape(-1, n, 3) @ axes.T
    flat = local * [1.0, 0.0, 1.0]
    data, centroid, scale = centre_points(flat)
    if n < 2 or not (np.ptp(data[:, 0], axis=-1) > 1e-7).all():
        raise ModelLimit("line: the points all lie at one place along it; measure at two places at least.")
    slope = np.sum(data[:, 0] * data[:, 2], axis=-1) / np.sum(data[:, 0] ** 2, axis=-1)
    tilted = np.stack([-slope, np.zeros_like(slope), np.ones_like(slope)], axis=-1)
    tilted /= np.sqrt(1.0 + slope[:, None] ** 2)
    zero = np.zeros((len(data), 3))
    goal = ContactGoal(two_sided=True, has_size=True)
    if criterion != "C":
        goal = ContactGoal(has_size=True, tangent=True, sign=-1.0 if inside else 1.0)
    problem = ContactProblem(element_of("plane"), (TZ, RY), goal)
    state, contacts = State(zero, tilted, np.empty((len(data), 0))), np.zeros((len(data), n), dtype=bool)
    unique = np.ones(len(data), dtype=bool)
    if criterion != "G":
        settled_state = settle(problem, data, state)
        check_convergence(problem.element, settled_state.is_done, f"line by criterion {criterion}")
        state, contacts, unique = (
            settled_state.state,
            settled_state.contacts,
            is_unique(problem, data, settled_state),
        )
    residuals = np.einsum("bi,bin->bn", state.axis, data - state.point[..., None]) * scale
    along = np.stack([state.axis[:, 2], np.zeros(len(data)), -state.axis[:, 0]], axis=-1)
    foot = (state.point * scale + centroid) + local.mean(axis=1) * [0.0, 1.0, 0.0]
    normals = np.repeat((state.axis @ axes)[:, None], n, axis=1)
    parts = (foot @ axes, along @ axes, np.empty((len(data), 0)), residuals, normals, contacts, unique)
    point, axis, sizes, residuals, normals, contacts, unique = (
        a.reshape((*batch, *a.shape[1:])) for a in parts
    )
    return Association(FittedElement("line", point, axis, sizes, residuals, normals), contacts, unique)


def _axes(direction: Array, normal: Array) -> Array:
    """Return the rows (3, 3): along the line, square to the plane of the profile, normal."""
    along = np.asarray(direction, dtype=np.float64) / np.linalg.norm(direction)
    up = np.asarray(normal, dtype=np.float64) - (normal @ along) * along
    size = float(np.linalg.norm(up))
    if not size > 1e-9 * float(np.linalg.norm(normal)):
        raise UsageError("line: the normal of the surface lies along the line; give a normal square to it.")
    up = up / size
    return np.stack([along, np.cross(up, along), up])
