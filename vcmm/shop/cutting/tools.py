"""Cutting tools as convex solids of revolution about their axis, swept by the cutting edges while the spindle turns.

The reference point is the tip: the lowest point of the tool on its axis. Radius over height h above the tip:

    flat    R from h = 0
    ball    sqrt(R^2 - (R - h)^2) up to h = R, then R
    bull    R - r at h = 0, a quarter circle of radius r up to h = r, then R
    cone    r0 + h tan(half angle), at most R (chamfer tool, countersink; drill and point angle with r0 = 0)
    insert  turning tool: the nose circle of radius r in the plane of the axes X and Z. In that plane it is a ball of
            radius r whose "axis" points out of the work (see vcmm.shop.cutting.turning)

All of them are implicit functions G(radius, h) that are convex, grow by at most 1 per mm, and are negative inside; the
kernels in vcmm/shop/cutting/_tool_kernels.py hold the compiled twin of `implicit`.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.laws import Array

SHAPES = ("flat", "ball", "bull", "cone")
COLUMNS = 7  # of `parameters`: shape, R, r, radius of the bottom, cosine and sine of the half angle, length


@dataclass(frozen=True)
class Cutter:
    """A tool. Lengths in mm, angles in rad. Use the functions below, which check their arguments.

    length: height over the tip up to which the tool (flutes and a shank of the same radius) removes material; infinite
    unless stated.
    """

    shape: str
    radius: float
    corner: float = 0.0
    tip_radius: float = 0.0  # of the flat bottom of a cone
    half_angle: float = 0.0  # of a cone, from its axis
    length: float = math.inf


def flat(radius: float, length: float = math.inf) -> Cutter:
    """End mill with sharp corners."""
    return _check_tool(Cutter("flat", radius, length=length))


def ball(radius: float, length: float = math.inf) -> Cutter:
    """Return a ball-nosed end mill with a shank of the same radius: half a ball below, a cylinder above."""
    return _check_tool(Cutter("ball", radius, corner=radius, length=length))


def bull(radius: float, corner: float, length: float = math.inf) -> Cutter:
    """End mill with corner radius, 0 < corner < radius."""
    if not 0.0 < corner < radius:
        raise UsageError(
            f"bull: the corner radius must lie between 0 and the radius {radius} mm, not {corner} mm. "
            "Use flat() for sharp corners and ball() for a full radius."
        )
    return _check_tool(Cutter("bull", radius, corner=corner, length=length))


def cone(radius: float, point_angle: float, tip_radius: float = 0.0, length: float = math.inf) -> Cutter:
    """Return a chamfer tool or countersink: point_angle is the full angle in rad, tip_radius that of the flat bottom."""
    if not 0.0 < point_angle < math.pi:
        raise UsageError(
            f"cone: the point angle must lie between 0 and pi rad (180 deg), not {point_angle} rad"
        )
    if not 0.0 <= tip_radius < radius:
        raise UsageError(
            f"cone: the tip radius must be at least 0 and below {radius} mm, not {tip_radius} mm"
        )
    return _check_tool(
        Cutter("cone", radius, tip_radius=tip_radius, half_angle=point_angle / 2, length=length)
    )


def drill(radius: float, point_angle: float = math.radians(118.0), length: float = math.inf) -> Cutter:
    """Return a twist drill: a cone with a sharp point, 118 deg unless stated."""
    return cone(radius, point_angle, 0.0, length)


def insert(nose_radius: float) -> Cutter:
    """Return a turning insert: its nose circle (see vcmm.shop.cutting.turning); the flanks are not modelled."""
    return ball(nose_radius)


def _check_tool(tool: Cutter) -> Cutter:
    if tool.shape not in SHAPES:
        raise UsageError(f'tool shape "{tool.shape}" is not known.{choose_from(tool.shape, SHAPES)}')
    if not (math.isfinite(tool.radius) and tool.radius > 0.0):
        raise UsageError(f"{tool.shape}: the radius must be a positive number of mm, not {tool.radius}")
    if not tool.length > nose_height(tool):
        raise UsageError(
            f"{tool.shape}: the length {tool.length} mm must exceed the height of the nose, {nose_height(tool):.6g} mm"
        )
    return tool


def nose_height(tool: Cutter) -> float:
    """Return the height over the tip at which the full radius is reached, mm."""
    if tool.shape == "cone":
        return (tool.radius - tool.tip_radius) / math.tan(tool.half_angle)
    return tool.corner


def parameters(tools: tuple[Cutter, ...]) -> Array:
    """Return the rows (n, COLUMNS) as the kernels take them."""
    rows = [
        (
            SHAPES.index(t.shape),
            t.radius,
            t.corner,
            t.tip_radius if t.shape == "cone" else t.radius - t.corner,
            math.cos(t.half_angle),
            math.sin(t.half_angle),
            t.length,
        )
        for t in tools
    ]
    return np.array(rows, float).reshape(-1, COLUMNS)


def implicit(tool: Cutter, radius: Array, height: Array) -> Array:
    """Return G (...) at distances `radius` from the axis and heights over the tip: negative inside, at most the distance outside."""
    rho, h = np.broadcast_arrays(np.asarray(radius, float), np.asarray(height, float))
    top = h - tool.length
    if tool.shape == "cone":
        flank = (rho - tool.tip_radius) * math.cos(tool.half_angle) - h * math.sin(tool.half_angle)
        return np.maximum(np.maximum(np.maximum(rho - tool.radius, -h), flank), top)
    box = np.maximum(rho - tool.radius, -h)
    if tool.corner == 0.0:
        return np.maximum(box, top)
    over, under = rho - (tool.radius - tool.corner), tool.corner - h
    round_ = np.hypot(over, under) - tool.corner
    return np.maximum(np.where((over > 0.0) & (under > 0.0), round_, box), top)
