"""Datum systems (ISO 5459): secondary and tertiary datums are associated with their orientation constrained by those before them."""

from __future__ import annotations

from collections.abc import Iterable, Mapping

from vcmm.core.pose import Array, Pose
from vcmm.part.alignment import datum_system
from vcmm.part.fit import FittedElement, hold_axis
from vcmm.part.gps.criteria import POINTS, ChosenCriteria, by_criterion
from vcmm.part.part import Characteristic, Feature

LOCATION_TYPES = ("position", "line_profile", "surface_profile")
TURNING = ("circular_runout", "total_runout")


def has_system(c: Characteristic) -> bool:
    """Return whether the datums of a characteristic are a system, in whose frame it is evaluated: not one datum axis of a run-out."""
    return (c.type in LOCATION_TYPES and bool(c.datums)) or (c.type in TURNING and len(c.datums) > 1)


def system_pose(
    c: Characteristic,
    features: Mapping[str, Feature],
    fitted: Mapping[str, FittedElement],
    choice: ChosenCriteria,
    pose: Pose | None,
) -> Pose | None:
    """Return part_from_measured of the datums of a characteristic; `pose` itself where its type has no datum system."""
    if not has_system(c):
        return pose
    letters = dict(zip(c.datums, choice.datums))
    by = {n: by_criterion(n, fitted[n], k) for n, k in letters.items() if n in fitted}

    def again(name: str, axis: Array, about: Array | None) -> FittedElement:
        base, points = by[name], fitted[name].also.get(POINTS)
        return hold_axis(
            base, axis, about, None if points is None else points.points, letters[name], features[name].inside
        )

    return datum_system(c.datums, features, by, Pose.identity() if pose is None else pose, again)


def constrained_features(
    characteristics: Iterable[Characteristic], features: Mapping[str, Feature]
) -> frozenset[str]:
    """Return the features that are associated with a given orientation: secondary and tertiary datums that have a direction of their own."""
    return frozenset(
        name
        for c in characteristics
        if has_system(c)
        for name in c.datums[1:]
        if name in features and features[name].kind in ("plane", "line", "cylinder", "cone", "torus")
    )
