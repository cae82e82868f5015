"""Faces of a turned part: rings about the axis of the spindle, where the plan and the pictures of a milled face have a grid.

A face is drawn as a plane whose point lies on the axis; its size is the outer diameter. Its inner edge follows from the program:
the face reaches as far inwards as the program leaves it within a tenth of a millimetre.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.core.pose import Pose
from vcmm.core.run import Array
from vcmm.part.part import Feature, frame, normal, surface_point
from vcmm.shop.machining.gauge import gauge_plan
from vcmm.shop.machining.maps import MARGIN, Net
from vcmm.shop.machining.maps import net as usual_net
from vcmm.shop.machining.turned_surface import Turning, turned_surface
from vcmm.task.measuring.cut_scenario import IDEAL, CutScenario

LOOKS, NEAR_NOMINAL_MM, NEAR_FACE_MM = (
    400,
    0.1,
    0.01,
)  # radii that are looked at; mm from nominal, and from the face itself
RINGS, AROUND, OFF = 4, 24, 0.05  # of the usual points of a face; rad, no point on an axis
INSIDE = 0.1  # share of the width of the face that is kept from its edges


def is_face(feature: Feature, pose: Pose, turning: Turning) -> bool:
    """Return whether a feature is a plane square to the spindle with its point on the axis."""
    if feature.kind != "plane":
        return False
    at, axis = pose.apply(feature.point), pose.turn(feature.axis)
    off = np.hypot(*(at[:2] - turning.centre))
    return bool(abs(abs(axis[2]) - 1.0) < 1e-9 and off < 1e-6)


def about_spindle(feature: Feature, pose: Pose, turning: Turning) -> bool:
    """Return whether a feature is a face, or a feature of revolution whose axis is that of the spindle."""
    if feature.kind == "plane":
        return is_face(feature, pose, turning)
    at = pose.apply(feature.point)
    on = bool(np.hypot(*(at[:2] - turning.centre)) < 1e-6)
    if feature.kind == "sphere":
        return on
    return on and feature.axis is not None and bool(abs(abs(pose.turn(feature.axis)[2]) - 1.0) < 1e-9)


def radii(feature: Feature, pose: Pose, turning: Turning) -> tuple[float, float]:
    """Return the inner and outer radius of a face, mm."""
    outer = min(feature.extent) / 2.0
    r = np.linspace(0.0, 1.0, LOOKS)[1:] * outer * (1 - MARGIN)
    points = _on(feature, np.zeros(len(r)), r)
    normals = normal(feature, points)
    surface = turned_surface(turning, pose.apply(points), pose.turn(normals), 0.5, 0.5, 2.0)
    s = np.where(np.isfinite(surface.s), surface.s, np.inf)
    there = np.abs(s) < NEAR_NOMINAL_MM
    if there.any():
        there &= np.abs(s - np.median(s[there])) < NEAR_FACE_MM
    missing = np.flatnonzero(~there)
    if not there.any() or not there[-1]:
        return 0.0, outer
    if not len(missing):
        return 0.0, outer
    fillet = np.sqrt(
        2.0 * max(tool.radius for tool in turning.sweep.tools) * NEAR_FACE_MM
    )  # the remainder from there
    edge = float(r[missing[-1]])
    return min(edge + float(fillet), 0.5 * (edge + outer)), outer


def _on(feature: Feature, angle: Array, radius: Array) -> Array:
    """Return the points of the plane at angles and radii about its point."""
    u, v, _ = frame(feature)
    return np.asarray(
        feature.point + (radius * np.cos(angle))[:, None] * u + (radius * np.sin(angle))[:, None] * v
    )


def with_faces(scenario: CutScenario, pose: Pose, turning: Turning) -> CutScenario:
    """Return the scenario with the usual points of its features, rings on its faces; as it is where it has a plan."""
    if scenario.plan is not None or scenario.inspection.kind != IDEAL:
        return scenario
    plan = gauge_plan(scenario.part, None)
    steps = []
    for step in plan.steps:
        feature = scenario.part.features[step.feature]
        if is_face(feature, pose, turning):
            points = _ring_points(*radii(feature, pose, turning), feature)
            step = replace(step, points=points, normals=normal(feature, points))
        steps.append(step)
    return replace(scenario, plan=replace(plan, steps=tuple(steps)))


def _ring_points(inner: float, outer: float, feature: Feature) -> Array:
    width = outer - inner
    rings = inner + width * np.linspace(INSIDE, 1.0 - INSIDE, RINGS)
    angle = OFF + 2 * np.pi * np.arange(AROUND) / AROUND
    return _on(feature, np.tile(angle, RINGS), np.repeat(rings, AROUND))


def turned_net(feature: Feature, across: int, pose: Pose, turning: Turning) -> Net | None:
    """Return a net as `maps.net` does, but in rings on a face, and without the fillets that the nose leaves at the ends."""
    if feature.kind in ("cylinder", "cone"):
        return _round_net(feature, across, turning)
    if not is_face(feature, pose, turning):
        return usual_net(feature, across)
    inner, outer = radii(feature, pose, turning)
    width = outer - inner
    angle = np.linspace(0.0, 2 * np.pi, 2 * across - 1)
    radius = inner + width * np.linspace(2 * MARGIN, 1.0 - 2 * MARGIN, max(9, across // 2))
    points = _on(feature, np.tile(angle, len(radius)), np.repeat(radius, len(angle)))
    return Net(feature.name, points, normal(feature, points), angle, radius, ("angle / deg", "radius / mm"))


def _round_net(feature: Feature, across: int, turning: Turning) -> Net:
    long = feature.extent[0]
    nose = max(tool.radius for tool in turning.sweep.tools)
    kept = min(max(MARGIN * long, 1.25 * nose), 0.25 * long)
    angle = np.linspace(0.0, 2 * np.pi, 2 * across - 1)
    along = np.linspace(kept, long - kept, max(9, across // 2))
    points = surface_point(feature, angle[None, :], along[:, None]).reshape(-1, 3)
    labels = ("angle / deg", "along the axis / mm")
    return Net(feature.name, points, normal(feature, points), angle, along, labels)


__all__ = ["is_face", "radii", "turned_net", "with_faces"]
