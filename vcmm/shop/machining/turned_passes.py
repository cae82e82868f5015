"""A turned surface evaluated with many more passes of the nose, to check its candidates, and for a ball that rolls on it.

Rolling: in the section of the point the ball is a circle that rests on the crests between the passes (ISO 16610-41, as
vcmm.shop.cutting.stylus); that the groove winds round the part by f / 2 pi per rad is nothing over the width of a contact.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.core.run import Array
from vcmm.shop.cutting import nose
from vcmm.shop.cutting.contactmap import Ints
from vcmm.shop.machining.turned_surface import TurnedSurface, Turning, passes_at

TURNS = 12  # before and after each contact
BALL_PASSES = 20
RELIEF = 0.05  # mm: crests are no higher than this over the valleys
GRID, ZOOMS = 121, 4
AT_ONCE = 50  # points


def with_all_passes(turning: Turning, surface: TurnedSurface) -> TurnedSurface:
    """Return the surface with every pass of TURNS turns before and after its contacts as a candidate."""
    times = _around(turning, surface, TURNS)
    every = passes_at(turning, times, surface.flat, surface.flat_normals)
    passes = every.take(every.order())
    good = np.isfinite(passes.height)
    toward = np.broadcast_to(surface.normal[:, :1], (*good.shape, 3)).copy()
    return replace(
        surface, contact_s=np.where(good, passes.height, np.nan), row=np.where(good, passes.row, -1),
        t=np.where(good, passes.t, np.nan), normal=toward, time=np.where(good, passes.time, np.nan),
    )  # fmt: skip


def _around(turning: Turning, surface: TurnedSurface, turns: int) -> Array:
    """Return the times (n, Q) of the passes around every contact of each point, and the contacts themselves."""
    k = surface.time.shape[1]
    there = np.where(np.isfinite(surface.time), surface.time, surface.time[:, :1])
    passes = [turning.spindle.passes(there[:, i], surface.phi, turns) for i in range(k)]
    times = np.sort(np.concatenate([*passes, surface.time], axis=1), axis=1)
    times[:, 1:][np.diff(times, axis=1) < 1e-9] = np.nan
    return times


def crest_lift(turning: Turning, surface: TurnedSurface, mine: Ints, radius: float) -> Array:
    """Return how much higher (m,) mm than the surface in the points `mine` a ball of `radius` rests on the crests beside them."""
    parts = [surface.take(mine[i : i + AT_ONCE]) for i in range(0, len(mine), AT_ONCE)]
    return np.concatenate([_crest_lift(turning, part, radius) for part in parts])


def _crest_lift(turning: Turning, surface: TurnedSurface, radius: float) -> Array:
    nearest = replace(surface, time=surface.time[:, :1])
    times = _around(turning, nearest, BALL_PASSES)
    passes = passes_at(turning, times, surface.flat, surface.flat_normals)
    row, t = passes.row, passes.t
    p, n = surface.flat[:, [0, 2]], surface.flat_normals[:, [0, 2]]
    across = np.stack([-n[:, 1], n[:, 0]], axis=1)
    is_cut = row >= 0
    centre, r = np.full((*row.shape, 2), 1e9), np.ones(row.shape)
    centre[is_cut] = nose.noses(turning.sweep, row[is_cut], t[is_cut])
    r[is_cut] = nose.nose_radius(turning.sweep)[row[is_cut]]

    def lift(a: Array) -> Array:
        """Return the height (m, A) at which the ball would rest if it touched over offsets a (m, A)."""
        at = p[:, None] + a[..., None] * across[:, None]
        s = nose.entry(at[:, :, None] - centre[:, None], n[:, None, None], r[:, None]).min(axis=-1)
        return np.where(np.isfinite(s), s, -np.inf) - (radius - np.sqrt(np.maximum(radius**2 - a * a, 0.0)))

    reach = float(np.sqrt(min(2.0 * radius * RELIEF, 0.999 * radius**2)))
    middle, best = np.zeros(len(p)), surface.contact_s[:, 0].copy()
    for _ in range(ZOOMS):
        a = np.clip(middle[:, None] + np.linspace(-reach, reach, GRID), -radius, radius)
        high = lift(a)
        at = high.argmax(axis=1)
        top = high[np.arange(len(p)), at]
        middle, best = np.where(top > best, a[np.arange(len(p)), at], middle), np.maximum(best, top)
        reach *= 4.0 / GRID
    return np.maximum(best - surface.contact_s[:, 0], 0.0)
