"""Contradictions of a drawing: limits that no part can meet together, zones without effect, datums that leave a feature free."""

from __future__ import annotations

from collections.abc import Mapping, Sequence

import numpy as np

from vcmm.core.pose import Array
from vcmm.part.gps.characteristics import nominal, tolerance
from vcmm.part.gps.criteria import EXTRACTED_KINDS, ORIENTATION_TYPES
from vcmm.part.gps.elements import nominal_element
from vcmm.part.gps.freedom import free_motions, held_displacements, rows_for
from vcmm.part.gps.location import departures
from vcmm.part.part import Characteristic, Feature, centre

MEASURED_TYPES = ("size", "distance", "angle")
ABOVE = ("position", "coaxiality", "symmetry")
MOVES = 1e-6  # mm per mm: less is rounding


def contradictions(
    characteristics: Sequence[Characteristic], features: Mapping[str, Feature]
) -> list[tuple[int, str]]:
    """Return (number, what is wrong) of requirements that no part can meet: no common value with an earlier one, a size below zero."""
    out = []
    for i, c in enumerate(characteristics):
        limits = _limits(c, features)
        if limits is None or c.type not in MEASURED_TYPES:
            continue
        if c.type == "size" and limits[0] < 0.0:
            out.append(
                (
                    i,
                    f'"{c.name}": its lower limit is a size of {limits[0]:g} mm, and no size is below zero; correct the limits',
                )
            )
        for earlier in characteristics[:i]:
            other = _limits(earlier, features)
            if other is None or _identity(earlier) != _identity(c):
                continue
            if limits[0] > other[1] or other[0] > limits[1]:
                out.append(
                    (
                        i,
                        f'"{c.name}" and "{earlier.name}" are limits of the same thing, and no part keeps both; correct one of them',
                    )
                )
    return out


def _limits(c: Characteristic, features: Mapping[str, Feature]) -> tuple[float, float] | None:
    return tolerance(c, nominal(c, features))


def _identity(c: Characteristic) -> tuple[object, ...]:
    return (c.type, c.of, tuple(sorted(c.between)), c.criterion)


def redundant_zones(characteristics: Sequence[Characteristic], features: Mapping[str, Feature]) -> list[str]:
    """Return the zones that a narrower zone of higher rank already implies: location implies orientation (ISO 1101:2017, 7) where both are of the
    same associated element. The orientation of a plane is that of its extracted surface, which a place of its associated plane does not hold.
    """
    out = []
    for c in characteristics:
        if c.type not in ORIENTATION_TYPES or not c.of or features[c.of[0]].kind in EXTRACTED_KINDS:
            continue
        for other in characteristics:
            same = other.of == c.of and set(c.datums) <= set(other.datums)
            if other.type in ABOVE and same and c.zone and other.zone and c.zone >= other.zone:
                out.append(
                    f'"{c.name}" ({c.zone:g} mm) asks for nothing: "{other.name}" ({other.zone:g} mm) holds {c.of[0]} closer already'
                )
    return out


def left_free(c: Characteristic, features: Mapping[str, Feature]) -> Array:
    """Return the motions (shift, turn) that the datums of a position leave free and that move its feature, as (f, 6); none for other types.

    Common datums and free-form surfaces count as held in full.
    """
    names = (*c.of, *c.datums)
    if c.type != "position" or len(c.of) != 1 or any(n not in features or features[n].free for n in names):
        return np.zeros((0, 6))
    feature = features[c.of[0]]
    middle, scale = centre(feature), 100.0
    free = free_motions([features[d] for d in c.datums], middle, scale)
    moved = held_displacements(feature, middle, scale) @ free
    return np.asarray(free.T[np.abs(moved).max(axis=0) > MOVES]) if free.shape[1] else np.zeros((0, 6))


def always_kept(c: Characteristic, features: Mapping[str, Feature]) -> bool:
    """Return whether the freedom that the datums of a position leave compensates every departure of its feature: a centre that is free in
    all directions that count."""
    free = left_free(c, features)
    if not len(free) or not c.datums:
        return False
    measured_element = nominal_element(features[c.of[0]])
    drawn, rows, _ = departures(c, measured_element)
    moved = np.concatenate(
        [
            rows_for(drawn, np.broadcast_to(r, drawn.shape), centre(measured_element.feature), 100.0)
            for r in rows
        ]
    )
    return int(np.linalg.matrix_rank(moved @ free.T, tol=MOVES)) == len(moved)


def free_words(motions: Array) -> str:
    """Describe free motions (f, 6) in words: shift along x, turn about z, by their largest shares."""
    strength = np.abs(motions).max(axis=0)
    words = [f"shift along {a}" for a, s in zip("xyz", strength[:3]) if s > 0.1]
    return ", ".join([*words, *(f"turn about {a}" for a, s in zip("xyz", strength[3:]) if s > 0.1)])
