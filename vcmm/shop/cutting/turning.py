"""Turning in the meridian: the nose circle of an insert cuts a profile of revolution.

Points of the part are turned about its axis into the half plane x = radius >= 0, y = 0, z. There the insert is the circle
of its nose, which in that plane is a ball mill whose "axis" points out of the work along +x: nose below, shank behind it.
Its reference point ("tip") is the point of the nose circle nearest to the axis of the part (imaginary X edge, at the Z of
the nose centre). The flanks of the insert are not modelled: a profile steeper than they allow would be cut all the same.
Feed marks are those of the path, so give one pass per turn (z advances by the feed) to see them, Rt = f^2 / 8r.
"""

from __future__ import annotations

import numpy as np

from vcmm.core.errors import UsageError
from vcmm.core.laws import Array
from vcmm.shop.cutting.sweeps import ARC, Sweep, arcs, lines
from vcmm.shop.cutting.tools import Cutter, insert

OUTWARD = np.array([1.0, 0.0, 0.0])


def meridian(points: Array, normals: Array) -> tuple[Array, Array]:
    """Return the points and normals (n, 3) of a part about the Z axis, turned into the half plane y = 0, x >= 0.

    Normals must lie in the meridian plane of their points, as those of a surface of revolution do.
    """
    p, n = np.atleast_2d(np.asarray(points, float)), np.atleast_2d(np.asarray(normals, float))
    radius = np.hypot(p[:, 0], p[:, 1])
    safe = np.where(radius > 0.0, radius, 1.0)
    radial = np.where((radius > 0.0)[:, None], p[:, :2] / safe[:, None], [1.0, 0.0])
    out = np.einsum("ni,ni->n", n[:, :2], radial)
    around = radial[:, 0] * n[:, 1] - radial[:, 1] * n[:, 0]
    if np.any(np.abs(around) > 1e-6):
        bad = int(np.argmax(np.abs(around)))
        raise UsageError(
            f"meridian: the normal of point {bad} has a part of {around[bad]:.3g} around the axis; turning makes surfaces of "
            "revolution about Z only"
        )
    flat = np.stack([out, np.zeros(len(p)), n[:, 2]], axis=1)
    flat /= np.linalg.norm(flat, axis=1)[:, None]
    return np.stack([radius, np.zeros(len(p)), p[:, 2]], axis=1), flat


def tip_of_centre(centre: Array, nose: float) -> Array:
    """Return the reference point (..., 3) of an insert whose nose circle has its centre at `centre` (..., 3)."""
    return np.asarray(centre, float) - nose * OUTWARD


def straight(start: Array, end: Array, tools: tuple[Cutter, ...], tool: int = 0) -> Sweep:
    """Return the straight passes between reference points (m, 2) = (radius, z) in mm, not diameters."""
    return lines(_plane(start), _plane(end), tools, tool, OUTWARD)


def arc_sweep(
    start: Array, end: Array, centre: Array, turn: Array, tools: tuple[Cutter, ...], tool: int = 0
) -> Sweep:
    """Return the arcs in the (radius, z) plane about `centre` (m, 2), turn (m,) rad from +z towards +radius (right-handed about +y)."""
    sweep = arcs(
        _plane(start),
        _plane(end),
        _plane(centre),
        turn,
        tools=tools,
        tool=tool,
        normal=np.array([0.0, 1.0, 0.0]),
        axis=OUTWARD,
    )
    assert np.all(sweep.kind == ARC)
    return sweep


def _plane(points: Array) -> Array:
    rz = np.atleast_2d(np.asarray(points, float))
    if rz.shape[1] != 2:
        raise UsageError(f"turning: positions must be (radius, z) pairs of shape (m, 2), not {rz.shape}")
    return np.stack([rz[:, 0], np.zeros(len(rz)), rz[:, 1]], axis=1)


__all__ = ["arc_sweep", "insert", "meridian", "straight", "tip_of_centre"]
