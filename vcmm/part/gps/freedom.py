"""Motions that datums leave free, and the best fit of points or patterns within them.

A datum holds the motions that change it: a plane one shift and two turns, a cylinder two and two, a sphere three shifts. What no
datum of a system holds is free, and a profile or a pattern of features may be moved there until its departures are least (ISO 5458,
ISO 1101): by least squares (criterion G), or so that the largest is smallest (C).
"""

from __future__ import annotations

from collections.abc import Iterable

import numpy as np

from vcmm.core.pose import Array
from vcmm.part.fit.exchange import least_largest
from vcmm.part.part import Feature, normal, surface_point

LAWSON = 200  # rounds of reweighting (C. L. Lawson 1961): the largest departure then errs by less than 1e-4 of itself
LEAST_RANK_SHARE = 1e-6


def rows_for(points: Array, directions: Array, centre: Array, scale: float) -> Array:
    """Return the displacement along `directions` (..., 3) of points (..., 3) per shift (mm) and turn about `centre` (of 1 mm at `scale`),
    as (..., 6)."""
    return np.concatenate([directions, np.cross((points - centre) / scale, directions)], axis=-1)


def held_displacements(datum: Feature, centre: Array, scale: float) -> Array:
    """Return the displacements of a datum's surface that a motion makes, as (k, 6); those in its row space are held."""
    if datum.kind == "point":
        points = datum.point[None]
    elif datum.kind == "line":
        points = surface_point(datum, np.array([0.0, datum.extent[0]]))
    elif datum.kind == "plane":
        a, b = (e / 2 for e in datum.extent)
        points = surface_point(datum, np.array([-a, a, -a, a]), np.array([-b, -b, b, b]))
    else:
        turn = np.arange(6) * (np.pi / 3)
        along = {"cylinder": (0.0, datum.extent[0]), "cone": (0.0, datum.extent[0])} if datum.extent else {}
        second = along.get(datum.kind, (0.0,) if datum.kind == "circle" else (-0.6, 0.7))
        points = np.concatenate([surface_point(datum, turn, np.full(6, s)) for s in second])
    return rows_for(points, normal(datum, points), centre, scale)


def free_motions(datums: Iterable[Feature], centre: Array, scale: float) -> Array:
    """Return the motions, as of `rows_for`, that no datum holds, as (6, f); all six without datums."""
    rows = [held_displacements(d, centre, scale) for d in datums]
    if not rows:
        return np.eye(6)
    _, sizes, vectors = np.linalg.svd(np.concatenate(rows))
    rank = int((sizes > LEAST_RANK_SHARE * max(float(sizes[0]), 1.0)).sum())
    return np.asarray(vectors[rank:].T)


def largest_left(departures: Array, moved: Array, minimax: bool) -> Array:
    """Return the largest |departure| of k places after the best free motion, as (...).

    departures (..., k, r) mm: r components per place; moved (k, r, f): their change per free motion. minimax: by exchange of the
    places that count where they have one component (a profile), by reweighting where they have several (a pattern).
    """
    k, r, f = moved.shape
    if f == 0:
        return np.asarray(np.linalg.norm(departures, axis=-1).max(axis=-1))
    flat = departures.reshape(*departures.shape[:-2], k * r)
    basis, sizes, _ = np.linalg.svd(moved.reshape(k * r, f), full_matrices=False)
    basis = basis[
        :, sizes > LEAST_RANK_SHARE
    ]  # motions that move none of the places are no motions of theirs
    left = flat - (flat @ basis) @ basis.T
    best = _largest(left, k, r)
    if not minimax or not basis.shape[1]:
        return best
    return np.minimum(best, least_largest(left, basis)) if r == 1 else _lawson(flat, basis, (k, r), best)


def _largest(left: Array, k: int, r: int) -> Array:
    return np.asarray(np.linalg.norm(left.reshape(*left.shape[:-1], k, r), axis=-1).max(axis=-1))


def _lawson(flat: Array, matrix: Array, shape: tuple[int, int], best: Array) -> Array:
    """Reweight by the departures until only the largest count."""
    k, r = shape
    weight = np.full((*flat.shape[:-1], k), 1.0 / k)
    tiny = 1e-12 * np.eye(matrix.shape[1])
    for _ in range(LAWSON):
        each = np.repeat(weight, r, axis=-1)
        normal_matrix = np.einsum("...i,if,ig->...fg", each, matrix, matrix) + tiny
        right = np.einsum("...i,if,...i->...f", each, matrix, flat)
        moved = np.linalg.solve(normal_matrix, right[..., None])[..., 0]
        left = np.linalg.norm((flat - moved @ matrix.T).reshape(*flat.shape[:-1], k, r), axis=-1)
        best = np.minimum(best, left.max(axis=-1))
        weight = weight * left
        weight = weight / np.maximum(weight.sum(axis=-1, keepdims=True), 1e-300)
    return best
