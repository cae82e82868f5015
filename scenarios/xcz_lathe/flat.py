"""Section 5: an optical flat scanned in a spiral on the lathe and, for comparison, by an interferometer beside it.

Published: radius 10 mm, flatness 8.7 nm offline, three repeats of each. Drawn: the flat's shape (low orders), the spiral, the probe's
noise beyond its resolution, how far the probe is off the centre, the interferometer's noise and the angle at which the flat is put under it.
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import cache

import numpy as np

from vcmm import Array, faces

from .lathe import NM, RADIUS, TURN, DrawnLathe, surface_motion
from .surveys import asynchronous, wander

FLAT = 7.5 * NM  # without noise; the interferometer then reads the published 8.7 in the mean
REPEATS = 3
PITCH, PER_TURN = 0.2, 180  # mm per turn, readings per turn (drawn)
RESOLUTION, READING = 0.6 * NM, 1.0 * NM  # of the probe; rms of one reading (drawn)
OFF = 0.01  # mm, rms: the probe off the centre, in X and in Y (drawn)
SLOW = 1.0 * NM  # rms: wander within a scan of the flat (drawn)
AIR, PIXEL = 0.5 * NM, 0.25 * NM  # interferometer: rms of a slow shape, of a pixel (drawn)
PUT = np.radians(2.0), 0.1  # rms: angle, place in mm under the interferometer (drawn)
CELL = 0.5  # mm: grid of both results
DEGREE = 6  # of the flat's shape
Map = Callable[[Array, Array], Array]  # x (n,) mm, angle (n,) rad -> (n,) mm


@dataclass(frozen=True, eq=False)
class Flatness:
    """Of a surface less its plane: peak to valley and rms, mm."""

    pv: float
    rms: float


@dataclass(frozen=True, eq=False)
class FlatScan:
    """One spiral: x (n,) mm, angle (n,) rad of the machine, reading (n,) mm."""

    x: Array
    angle: Array
    reading: Array


def shape_of(rng: np.random.Generator) -> Array:
    """Coefficients of a flat of the published flatness over the radius."""
    drawn = np.asarray(rng.standard_normal(terms(np.zeros(1), np.zeros(1)).shape[1]))
    drawn[:3] = 0.0
    order = np.array([n for n in range(DEGREE + 1) for _ in range(n + 1)])
    drawn = drawn / np.maximum(order, 1) ** 1.5
    x, y = cells()
    return np.asarray(drawn * FLAT / flatness(terms(x, y) @ drawn).pv)


def terms(x: Array, y: Array) -> Array:
    """(n, 28) Zernike terms to degree 6 at places mm; the first three are piston and tilts."""
    return faces.zernike_terms(x, y, RADIUS, DEGREE)


def face_scan(scan: FlatScan) -> faces.FaceScan:
    """As vcmm takes it."""
    run = np.full(len(scan.x), "1")
    return faces.FaceScan("flat", True, scan.x, scan.angle, scan.reading, run)


@cache
def cells() -> tuple[Array, Array]:
    """Middles (k,) mm of the cells that lie within the radius."""
    side = np.arange(-RADIUS + CELL / 2, RADIUS, CELL)
    x, y = (v.ravel() for v in np.meshgrid(side, side, indexing="ij"))
    kept = np.hypot(x, y) + CELL / np.sqrt(2) <= RADIUS
    return x[kept], y[kept]


def flatness(height: Array) -> Flatness:
    """Of heights (k,) mm at the cells."""
    left = levelled(height)
    return Flatness(float(np.ptp(left)), float(left.std()))


def levelled(height: Array) -> Array:
    x, y = cells()
    plane = np.stack([np.ones(len(x)), x, y], axis=1)
    return np.asarray(height - plane @ np.linalg.lstsq(plane, height, rcond=None)[0])


@cache
def spiral() -> tuple[Array, Array]:
    """x (n,) mm from the edge to the centre, angle (n,) rad."""
    n = int(RADIUS / PITCH) * PER_TURN
    return RADIUS - PITCH * np.arange(n) / PER_TURN, TURN * np.arange(n) / PER_TURN


def on_flat(x: Array, angle: Array, index: float = 0.0) -> tuple[Array, Array]:
    """Places (n,), (n,) mm on a flat that was turned by index rad on the spindle: a table axis C turns the part by -C."""
    return x * np.cos(angle - index), x * np.sin(angle - index)


def scanned(lathe: DrawnLathe, shape: Array, rng: np.random.Generator, index: float = 0.0) -> FlatScan:
    """One spiral of the flat by all errors of the machine, the probe off the centre."""
    x, angle = spiral()
    off = OFF * rng.standard_normal(2)
    px, py = x + off[0], np.full(len(x), off[1])
    c, s = np.cos(angle - index), np.sin(angle - index)
    height = terms(c * px - s * py, s * px + c * py) @ shape
    loose = [asynchronous(len(x), PER_TURN, rms, rng) for rms in lathe.asynchronous]
    moved = surface_motion(lathe.machine, x, angle, (float(off[0]), float(off[1]))) + loose[0] - x * loose[1]
    own = READING * rng.standard_normal(len(x)) + wander(len(x), rng, SLOW)
    read = height + moved + own + 5e-6 * rng.standard_normal() * px * np.cos(angle)
    return FlatScan(x, angle, np.round(read / RESOLUTION) * RESOLUTION)


def on_cells(height: Array, index: float = 0.0) -> Array:
    """(k,) means in every cell of heights (n,) along the spiral; cells that it misses take their nearest neighbour."""
    number, weight = _cell_numbers(index)
    total = np.bincount(number, height, len(weight))[:-1]
    count = weight[:-1]
    out = np.where(count > 0, total / np.maximum(count, 1), np.nan)
    if np.isnan(out).any():
        x, y = cells()
        empty, full = np.flatnonzero(np.isnan(out)), np.flatnonzero(~np.isnan(out))
        near = np.hypot(x[empty][:, None] - x[full], y[empty][:, None] - y[full]).argmin(axis=1)
        out[empty] = out[full[near]]
    return np.asarray(out)


@cache
def _cell_numbers(index: float) -> tuple[np.ndarray, Array]:
    """Cell of every place of the spiral (the last number: none), and how many lie in each."""
    x, y = on_flat(*spiral(), index)
    cx, cy = cells()
    table = {(round(a / CELL - 0.5), round(b / CELL - 0.5)): i for i, (a, b) in enumerate(zip(cx, cy))}
    where = np.array(
        [table.get((int(a), int(b)), len(cx)) for a, b in zip(np.floor(x / CELL), np.floor(y / CELL))]
    )
    return where, np.bincount(where, minlength=len(cx) + 1).astype(float)


def offline(shape: Array, rng: np.random.Generator) -> tuple[Array, float]:
    """(k,) heights by the interferometer, the flat lying turned and beside its place; and the angle, rad."""
    x, y = cells()
    turn, moved = PUT[0] * rng.standard_normal(), PUT[1] * rng.standard_normal(2)
    c, s = np.cos(turn), np.sin(turn)
    there = terms(c * x - s * y + moved[0], s * x + c * y + moved[1])
    slow = np.asarray(rng.standard_normal(there.shape[1]))
    slow *= AIR / (terms(x, y)[:, 3:] @ slow[3:]).std()
    return there @ shape + terms(x, y)[:, 3:] @ slow[3:] + PIXEL * rng.standard_normal(len(x)), float(turn)


def aligned(height: Array, reference: Array) -> tuple[Array, float]:
    """(k,) heights turned so that they differ least from the reference, and the angle, rad; by the fitted shape (-15 to 15 deg)."""
    x, y = cells()
    fitted = np.linalg.lstsq(terms(x, y), levelled(height), rcond=None)[0]
    best, found = np.inf, (height, 0.0)
    for turn in np.radians(np.arange(-15.0, 15.25, 0.5)):
        c, s = np.cos(turn), np.sin(turn)
        moved = terms(c * x - s * y, s * x + c * y) @ fitted
        left = float(levelled(moved - reference).std())
        if left < best:
            best, found = left, (moved, float(turn))
    return found
