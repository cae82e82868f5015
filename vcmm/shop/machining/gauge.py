"""The ideal gauge: inspection without errors, so that a result is the deviation of the part itself."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.kinematics import Axis, parse_structure
from vcmm.core.machine import Machine
from vcmm.part.part import Feature, Part
from vcmm.task.measuring.plan import Plan, Step, Stylus
from vcmm.task.measuring.strategies import Around, Even, Grid, Latitudes, Levels, Ring, plan_points

GAUGE_TIP = 0.0  # mm: a point on the surface
FAR_MM = 1e7  # mm
OFF_AXIS = 0.05  # rad: points just where an axis turns round belong to neither sense


def ideal_gauge() -> Machine:
    """Return a measuring machine without errors and without limits."""
    axes = {letter: Axis(letter, (-FAR_MM, FAR_MM)) for letter in "XYZ"}
    return Machine("ideal gauge", "cmm", parse_structure("w b X Y Z t"), axes)


def gauge_plan(part: Part, plan: Plan | None) -> Plan:
    """Return the points of a plan with a tip of no size; where there is no plan, every feature that a characteristic names."""
    stylus = {"gauge": Stylus("gauge", np.zeros(3), GAUGE_TIP)}
    if plan is not None:
        steps = tuple(Step(s.feature, "gauge", s.points, s.normals, s.approach) for s in plan.steps)
        return Plan(steps, stylus, plan.touch, plan.alignment)
    return Plan(
        tuple(
            Step(f.name, "gauge", *plan_points(f, usual_points(f)))
            for f in _gauge_features(part.features, part)
        ),
        stylus,
    )


def _gauge_features(features: Mapping[str, Feature], part: Part) -> list[Feature]:
    names = dict.fromkeys(n for c in part.characteristics for n in c.features)
    chosen = [features[n] for n in names] or list(features.values())
    for feature in chosen:
        if feature.free or feature.kind == "point":
            raise UsageError(
                f'inspection of {feature.name}: a {feature.kind} has no usual points; add [plan] with points = "file.csv"'
            )
    return chosen


def usual_points(feature: Feature) -> Grid | Levels | Around | Even | Latitudes | Ring:
    """Return points dense enough for size, form and orientation of a cut surface; a tenth of the size is kept from the edges."""
    inner = 0.1 * min(feature.extent, default=0.0)
    if feature.kind == "plane":
        return Grid((7, 7), inner)
    if feature.kind == "line":
        return Even(15, inner)
    if feature.kind == "circle":
        return Around(36, OFF_AXIS)
    if feature.kind in ("cylinder", "cone"):
        length = feature.extent[0]
        return Levels((0.15 * length, 0.5 * length, 0.85 * length), 24, OFF_AXIS)
    if feature.kind == "sphere":
        return Latitudes((0.0, np.pi / 8, np.pi / 4, 3 * np.pi / 8), 12)
    return Ring((12, 6))
