"""Words of a drawing beside the type: patterns, projected zones, maximum and least material.

pattern     position of several features in combined zones (CZ, ISO 5458): one pattern in the system of its datums, moved as a whole
            where these leave it free; a second characteristic with fewer datums is the lower line of a composite tolerance.
            SZ: every feature by itself. The worst feature counts
projected   the zone lies beyond the feature: position of its axis where a stud or pin would be (ISO 10578)
material    M or L (ISO 2692): the value is the part of the deviation that the size does not pay for; a bore larger than its maximum
            material size (its lower limit) may lie so much further off. Values below 0 count as 0
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.pose import Array
from vcmm.part.characteristic import OF_SIZE
from vcmm.part.gps import criteria
from vcmm.part.gps.elements import AXES, CENTRES, MeasuredElement, axis_ends
from vcmm.part.gps.freedom import free_motions, largest_left, rows_for
from vcmm.part.part import Characteristic, Feature, ends, frame, kind_text


def project(c: Characteristic, e: MeasuredElement) -> MeasuredElement:
    """Return the element over its projected length, where the drawing requires it. UsageError: not an axis."""
    if c.projected is None:
        return e
    if e.feature.kind not in AXES:
        raise UsageError(f'"{c.name}": a projected zone is of an axis, not of {kind_text(e.feature.kind)}.')
    first, last = ends(e.feature)
    start = last if c.projected > 0 else first + c.projected * e.feature.axis
    return replace(e, feature=replace(e.feature, point=start, extent=(abs(c.projected),)))


def pattern(c: Characteristic, of: Sequence[MeasuredElement], datums: Sequence[Feature]) -> Array:
    """Return the zone (...) mm of the worst feature of a pattern, in the drawing frame. UsageError: features without axis or centre."""
    minimax = criteria.choose_criteria(c).fit == "C"
    elements = [project(c, e) for e in of]
    groups = [elements] if c.zones == "CZ" else [[e] for e in elements]
    return np.asarray(np.max([_together(c, g, datums, minimax) for g in groups], axis=0))


def _together(
    c: Characteristic, elements: Sequence[MeasuredElement], datums: Sequence[Feature], minimax: bool
) -> Array:
    places, rows, off = [], [], []
    for e in elements:
        drawn, measured, across = _places(c, e)
        for k in range(len(drawn)):
            places.append(drawn[k])
            rows.append(across)
            off.append((measured[..., k, :] - drawn[k]) @ across.T)
    at = np.array(places)
    middle = at.mean(axis=0)
    scale = max(float(np.ptp(at, axis=0).max()), 1.0)
    free = free_motions(datums, middle, scale)
    moved = np.stack(
        [np.stack([rows_for(p, r, middle, scale) for r in across]) @ free for p, across in zip(at, rows)]
    )
    return 2.0 * largest_left(np.stack(off, axis=-2), moved, minimax)


def _places(c: Characteristic, e: MeasuredElement) -> tuple[Array, Array, Array]:
    """Return the drawn places (k, 3), the measured ones (..., k, 3), and the directions (3, 3) that count: across an axis two, the third is 0."""
    axes = frame(e.feature)
    across = np.stack([axes[0], axes[1], np.zeros(3)])
    if e.feature.kind in ("cylinder", "cone"):
        return ends(e.feature), axis_ends(e), across
    if e.feature.kind not in CENTRES:
        raise UsageError(
            f'"{c.name}": a pattern is of holes, pins or centres; {kind_text(e.feature.kind)} has no place in it.'
        )
    drawn, measured = e.feature.point[None], e.point[..., None, :]
    return drawn, measured, across if e.feature.kind == "circle" else np.eye(3)


def with_material(c: Characteristic, e: MeasuredElement, value: Array) -> Array:
    """Return the value (...) mm less the bonus of the feature's size (ISO 2692). UsageError: a feature without size."""
    if e.feature.kind not in OF_SIZE or c.size_limits is None:
        raise UsageError(
            f'"{c.name}": a material requirement is of a feature of size, not of {kind_text(e.feature.kind)}.'
        )
    return np.maximum(value - paid_by_size(c, e), 0.0)


def paid_by_size(c: Characteristic, e: MeasuredElement) -> Array:
    """Return how far the size (...) mm lies off its maximum material limit (M) or its least material limit (L)."""
    assert c.size_limits is not None
    low, high = c.size_limits
    bore, most = e.feature.inside, c.material == "M"
    size = 2.0 * e.sizes[..., 0]
    return np.asarray(size - low if bore == most else high - size)
