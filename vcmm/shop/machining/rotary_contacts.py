"""Contacts while rotary axes turn, put exactly where the tool stands, and solids of tools that do not point along Z.

The search knows a turning tool as short rows of constant direction (vcmm.shop.machining.rotary_sweep). For each contact found
there, the tool is put at shares of its move about it, exactly, and met by the ray in closed form: the lowest entry over
the share is the surface. The window shrinks about the best share so far. What is lowest over a window of PIECES rows to
either side is taken; a program that touches a point more often has further contacts there.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.run import Array
from vcmm.shop.cutting.contactmap import Ints, Solids
from vcmm.shop.cutting.envelope import CutSurface
from vcmm.shop.cutting.standing_tool import entry
from vcmm.shop.machining.rotary import RotaryMotion, turn_to_workpiece

PIECES = 3.0  # rows to either side
LOOKS, ROUNDS = (
    9,
    10,
)  # 4^10: the share is found to 1e-6 of the window, the height, which is flat there, to rounding
ASTRAY = 0.02  # mm: an exact entry further off belongs to another side of the tool


@dataclass(frozen=True, eq=False)
class TiltedSolids(Solids):
    """Solids whose tools point elsewhere: frame (P, K, 3, 3), axes of each tool as rows, in workpiece axes."""

    frame: Array | None = None

    def entry(self, shift: Array, normal: Array) -> Array:
        """Where the rays from the points along normal (P, 3) enter the tools moved by shift (..., P, K, 3), (..., P, K)."""
        out = np.full(shift.shape[:-1], np.inf)
        frame = np.broadcast_to(self.frame, (*out.shape, 3, 3))  # type: ignore[arg-type]
        rays = np.broadcast_to(normal[:, None, :], shift.shape)
        for number, tool in enumerate(self.tools):
            mine = np.broadcast_to(self.which == number, out.shape)
            if mine.any():
                f = frame[mine]
                out[mine] = entry(
                    tool, turn_to_workpiece(f, (self.arm - shift)[mine]), turn_to_workpiece(f, rays[mine])
                )
        return out


def polish_contacts(surface: CutSurface, motion: RotaryMotion, keep: int) -> CutSurface:
    """The surface with the contacts of turning tools exact, each once, the `keep` lowest of every point."""
    surface = _each_once(surface, motion)
    known = surface.row >= 0
    point, k = np.nonzero(known & motion.inexact[np.maximum(surface.row, 0)])
    if not len(point):
        return _lowest(surface, keep)
    row = surface.row[point, k].astype(np.intp)
    height, t = _least(motion, row, surface.t[point, k], surface.points[point], surface.normals[point])
    near = np.abs(height - surface.contact_s[point, k]) < ASTRAY
    s, at = surface.contact_s.copy(), surface.t.copy()
    s[point[near], k[near]], at[point[near], k[near]] = height[near], t[near]
    return _lowest(_ordered(replace(surface, contact_s=np.where(known, s, np.inf), t=at)), keep)


def _least(motion: RotaryMotion, row: Ints, t: Array, points: Array, normals: Array) -> tuple[Array, Array]:
    """(least height, fraction of the row) (k,) about fractions t of rows; the fraction may lie beside the row, on its move."""
    width = (motion.last - motion.first)[row]
    best = motion.share(row, t)
    low, high = np.clip(best - PIECES * width, 0.0, 1.0), np.clip(best + PIECES * width, 0.0, 1.0)
    least = np.full(len(row), np.inf)
    every = np.arange(len(row))
    for _ in range(ROUNDS):
        share = low + np.linspace(0.0, 1.0, LOOKS)[:, None] * (high - low)
        heights = np.array([_met(motion, row, one, points, normals) for one in share])
        i = heights.argmin(axis=0)
        lower = heights[i, every] < least
        best = np.where(lower, share[i, every], best)
        least = np.where(lower, heights[i, every], least)
        step = (high - low) / (LOOKS - 1)
        low, high = np.maximum(best - step, low), np.minimum(best + step, high)
    return least, (best - motion.first[row]) / width


def _met(motion: RotaryMotion, row: Ints, share: Array, points: Array, normals: Array) -> Array:
    """Where rays (k,) enter the tool of rows as it stands at shares (k,) of their moves; inf where they miss."""
    t = (share - motion.first[row]) / (motion.last - motion.first)[row]
    tip, frame = motion.standing(row, t)
    arm, ray = turn_to_workpiece(frame, points - tip), turn_to_workpiece(frame, normals)
    out = np.full(len(row), np.inf)
    which = motion.base.tool[motion.row[row]]
    for number, tool in enumerate(motion.base.tools):
        mine = which == number
        out[mine] = entry(tool, arm[mine], ray[mine])
    return out


def _ordered(surface: CutSurface) -> CutSurface:
    """Contacts by height."""
    order = np.argsort(surface.contact_s, axis=1, kind="stable")
    at = np.arange(len(order))[:, None]
    return replace(
        surface, contact_s=surface.contact_s[at, order], row=surface.row[at, order], t=surface.t[at, order], normal=surface.normal[at, order]
    )  # fmt: skip


def _each_once(surface: CutSurface, motion: RotaryMotion) -> CutSurface:
    """Without contacts of rows that lie in the window about a lower contact of the same turning move: they are one."""
    row = np.maximum(surface.row, 0)
    move = np.where(surface.row >= 0, motion.row[row], -1)
    share = np.where(
        surface.row >= 0, motion.first[row] + surface.t * (motion.last - motion.first)[row], np.nan
    )
    window = np.where(motion.inexact[row], (PIECES - 0.5) * (motion.last - motion.first)[row], 0.0)
    again = np.zeros(row.shape, dtype=bool)
    for k in range(1, row.shape[1]):
        same = (move[:, :k] == move[:, k : k + 1]) & ~again[:, :k]
        again[:, k] = (same & (np.abs(share[:, :k] - share[:, k : k + 1]) < window[:, :k])).any(axis=1)
    gone = again & (surface.row >= 0)
    return _ordered(
        replace(
            surface, contact_s=np.where(gone, np.inf, surface.contact_s), row=np.where(gone, -1, surface.row)
        )
    )


def _lowest(surface: CutSurface, keep: int) -> CutSurface:
    """The `keep` lowest contacts; those that are none have nan, as from the search."""
    known = surface.row[:, :keep] >= 0
    return replace(
        surface, contact_s=np.where(known, surface.contact_s[:, :keep], np.nan), row=surface.row[:, :keep],
        t=np.where(known, surface.t[:, :keep], np.nan), normal=np.where(known[:, :, None], surface.normal[:, :keep], np.nan),
    )  # fmt: skip
