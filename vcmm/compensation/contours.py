"""Geometry of programmed moves: points and directions along lines and arcs, in machine coordinates of the tool tip."""

from __future__ import annotations

import math
from collections.abc import Sequence

import numpy as np
import numpy.typing as npt

from vcmm.core.run import Array
from vcmm.program.moves import PLANES, Move

Ints = npt.NDArray[np.intp]

FULL_CIRCLE = 1e-6  # rad, as the interpreter


def sweep_of(m: Move) -> float:
    """Return the signed angle of an arc, rad, positive counter-clockwise in its plane; 0 for anything else."""
    if m.kind != "arc" or m.centre is None:
        return 0.0
    a, b, _ = PLANES[m.plane]
    begin = math.atan2(m.start[b] - m.centre[b], m.start[a] - m.centre[a])
    end = math.atan2(m.end[b] - m.centre[b], m.end[a] - m.centre[a])
    angle = (begin - end if m.clockwise else end - begin) % (2.0 * math.pi)
    if angle < FULL_CIRCLE:
        angle += 2.0 * math.pi
    angle += 2.0 * math.pi * (m.turns - 1)
    return -angle if m.clockwise else angle


def length_of(m: Move) -> float:
    """Return the length of the path, mm."""
    if m.kind != "arc" or m.centre is None:
        return math.dist(m.start, m.end)
    a, b, n = PLANES[m.plane]
    radius = math.hypot(m.start[a] - m.centre[a], m.start[b] - m.centre[b])
    return math.hypot(radius * sweep_of(m), m.end[n] - m.start[n])


def points(m: Move, share: Array) -> Array:
    """Return the points (k, 3) at shares (k,) of a move; the radius of an arc goes evenly from that at its start to that at its end."""
    start, end = np.array(m.start), np.array(m.end)
    straight = start + share[:, None] * (end - start)
    if m.kind != "arc" or m.centre is None:
        return straight
    a, b, _ = PLANES[m.plane]
    ca, cb = m.centre[a], m.centre[b]
    r0, r1 = (math.hypot(p[a] - ca, p[b] - cb) for p in (m.start, m.end))
    angle = math.atan2(m.start[b] - cb, m.start[a] - ca) + share * sweep_of(m)
    radius = r0 + share * (r1 - r0)
    straight[:, a], straight[:, b] = ca + radius * np.cos(angle), cb + radius * np.sin(angle)
    return np.asarray(straight)


def directions(m: Move, share: Array) -> Array:
    """Return the unit directions of travel (k, 3); zero for a move of no length."""
    if m.kind != "arc" or m.centre is None:
        way = np.array(m.end) - np.array(m.start)
        length = float(np.linalg.norm(way))
        return np.tile(way / length if length > 0 else way, (len(share), 1))
    a, b, n = PLANES[m.plane]
    sweep = sweep_of(m)
    angle = math.atan2(m.start[b] - m.centre[b], m.start[a] - m.centre[a]) + share * sweep
    radius = math.hypot(m.start[a] - m.centre[a], m.start[b] - m.centre[b])
    out = np.zeros((len(share), 3))
    out[:, a], out[:, b] = -np.sin(angle) * sweep * radius, np.cos(angle) * sweep * radius
    out[:, n] = m.end[n] - m.start[n]
    return np.asarray(out / np.linalg.norm(out, axis=1)[:, None])


def left_normal(direction: Array, plane: str) -> Array:
    """Return the unit normals (k, 3) in the plane, to the left of the direction of travel; zero where that is along the normal."""
    a, b, _ = PLANES[plane]
    out = np.zeros_like(direction)
    out[:, a], out[:, b] = -direction[:, b], direction[:, a]
    size = np.linalg.norm(out, axis=1)
    return np.asarray(out / np.where(size > 1e-12, size, 1.0)[:, None])


def nominal_distance(at: Array, moves: Sequence[Move], which: Ints) -> Array:
    """Return the vector (k, 3) from the nearest point of moves[which] (k,) to each of the points (k, 3)."""
    ends = np.array([(*moves[i].start, *moves[i].end) for i in which.tolist()]).reshape(-1, 6)
    way, since = ends[:, 3:] - ends[:, :3], at - ends[:, :3]
    square = np.einsum("ki,ki->k", way, way)
    share = np.clip(np.einsum("ki,ki->k", since, way) / np.where(square > 0, square, 1.0), 0.0, 1.0)
    out = since - share[:, None] * way
    order = np.argsort(which, kind="stable")
    edges = np.flatnonzero(np.diff(which[order])) + 1
    for rows in np.split(order, edges):
        if len(rows) and moves[int(which[rows[0]])].kind == "arc":
            m = moves[int(which[rows[0]])]
            out[rows] = at[rows] - points(m, nearest_share(m, at[rows]))
    return np.asarray(out)


def nearest_share(m: Move, at: Array) -> Array:
    """Return the share (k,) of the point of a move that is nearest to each point (k, 3), within its ends."""
    if m.kind != "arc" or m.centre is None:
        way = np.array(m.end) - np.array(m.start)
        square = float(way @ way)
        if square == 0.0:
            return np.zeros(len(at))
        return np.asarray(np.clip((at - np.array(m.start)) @ way / square, 0.0, 1.0))
    a, b, _ = PLANES[m.plane]
    sweep = sweep_of(m)
    begin = math.atan2(m.start[b] - m.centre[b], m.start[a] - m.centre[a])
    angle = np.arctan2(at[:, b] - m.centre[b], at[:, a] - m.centre[a]) - begin
    turn = 2.0 * math.pi * math.copysign(1.0, sweep)
    share = np.mod(angle / turn, 1.0) * turn / sweep  # first passage
    several = [share + k * turn / sweep for k in range(-1, m.turns + 1)]
    best, least = np.clip(share, 0.0, 1.0), np.full(len(at), np.inf)
    for contour in several:
        kept = np.clip(contour, 0.0, 1.0)
        gap = np.linalg.norm(at - points(m, kept), axis=1)
        best, least = np.where(gap < least, kept, best), np.minimum(gap, least)
    return np.asarray(best)
