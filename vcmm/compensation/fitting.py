"""Fit corrected points along a move by as few blocks as hold the tolerance: lines by chords, arcs by arcs.

A chord of length L under a correction of curvature e'' leaves L^2 e'' / 8, so L = sqrt(8 tol / |e''|). Here the points
themselves are tested, so that tables with kinks work as well.
"""

from __future__ import annotations

import math
from dataclasses import dataclass

import numpy as np

from vcmm.compensation.contours import sweep_of
from vcmm.core.run import Array
from vcmm.program.moves import PLANES, Move

COUNTS = (1, 2, 3, 4, 6, 8, 12, 16, 24, 32, 48)
WHOLE = 0.02  # rad: an arc nearer than this to a whole turn must end exactly where it began, or be split
UNEVEN = 5e-4  # mm: an arc whose radii differ by more is a spiral, and stays one
# rad: below, the place of the centre along the bisector is not seen; it follows the mean correction
SMALL_SWEEP_RAD = 0.05


@dataclass(frozen=True, eq=False, slots=True)
class BlockPiece:
    """One block: it ends at `end` (machine coordinates, before rounding) at this share of the move; arcs have a centre."""

    share: float
    end: Array
    centre: Array | None = None


@dataclass(frozen=True, eq=False, slots=True)
class BlockFit:
    """Blocks of one move, and the largest departure that they leave across the path, mm (before rounding)."""

    pieces: tuple[BlockPiece, ...]
    residual: float


def chords(m: Move, share: Array, wanted: Array, across: Array, limit: float, split: bool) -> BlockFit:
    """Return lines through wanted points (k, 3), the longest ones that hold the limit."""
    last = len(share) - 1
    if not split or last < 2:
        return BlockFit((BlockPiece(1.0, wanted[-1]),), _bow(share, wanted, across, 0, last))
    pieces, at, worst = [], 0, 0.0
    while at < last:
        to = _farthest(share, wanted, across, at, last, limit)
        worst = max(worst, _bow(share, wanted, across, at, to))
        pieces.append(BlockPiece(float(share[to]), wanted[to]))
        at = to
    return BlockFit(tuple(pieces), worst)


def _farthest(share: Array, wanted: Array, across: Array, at: int, last: int, limit: float) -> int:
    """Return the last point that a chord from `at` may reach: doubling, then halving."""
    good, step = at + 1, 1
    while good < last:
        to = min(good + step, last)
        if _bow(share, wanted, across, at, to) > limit:
            break
        good, step = to, 2 * step
    while step > 1:
        step //= 2
        to = min(good + step, last)
        if to > good and _bow(share, wanted, across, at, to) <= limit:
            good = to
    return good


def _bow(share: Array, wanted: Array, across: Array, a: int, b: int) -> float:
    """Return the largest departure across the path of points a..b from their chord."""
    if b - a < 2:
        return 0.0
    t = (share[a : b + 1] - share[a]) / (share[b] - share[a])
    off = wanted[a : b + 1] - (wanted[a] + t[:, None] * (wanted[b] - wanted[a]))
    return float(np.linalg.norm(np.einsum("kij,kj->ki", across[a : b + 1], off), axis=1).max())


def arcs(m: Move, wanted: Array, limit: float, most: int, least: int = 1) -> BlockFit:
    """Return arcs through corrected points (k, 3) of an arc, evenly spaced; k - 1 is a multiple of every count that is tried."""
    least = min(least, most)
    last = len(wanted) - 1
    best: BlockFit | None = None
    for count in COUNTS:
        if last % count or last // count < 2 or not least <= count <= most:
            continue
        sweep = abs(sweep_of(m)) / count
        if count == 1 and _whole(sweep) and _end_difference(m, wanted) > 0.5 * limit:
            continue
        if sweep > 2 * math.pi - WHOLE and count > 1:
            continue
        fit = _even(m, wanted, count)
        if best is None or fit.residual < best.residual:
            best = fit
        if fit.residual <= limit:
            return fit
    assert best is not None
    return best


def _whole(sweep: float) -> bool:
    return sweep > math.pi and abs(math.remainder(sweep, 2 * math.pi)) < WHOLE


def _end_difference(m: Move, wanted: Array) -> float:
    """Return how much the corrections at both ends of an arc differ, mm."""
    shift = (wanted[-1] - np.array(m.end)) - (wanted[0] - np.array(m.start))
    return float(np.linalg.norm(shift))


def _even(m: Move, wanted: Array, count: int) -> BlockFit:
    part = (len(wanted) - 1) // count
    pieces, worst = [], 0.0
    for i in range(count):
        inside = wanted[i * part : (i + 1) * part + 1]
        centre, residual = fitted_arc(m, inside, abs(sweep_of(m)) / count, i / count, (i + 1) / count)
        pieces.append(BlockPiece((i + 1) / count, inside[-1], centre))
        worst = max(worst, residual)
    return BlockFit(tuple(pieces), worst)


def fitted_arc(m: Move, wanted: Array, sweep: float, begin: float, end: float) -> tuple[Array, float]:
    """Return the centre (3,) of the arc from the first to the last point that is nearest to those between, and its largest departure, mm."""
    a, b, n = PLANES[m.plane]
    assert m.centre is not None
    flat = wanted[:, [a, b]]
    whole = _whole(sweep)
    guess = np.array([m.centre[a], m.centre[b]]) + _mean_shift(m, wanted, begin, end)
    centre = guess
    uneven = abs(
        math.dist((m.start[a], m.start[b]), (m.centre[a], m.centre[b]))
        - math.dist((m.end[a], m.end[b]), (m.centre[a], m.centre[b]))
    )
    if uneven > UNEVEN:
        pass  # the radius changes on the way as programmed: the centre goes with the mean correction
    elif sweep > SMALL_SWEEP_RAD:
        centre = _free_centre(flat, guess) if whole else _on_bisector(flat, guess)
    elif not whole:
        centre = _project(flat, guess)
    radius = np.linalg.norm(flat - centre, axis=1)
    t = np.linspace(0.0, 1.0, len(flat))
    off = radius - (radius[0] + t * (radius[-1] - radius[0]))
    rise = wanted[:, n] - (wanted[0, n] + t * (wanted[-1, n] - wanted[0, n]))
    out = np.zeros(3)
    out[a], out[b], out[n] = centre[0], centre[1], wanted[0, n]
    return out, float(np.hypot(off, rise).max())


def _mean_shift(m: Move, wanted: Array, begin: float, end: float) -> Array:
    from vcmm.compensation.contours import points

    a, b, _ = PLANES[m.plane]
    nominal = points(m, np.linspace(begin, end, len(wanted)))
    return np.asarray((wanted - nominal)[:, [a, b]].mean(axis=0))


def _bisector(flat: Array) -> tuple[Array, Array]:
    chord = flat[-1] - flat[0]
    across = np.array([-chord[1], chord[0]])
    return (flat[0] + flat[-1]) / 2, across / np.linalg.norm(across)


def _project(flat: Array, guess: Array) -> Array:
    middle, w = _bisector(flat)
    return np.asarray(middle + ((guess - middle) @ w) * w)


def _on_bisector(flat: Array, guess: Array) -> Array:
    """Solve by Gauss-Newton for the one number that the ends leave free: the place of the centre on their bisector."""
    middle, w = _bisector(flat)
    h = float((guess - middle) @ w)
    for _ in range(4):
        away = flat - (middle + h * w)
        size = np.linalg.norm(away, axis=1)
        slope = -(away @ w) / size
        slope = slope - slope[0]
        miss = size - size[0]
        square = float(slope @ slope)
        if square < 1e-12:
            break
        h -= float(slope @ miss) / square
    return np.asarray(middle + h * w)


def _free_centre(flat: Array, guess: Array) -> Array:
    """Fit a whole circle through its own start: Gauss-Newton for both coordinates of the centre."""
    centre = guess.copy()
    for _ in range(4):
        away = flat - centre
        size = np.linalg.norm(away, axis=1)
        slope = -away / size[:, None]
        step = np.linalg.lstsq(slope - slope[0], -(size - size[0]), rcond=None)[0]
        centre = centre + step
    return np.asarray(centre)
