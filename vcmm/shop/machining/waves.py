"""Search for the period of a wave in time that no effect of the catalogue explains.

    rest = base b + sum over x, y, z of (c_k cos 2 pi f t + s_k sin 2 pi f t) n_k + scatter

A whole vector of time at one frequency f, six numbers, for f on a grid of a third of 1 / duration from three waves over the duration (what
comes once or twice cannot be told from a growth, a drift or a change of tools, and is taken out before) up to half of the rate at which
the points were cut (Lomb, Astrophys. Space Sci. 39 (1976) 447, with a covariance and with what is taken out before). The gain in the
sum of squares is chi-square with six degrees of freedom; every frequency that was asked is paid (Bonferroni).
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.core.run import Array

STEPS = 3.0  # frequencies per 1 / duration: a wave between two of them loses a tenth of its gain at most
# over the duration: a growth that levels off is half a wave, one that comes back a whole one
LEAST_WAVES = 3.0
LEAST_POINTS = 30
# points squared times frequencies: some seconds; more points are searched for long periods only
MOST_WORK = 8e8
CHUNK = 256
RANK = 1e-9  # of the largest eigenvalue of the normal equations


@dataclass(frozen=True, eq=False)
class Wave:
    """period s; gain in the sum of squares with `freedom` numbers, the largest of `periods_tried` periods; columns (n, 6) of the points."""

    period: float
    gain: float
    freedom: int
    periods_tried: int
    columns: Array


def largest_wave(white: Array, base: Array, rest: Array, normals: Array, time: Array) -> Wave | None:
    """Return the wave that rest (n,) follows most beside base (n, r); None where time or points are too few.

    white (n, n): W with W cov W^T = 1; normals (n, 3); time (n,) s.
    """
    frequencies = frequencies_of(time)
    if not len(frequencies):
        return None
    outside = np.eye(len(rest)) - base @ base.T
    y = outside @ (white @ rest)
    through = [outside @ (white * normals[:, k]) for k in range(3)]
    best = (0.0, 0, 0.0)
    for part in np.array_split(frequencies, max(len(frequencies) // CHUNK, 1)):
        phase = 2.0 * np.pi * time[:, None] * part
        x = np.stack([m @ f for f in (np.cos(phase), np.sin(phase)) for m in through], axis=-1)
        gain, freedom = _gains(x, y)
        at = int(np.argmax(gain))
        best = max(best, (float(gain[at]), int(freedom[at]), float(part[at])))
    most, numbers, frequency = best
    if not numbers:
        return None
    period = 1.0 / frequency
    return Wave(period, most, numbers, len(frequencies), wave_columns(period, normals, time))


def wave_columns(period: float, normals: Array, time: Array) -> Array:
    """Return cos and sin of a period along x, y, z, as they show along the normals (n, 6)."""
    phase = 2.0 * np.pi * time / period
    return np.concatenate([normals * f(phase)[:, None] for f in (np.cos, np.sin)], axis=1)


def slow_courses(normals: Array, time: Array) -> Array:
    """Return half cosines along x, y, z up to LEAST_WAVES waves over the duration (n, 18): growths, drifts and changes that come once or twice.

    A rest that follows one of them closely is no wave, although one of the many periods that are tested fits a few moments of it by chance.
    """
    turn = np.pi * (time - time.min()) / max(float(np.ptp(time)), 1e-9)
    orders = range(1, int(2 * LEAST_WAVES) + 1)
    return np.concatenate([normals * np.cos(k * turn)[:, None] for k in orders], axis=1)


def frequencies_of(time: Array) -> Array:
    """Return 1/s: from three waves over the duration to half of the median rate of the points."""
    moments = np.unique(np.round(time, 3))
    if len(time) < LEAST_POINTS or len(moments) < LEAST_POINTS:
        return np.zeros(0)
    duration = float(np.ptp(moments))
    highest = 0.5 / float(np.median(np.diff(moments)))
    count = min(int((highest * duration - LEAST_WAVES) * STEPS), int(MOST_WORK / len(time) ** 2))
    return (LEAST_WAVES + np.arange(max(count, 0)) / STEPS) / duration


def _gains(x: Array, y: Array) -> tuple[Array, Array]:
    """Return the sums of squares (F,) of y (n,) that columns x (n, F, 6) explain, and their ranks (F,)."""
    square = np.einsum("nfi,nfj->fij", x, x, optimize=True)
    value, vector = np.linalg.eigh(square)
    along = np.einsum("fij,fi->fj", vector, np.einsum("nfi,n->fi", x, y, optimize=True))
    kept = value > RANK * value[:, -1:]
    return np.where(kept, along**2 / np.where(kept, value, 1.0), 0.0).sum(axis=1), kept.sum(axis=1)
