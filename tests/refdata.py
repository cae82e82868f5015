"""Reference point sets with a known least-squares answer: the null-space method (Cox and Forbes).

Points on the nominal surface, residuals r orthogonal to the columns of the Jacobian J of the distances,
points moved by r along their normals. J does not change on the way, so the nominal element is an exact
stationary point of the sum of squares, and a minimum while r is small against the radii. Shares no code with
vcmm.part.fit.

`touching` makes sets whose element by contact is known: points of contact whose gradients balance (the conditions of
optimality of Kuhn and Tucker) with multipliers of the right signs, all other points strictly inside.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np
from numpy.typing import NDArray

Array = NDArray[np.float64]
KINDS = ("point", "line", "plane", "circle", "sphere", "cylinder", "cone", "torus")
UP = np.array([0.0, 0.0, 1.0])
_POSE = {  # columns of [-n, -(x x n)] that are free, in standard position
    "plane": (2, 3, 4), "circle": (0, 1), "sphere": (0, 1, 2), "cylinder": (0, 1, 3, 4), "cone": (0, 1, 3, 4),
    "torus": (0, 1, 2, 3, 4),
}  # fmt: skip


@dataclass(frozen=True)
class Recipe:
    """n points; `size`: radius, ring or small-end radius; `form` peak to valley; `arc` rad; `length` mm."""

    n: int = 30
    size: float = 20.0
    form: float = 0.01
    arc: float = 2.0 * np.pi
    length: float = 50.0
    offset: float = 300.0


@dataclass(frozen=True, eq=False)
class Reference:
    """Points (n, 3) and the element: a point of it (3,), unit axis (3,), sizes (s,) as in vcmm.part.fit.Fitted."""

    kind: str
    points: Array
    point: Array
    axis: Array
    sizes: Array


def rotation(rng: np.random.Generator) -> Array:
    """Random rotation matrix (3, 3)."""
    q, r = np.linalg.qr(rng.standard_normal((3, 3)))
    q = q * np.sign(np.diag(r))
    return np.asarray(q * np.linalg.det(q))


def _null_part(rng: np.random.Generator, columns: Array, form: float) -> Array:
    """Residuals (m,) of peak to valley `form`, orthogonal to columns (m, p); zeros where nothing is left."""
    m, p = columns.shape
    q = np.linalg.qr(columns)[0]
    r = np.asarray(rng.standard_normal(m))
    for _ in range(2):  # the first pass leaves rounding of the size of the random vector
        r = np.subtract(r, q @ (q.T @ r))
    return r * (form / float(np.ptp(r))) if m > p else np.zeros(m)


Surface = tuple[
    Array, Array, Array, Array
]  # points (n, 3), outward normals (n, 3), partials (n, s), sizes (s,)


def _plane(rng: np.random.Generator, recipe: Recipe) -> Surface:
    n = recipe.n
    across = rng.uniform(-0.5, 0.5, n)
    flat = recipe.length * np.stack([rng.permutation(_spread(n)), across, np.zeros(n)], axis=1)
    return flat, np.tile(UP, (n, 1)), np.empty((n, 0)), np.empty(0)


def _sphere(rng: np.random.Generator, recipe: Recipe, e: Array) -> Surface:
    lift = rng.permutation(np.linspace(-0.2, 1.0, recipe.n))[:, None]
    normal = np.sqrt(1.0 - lift**2) * e + lift * UP
    return recipe.size * normal, normal, -np.ones((recipe.n, 1)), np.array([recipe.size])


def _cone(rng: np.random.Generator, recipe: Recipe, e: Array) -> Surface:
    angle, z = rng.uniform(0.03, 0.7), recipe.length * _spread(recipe.n)[:, None]
    cos, tan = np.cos(angle), np.tan(angle)
    radius = recipe.size + 0.5 * recipe.length * tan
    partials = np.concatenate([np.full_like(z, -cos), -z / cos], axis=1)
    return (radius + z * tan) * e + z * UP, cos * (e - tan * UP), partials, np.array([radius, angle])


def _torus(rng: np.random.Generator, recipe: Recipe, e: Array) -> Surface:
    tube, around = recipe.size * rng.uniform(0.1, 0.6), rng.uniform(0.0, 2.0 * np.pi, recipe.n)[:, None]
    normal = np.cos(around) * e + np.sin(around) * UP
    partials = np.concatenate([-np.cos(around), np.full_like(around, -1.0)], axis=1)
    return recipe.size * e + tube * normal, normal, partials, np.array([recipe.size, tube])


def _spread(n: int) -> Array:
    return np.linspace(-0.5, 0.5, n)


def _surface(kind: str, rng: np.random.Generator, recipe: Recipe) -> Surface:
    n = recipe.n
    turn = rng.permutation(recipe.arc * (np.arange(n) + rng.uniform(0.1, 0.9, n)) / n)
    e = np.stack([np.cos(turn), np.sin(turn), np.zeros(n)], axis=1)
    if kind == "plane":
        return _plane(rng, recipe)
    if kind in ("sphere", "cone", "torus"):
        return {"sphere": _sphere, "cone": _cone, "torus": _torus}[kind](rng, recipe, e)
    height = recipe.length * _spread(n) if kind == "cylinder" else np.zeros(n)
    return recipe.size * e + height[:, None] * UP, e, -np.ones((n, 1)), np.array([recipe.size])


def _scatter(kind: str, rng: np.random.Generator, recipe: Recipe) -> Array:
    """Points about the origin (mean 0) or about the z axis (deviations orthogonal to 1 and z)."""
    along = recipe.length * _spread(recipe.n)
    columns = np.ones((recipe.n, 1)) if kind == "point" else np.stack([np.ones(recipe.n), along], axis=1)
    x, y, z = (_null_part(rng, columns, recipe.form) for _ in range(3))
    return np.stack([x, y, z if kind == "point" else along], axis=1)


def _standard(kind: str, rng: np.random.Generator, recipe: Recipe) -> tuple[Array, Array]:
    """Points (n, 3) of an element in standard position, and its sizes."""
    if kind in ("point", "line"):
        return _scatter(kind, rng, recipe), np.empty(0)
    x, normal, partials, sizes = _surface(kind, rng, recipe)
    pose = np.concatenate([-normal, -np.cross(x, normal)], axis=1)[:, _POSE[kind]]
    x = x + _null_part(rng, np.concatenate([pose, partials], axis=1), recipe.form)[:, None] * normal
    if kind == "circle":  # heights whose least-squares plane is z = 0: the plane is fitted first
        x[:, 2] = _null_part(rng, np.stack([np.ones(len(x)), x[:, 0], x[:, 1]], axis=1), recipe.form)
    return x, sizes


def reference(kind: str, rng: np.random.Generator, recipe: Recipe | None = None) -> Reference:
    """Random reference set in a random pose."""
    recipe = recipe or Recipe()
    x, sizes = _standard(kind, rng, recipe)
    turn, shift = rotation(rng), rng.uniform(-recipe.offset, recipe.offset, 3)
    axis = turn[:, 2] if kind not in ("point", "sphere") else np.zeros(3)
    return Reference(kind, x @ turn.T + shift, shift, axis, sizes)


@dataclass(frozen=True, eq=False)
class Touching:
    """A reference with its contacts (k,) and the range of the distances from the element."""

    reference: Reference
    contacts: NDArray[np.intp]
    width: float


def touching(kind: str, criterion: str, rng: np.random.Generator, recipe: Recipe | None = None) -> Touching:
    """Random set in a random pose whose element by C, N, X or T is the nominal one, strictly."""
    recipe = recipe or Recipe()
    x, normal, partials, sizes = _surface(kind, rng, recipe)
    jac = np.concatenate([-normal, -np.cross(x, normal)], axis=1)[:, _POSE[kind]]
    if criterion in "CT":
        jac = np.concatenate([jac, partials], axis=1)
    rows, r = _balanced(criterion, jac, rng, recipe.form)
    x = x + r[:, None] * normal
    turn, shift = rotation(rng), rng.uniform(-recipe.offset, recipe.offset, 3)
    axis = turn[:, 2] if kind != "sphere" else np.zeros(3)
    return Touching(Reference(kind, x @ turn.T + shift, shift, axis, sizes), np.sort(rows), float(np.ptp(r)))


def _balanced(
    criterion: str, jac: Array, rng: np.random.Generator, form: float
) -> tuple[NDArray[np.intp], Array]:
    """Contacts and signed distances (n,): 0 or +-form/2 at contacts with balanced multipliers, inside elsewhere."""
    n, p = jac.shape
    for _ in range(20_000):
        rows = rng.choice(n, p if criterion == "T" else p + 1, replace=False)
        if criterion == "T":
            r = -form * rng.uniform(0.05, 1.0, n)
            r[rows] = 0.0
            weight = -np.linalg.solve(jac[rows].T, jac.T @ r)
            weight = weight / np.abs(weight).max()
        else:
            weight = np.linalg.svd(jac[rows].T)[2][-1]
            weight = weight / weight[np.argmax(np.abs(weight))]
            inward = {"C": rng.uniform(-0.45, 0.45, n), "N": rng.uniform(-1.0, -0.05, n)}
            r = form * inward.get(criterion, -inward["N"])
            r[rows] = 0.5 * form * np.sign(weight) if criterion == "C" else 0.0
        held = np.abs(weight) if criterion == "C" else weight
        if held.min() > 0.03:
            return rows, r
    raise AssertionError("no balanced contacts found; take more points")
