"""A turned surface asked again with many more passes: as a check of the candidates, and for a ball that rolls on it.

Recut: every pass of some turns before and after the contacts, each displaced by the errors of the machine at that very time
and angle of the spindle; the deepest remains. Rolling: in the section of the point the ball is a circle that rests on the
crests between the passes (ISO 16610-41, as vcmm.cutting.stylus); that the groove winds round the part by f / 2 pi per rad is
nothing over the width of a contact.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from vcmm.core.run import Array
from vcmm.cutting import nose
from vcmm.machining.preparation import Shop
from vcmm.machining.recut import POINTS, Recut
from vcmm.machining.turned import TurnedSurface, Turning, passes_at
from vcmm.machining.turned_side import turned_side

TURNS = 12  # before and after each contact
ROLLED = 20
RELIEF = 0.05  # mm: crests are no higher than this over the valleys
GRID, ZOOMS = 121, 4
Ints = np.typing.NDArray[np.intp]
_FIELDS = (
    "points", "normals", "status", "contact_s", "row", "t", "normal", "tests", "flat", "flat_normals", "phi", "time",
)  # fmt: skip


def recut_turned(shop: Shop, surface: TurnedSurface) -> Recut:
    """Largest difference between the candidates and all passes around them, over at most POINTS points."""
    some = np.unique(np.linspace(0, len(surface.points) - 1, POINTS).astype(int))
    part = _taken(surface, some)
    few, many = _heights(shop, part), _heights(shop, _with_all_passes(shop, part))
    return Recut(float(np.abs(many - few).max(initial=0.0)), len(some))


def _taken(surface: TurnedSurface, rows: Ints) -> TurnedSurface:
    return replace(surface, **{n: getattr(surface, n)[rows] for n in _FIELDS})


def _heights(shop: Shop, surface: TurnedSurface) -> Array:
    names = np.array([str(i) for i in range(len(surface.points))])
    tool, contacts = turned_side(shop, surface, names, names)
    return contacts.surface(tool.errors())


def _with_all_passes(shop: Shop, surface: TurnedSurface) -> TurnedSurface:
    turning = shop.turning
    assert turning is not None
    times = _around(turning, surface, TURNS)
    every = passes_at(turning, times, surface.flat, surface.flat_normals)
    found = every.taken(every.order())
    time, row, t, s = found.time, found.row, found.t, found.height
    good = np.isfinite(s)
    toward = np.broadcast_to(surface.normal[:, :1], (*s.shape, 3)).copy()
    return replace(
        surface, contact_s=np.where(good, s, np.nan), row=np.where(good, row, -1), t=np.where(good, t, np.nan),
        normal=toward, time=np.where(good, time, np.nan),
    )  # fmt: skip


def _around(turning: Turning, surface: TurnedSurface, turns: int) -> Array:
    """Times (n, Q) of the passes around every contact of each point, and the contacts themselves."""
    k = surface.time.shape[1]
    there = np.where(np.isfinite(surface.time), surface.time, surface.time[:, :1])
    found = [turning.spindle.passes(there[:, i], surface.phi, turns) for i in range(k)]
    times = np.sort(np.concatenate([*found, surface.time], axis=1), axis=1)
    times[:, 1:][np.diff(times, axis=1) < 1e-9] = np.nan
    return times


def lifted(turning: Turning, surface: TurnedSurface, mine: Ints, radius: float) -> Array:
    """How much higher (m,) mm than the surface in the points `mine` a ball of `radius` rests on the crests beside them."""
    return np.concatenate(
        [_lifted(turning, _taken(surface, mine[i : i + 50]), radius) for i in range(0, len(mine), 50)]
    )


def _lifted(turning: Turning, surface: TurnedSurface, radius: float) -> Array:
    one = replace(surface, time=surface.time[:, :1])
    times = _around(turning, one, ROLLED)
    found = passes_at(turning, times, surface.flat, surface.flat_normals)
    row, t = found.row, found.t
    p, n = surface.flat[:, [0, 2]], surface.flat_normals[:, [0, 2]]
    across = np.stack([-n[:, 1], n[:, 0]], axis=1)
    known = row >= 0
    centre, r = np.full((*row.shape, 2), 1e9), np.ones(row.shape)
    centre[known] = nose.noses(turning.sweep, row[known], t[known])
    r[known] = nose.nose_radius(turning.sweep)[row[known]]

    def lift(a: Array) -> Array:
        """Height (m, A) at which the ball would rest if it touched over offsets a (m, A)."""
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
