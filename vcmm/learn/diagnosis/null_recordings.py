"""The simulator's own null: recordings in which nothing is concealed, prepared exactly as the real one.

The threshold is an upper bound of the wanted quantile of the largest score: the order statistic that lies above that
quantile with 95 % probability (binomial; David & Nagaraja, Order Statistics (2003), 7.1).
"""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener
from vcmm.core.kinematics import CHUNK
from vcmm.core.run import Array
from vcmm.learn.diagnosis.constants import FALSE_ALARM, FAR_SIGMAS, MAD, SECURE
from vcmm.learn.diagnosis.problem import generator

NUMBERS = 1 << 22  # of simulated residuals that are copied at a time: 32 MB


@dataclass(frozen=True)
class Noise:
    """Law of one observation in units of u: dof of a t law (inf: normal). `clip` = preparation threshold."""

    dof: float = np.inf
    clip: float = FAR_SIGMAS


def draw_null_recordings(noise: Noise, white: Whitener, seed: int, name: str, count: int) -> Array:
    """Return the null residuals (m, count) in the white space: calibration and nuisance are exactly what the whitener removes."""
    rng = generator(seed, name)
    m = len(white.weight)
    raw = rng.standard_normal((m, count))
    if np.isfinite(noise.dof):
        raw = rng.standard_t(noise.dof, (m, count))
        raw /= np.sqrt(noise.dof / (noise.dof - 2))
    _add(raw, white.nuisance, -(white.nuisance.T @ raw))
    of_prior = white.prior.T @ raw  # calibration: the white part has unit variance in every direction left
    _add(raw, white.prior, -of_prior)
    _add(raw, white.prior, rng.standard_normal(of_prior.shape))
    return raw


def _add(raw: Array, columns: Array, sizes: Array) -> None:
    """Add columns (m, k) @ sizes (k, count) to raw (m, count), CHUNK rows at a time: null recordings are the largest table there is."""
    for i in range(0, len(raw), CHUNK):
        raw[i : i + CHUNK] += columns[i : i + CHUNK] @ sizes


def clip_residuals(r: Array, white: Whitener, limit: float) -> Array:
    """Return the white residuals (m,) or (m, M), limited to `limit` robust standard deviations, put back outside the nuisance."""
    if not np.isfinite(limit):
        return r
    bound = limit * robust_scale(r)
    cut = np.clip(r, -bound, bound)
    return np.asarray(cut - white.nuisance @ (white.nuisance.T @ cut))


def robust_scale(r: Array) -> Array:
    """Return the MAD about zero as a standard deviation, along the first axis: scalar or (M,)."""
    return by_columns(lambda part: np.asarray(MAD * np.median(np.abs(part), axis=0)), r)


def by_columns(of: Callable[..., Array], r: Array, *numbers: Array) -> Array:
    """Return of(r, *numbers) (M,) of recordings r (m, M) and numbers (M,) of each, so many recordings at a time that copies stay small."""
    if r.ndim < 2 or r.size <= NUMBERS:
        return of(r, *numbers)
    wide = max(NUMBERS // len(r), 1)
    blocks = [slice(i, i + wide) for i in range(0, r.shape[1], wide)]
    return np.concatenate([of(r[:, b], *(n[b] for n in numbers)) for b in blocks])


def upper_quantile(values: Array, false_alarm: float = FALSE_ALARM) -> float:
    """Return the order statistic that exceeds the (1 - false_alarm) quantile with probability SECURE."""
    from scipy.special import bdtr  # scipy.stats takes a second to import

    values = np.sort(values)
    count = np.arange(len(values) + 1)
    below = bdtr(count, len(values), 1.0 - false_alarm)
    rank = int(np.argmax(below >= SECURE))  # 0-based: one above the 95 % point of counts below
    return float(values[min(rank, len(values) - 1)])
