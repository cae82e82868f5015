"""Convert touches with their full position into a recording: the distance of the ball from its nominal place beside the surface.

A touch of a sphere is no touch along its axis of motion: 0.2 mm beside the middle of a ball of 12.5 mm the surface is 1.6 um lower.
So for every feature and rotary position k the middle c_k is found from its touches first (least squares, nearest to where the
nominal machine has it), and only the rest is linear:

    sphere   n = (p - c_k) / |p - c_k|     d = |p - c_k| - (R + r) + n . (c_k - c)
    ring     the same across its axis, from inside: n points to the axis, d = (R - r) - |p - c_k| + n . (c_k - c)
    face     n as stated, d = n . (p - point) - r

p (3,) middle of the ball of the stylus in workpiece axes by the nominal machine, r its radius, R that of the feature, c its place: the mean of the c_k.
n points out of the material. d is indicated - true along n. What c_k errs by counts with its square over 2 (R + r): 10 um bring 3 nm.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.kinematics import nominal_tip
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.task.response.recording import Ints, Recording

PLANE, RING = "plane", "ring"
ROUNDS = 8  # of Gauss-Newton; from 1 mm beside a ball of 25 mm four reach a nanometre
OFF_SURFACE_MM = 5.0  # mm: a touch further from its surface belongs to another feature, or to another zero
ANGLE_DIGITS = 6  # of rotary positions, rad, that are one pose


@dataclass(frozen=True)
class TouchedSurface:
    """kind: sphere, plane or ring; point (3,) mm in workpiece axes, rotary axes at zero; axis (3,): normal of a plane, axis of a ring; radius mm.

    part: faces of one block have the same; their relative places are as stated. "": the feature is a part by itself.
    """

    kind: str
    point: tuple[float, float, float]
    axis: tuple[float, float, float] = (0.0, 0.0, 1.0)
    radius: float = 0.0
    part: str = ""

    @property
    def across(self) -> Array:
        """Projector (3, 3) on the directions in which a round surface is round."""
        axis = np.array(self.axis)
        return np.eye(3) - np.outer(axis, axis) if self.kind == RING else np.eye(3)


def recording_of_touches(
    machine: Machine, run: Run, surfaces: Mapping[str, TouchedSurface], ball: float, lines: Ints
) -> Recording:
    """Return a recording of kind probe from touches with full positions; run: labels feature, positions of all axes, offset of the ball.

    ball: radius of the ball of the stylus, mm. Raises UsageError for a feature that is not stated, and for touches far from their feature.
    """
    tip = nominal_tip(machine.chain, machine.axes, run)
    normal, gap = np.zeros((run.n, 3)), np.zeros(run.n)
    features = run.labels["feature"]
    poses = _poses(run)
    for name in dict.fromkeys(str(f) for f in features):
        if name not in surfaces:
            row = int(np.flatnonzero(features == name)[0])
            raise UsageError(
                f'line {lines[row]}: feature "{name}" has no table [touch.features.{name}].{choose_from(name, list(surfaces))}'
            )
        mine = np.flatnonzero(features == name)
        normal[mine], gap[mine] = _beside(surfaces[name], tip[mine], poses[mine], ball)
    far = np.flatnonzero(np.abs(gap) > OFF_SURFACE_MM)
    if len(far):
        row = int(far[0])
        raise UsageError(
            f"line {lines[row]}: this touch lies {gap[row]:.1f} mm from the surface of feature {features[row]}: check its place, its diameter, tip_diameter, zero and "
            f"offset in [touch], and the centre of the rotary axes of the machine ({len(far)} touches are further than {OFF_SURFACE_MM:g} mm)"
        )
    columns = {f"n{c}": normal[:, i] for i, c in enumerate("xyz")}
    parts = [surfaces[str(f)].part or str(f) for f in features]
    labels = dict(run.labels) | {
        "pose": np.array([str(k + 1) for k in poses], dtype=np.str_),
        "part": np.array(parts, dtype=np.str_),
    }
    return Recording(
        "",
        "probe",
        replace(run.with_columns(columns), labels=labels),
        value=gap,
        measuring=True,
        row=np.arange(run.n),
        direction=normal,
        other=np.full(run.n, -1, dtype=np.intp),
        lines=lines,
        nuisance=usual_nuisance(surfaces, features),
    )


def usual_nuisance(surfaces: Mapping[str, TouchedSurface], features: np.ndarray) -> dict[str, str]:
    """Return the unknowns of touched features: their places, and their size with the mean pre-travel."""
    planes = any(surfaces[str(f)].kind == PLANE for f in features)
    where = {"rigid": "part"} if planes else {"offset": "feature"}
    return {**where, "radius": ""}


def _poses(run: Run) -> Ints:
    """Return the number of the rotary position of each row, in the order in which they came, as (n,)."""
    turned = [np.round(q, ANGLE_DIGITS) for a, q in run.position.items() if a[0] in "ABC"]
    if not turned:
        return np.zeros(run.n, dtype=np.intp)
    _, first, code = np.unique(np.stack(turned, axis=1), axis=0, return_index=True, return_inverse=True)
    order = np.argsort(np.argsort(first))
    return np.asarray(order[code.ravel()], dtype=np.intp)


def _beside(surface: TouchedSurface, tip: Array, pose: Ints, ball: float) -> tuple[Array, Array]:
    """Return outward normals (n, 3) and d (n,) of the touches of one feature."""
    point = np.array(surface.point)
    if surface.kind == PLANE:
        axis = np.array(surface.axis)
        return np.tile(axis, (len(tip), 1)), (tip - point) @ axis - ball
    inside = surface.kind == RING
    reach = surface.radius - ball if inside else surface.radius + ball
    middles = np.stack([_middle(tip[pose == k], point, surface.across, reach) for k in pose])
    about = middles.mean(axis=0)
    way = (tip - middles) @ surface.across
    far = np.linalg.norm(way, axis=1)
    normal = way / far[:, None] * (-1.0 if inside else 1.0)
    gap = reach - far if inside else far - reach
    return normal, gap + (normal * (middles - about)).sum(axis=1)


def _middle(tip: Array, start: Array, across: Array, reach: float) -> Array:
    """Return the middle (3,) of a ball of radius `reach` through touches (n, 3), nearest to `start` where they leave it undetermined."""
    middle = start.copy()
    for _ in range(ROUNDS):
        way = (tip - middle) @ across
        far = np.linalg.norm(way, axis=1)
        if (far < 1e-6).any():
            return start
        normal = way / far[:, None]
        middle = middle + np.linalg.lstsq(normal, far - reach, rcond=1e-6)[0]
    return middle
