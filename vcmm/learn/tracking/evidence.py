"""Compute the likelihood of every recording given the ones before it, for many rates at once.

The state is integrated out by a filter (Schweppe, IEEE Trans. Inf. Theory 11 (1965) 61) that goes by covariances: fast, and exact enough for a
ratio of likelihoods; the state that is kept goes by factors (vcmm.learn.tracking.kalman).

    y_t = C z + C_g (b + w + p + (cos a - 1) s + sin a c + v t / year),   a = 2 pi t / year
    P -> P - K (H P),   K = P H' (H P H' + I)^-1,   m -> m + K (y - H m)

It is the model of vcmm.learn.tracking.rates with season and trend as numbers that do not move, seen through columns that do: s, c and v of the first
recording, which are left out where no rate asks for them. So only b and w step in time, and all rates share their columns. Where an innovation
is beyond chance the jumps are weighed as in vcmm.learn.tracking.changes, and their mixture is joined to one Gaussian. w is carried where there is a
swing, p from a jump that passes until it has gone back.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import cached_property

import numpy as np
import numpy.typing as npt

from vcmm.core.run import Array
from vcmm.learn.tracking.changes import ASK, MATTERS, SIZES, Jump, prior_of_change
from vcmm.learn.tracking.compress import SeenRecording
from vcmm.learn.tracking.kalman import square_at
from vcmm.learn.tracking.rates import BLOCKS, PASSES, YEAR, WanderingMotion

Numbers = npt.NDArray[np.intp]
GONE = 1e-9  # usual sizes: less than this is nothing


@dataclass(frozen=True, eq=False)
class _Layout:
    """The state z, b, s, c, v, w, p of m rates: stated numbers z, g shapes; season, trend: shapes of which one of the rates has it.

    walk2, swing2, tau (m, g); ways: columns of all jumps side by side, (n, sum of k); of: number of the jump of each.
    """

    stated: int
    season: Numbers
    trend: Numbers
    walk2: Array
    swing2: Array
    tau: Array
    ways: Array
    of: Numbers

    @property
    def g(self) -> int:
        return int(self.walk2.shape[1])

    @cached_property
    def gram(self) -> Array:
        """Widening (jumps, n, n) of the covariance by a jump of usual size."""
        parts = [self.ways[:, self.of == j] for j in range(int(self.of.max()) + 1)]
        return np.array([p @ p.T for p in parts])

    @property
    def w(self) -> int:
        """Index at which w begins."""
        return self.stated + self.g + 2 * len(self.season) + len(self.trend)

    @property
    def without_p(self) -> int:
        return self.w + (self.g if self.swings else 0)

    @cached_property
    def swings(self) -> bool:
        return bool(self.swing2.any())

    def columns(self, recording: SeenRecording, days: float) -> Array:
        """Return the columns (r, n) of readings of a day on the whole state."""
        grown, turn = recording.columns[:, self.stated :], 2.0 * np.pi * days / YEAR
        season, swing = grown[:, self.season], grown if self.swings else grown[:, :0]
        return np.concatenate(
            [
                recording.columns, season * (np.cos(turn) - 1.0), season * np.sin(turn), grown[:, self.trend] * (days / YEAR), swing, grown
            ],
            axis=1,
        )  # fmt: skip


def _layout_of(motions: Sequence[WanderingMotion], jumps: Sequence[Jump]) -> _Layout:
    walk, trend, season, swing, tau = (
        np.array([getattr(m, k) for m in motions]) for k in ("walk", "trend", "season", "swing", "tau")
    )
    stated, g, swings = motions[0].stated, walk.shape[1], bool(swing.any())
    seasons, trends = np.flatnonzero(season.any(axis=0)), np.flatnonzero(trend.any(axis=0))
    ways = np.concatenate([np.zeros((stated + BLOCKS * g, 0)), *(j.columns for j in jumps)], axis=1)
    loading = np.zeros((stated + (2 + swings) * g + 2 * len(seasons) + len(trends), ways.shape[1]))
    loading[stated : stated + g], loading[len(loading) - g :] = (
        ways[stated : stated + g],
        ways[len(ways) - g :],
    )
    of = np.repeat(np.arange(len(jumps)), [j.columns.shape[1] for j in jumps])
    return _Layout(stated, seasons, trends, walk**2, swing**2, tau, loading, of)


def log_likelihoods(
    recordings: Sequence[SeenRecording], motions: Sequence[WanderingMotion], jumps: Sequence[Jump]
) -> Array:
    """Return, of every motion, ln of the likelihood of all recordings, each given those before, (m,)."""
    layout = _layout_of(motions, jumps)
    mean, covariance = _start(layout, motions)
    total, first, before = np.zeros(len(motions)), None, 0.0
    for recording in recordings:
        first = recording.when if first is None else first
        days = recording.when - first
        gap, before = days - before, days
        if gap > 0:
            mean, covariance = _move(layout, mean, covariance, gap)
        if not len(recording.value):
            continue
        columns = layout.columns(recording, days)
        forecast = _see(mean, covariance, columns, recording.value)
        if not jumps:
            total += forecast.log_likelihood
            _condition(mean, covariance, forecast)
            continue
        p = prior_of_change(gap)
        quiet = forecast.log_likelihood + np.log1p(-p)
        places = np.flatnonzero(forecast.square >= square_at(len(recording.value), ASK))
        kept = mean[places], covariance[places]
        _condition(mean, covariance, forecast)
        if len(places):
            logs = np.concatenate(
                [quiet[places, None], _log_of_jumps(layout, forecast, places, columns, np.log(p / (len(jumps) * len(SIZES))))],
                axis=1,
            )  # fmt: skip
            joined, quiet[places] = _join(layout, kept, columns, recording.value, logs)
            mean, covariance = _put(mean, covariance, places, joined)
        total += quiet
    return total


def _start(layout: _Layout, motions: Sequence[WanderingMotion]) -> tuple[Array, Array]:
    """Return the means (m, n) and covariances (m, n, n) before the first recording; with w where a rate swings, without p."""
    m, g = layout.walk2.shape
    season = np.array([x.season for x in motions])[:, layout.season] ** 2
    trend = np.array([x.trend for x in motions])[:, layout.trend] ** 2
    blocks = [np.ones((m, layout.stated)), np.zeros((m, g)), season, season, trend]
    if layout.swings:
        blocks.append(layout.swing2)
    variance = np.concatenate(blocks, axis=1)
    covariance = np.zeros((*variance.shape, variance.shape[1]))
    _diagonal(covariance)[:] = variance
    return np.zeros_like(variance), covariance


def _diagonal(covariance: Array) -> Array:
    """Return a view, as (m, n)."""
    m, n, _ = covariance.shape
    return covariance.reshape(m, n * n)[:, :: n + 1]


def _move(layout: _Layout, mean: Array, covariance: Array, days: float) -> tuple[Array, Array]:
    """Move b, w and p so many days later, in place; p is left out again where its jump has gone back."""
    s, g, w, p = layout.stated, layout.g, layout.w, layout.without_p
    _diagonal(covariance)[:, s : s + g] += layout.walk2 * (days / YEAR)
    if layout.swings:
        _shrink(mean, covariance, slice(w, p), np.exp(-days / layout.tau))
        _diagonal(covariance)[:, w:p] += layout.swing2 * -np.expm1(-2.0 * days / layout.tau)
    if mean.shape[1] == p:
        return mean, covariance
    _shrink(mean, covariance, slice(p, None), np.full((1, g), np.exp(-days / PASSES)))
    if max(float(_diagonal(covariance)[:, p:].max()), float((mean[:, p:] ** 2).max())) < GONE**2:
        return mean[:, :p].copy(), covariance[:, :p, :p].copy()
    return mean, covariance


def _shrink(mean: Array, covariance: Array, block: slice, left: Array) -> None:
    """Multiply a block of the state by left (m or 1, g), in place."""
    mean[:, block] *= left
    covariance[:, block] *= left[:, :, None]
    covariance[:, :, block] *= left[:, None, :]


@dataclass(frozen=True, eq=False)
class _Seen:
    """Data of m innovations: lower (m, r, r) Cholesky factors of their covariances, half (m, r, n) = lower^-1 H P, white (m, r)."""

    lower: Array
    half: Array
    white: Array

    @property
    def square(self) -> Array:
        return np.asarray((self.white**2).sum(axis=1))

    @property
    def log_likelihood(self) -> Array:
        logs = np.log(np.diagonal(self.lower, axis1=1, axis2=2)).sum(axis=1)
        return np.asarray(-0.5 * self.square - logs - 0.5 * self.white.shape[1] * np.log(2 * np.pi))


def _see(mean: Array, covariance: Array, columns: Array, value: Array) -> _Seen:
    """Return the innovations of columns (r, all of the state): those of p are left out where it is not carried."""
    of_state = columns[:, : mean.shape[1]]
    cross = of_state @ covariance
    lower = np.asarray(np.linalg.cholesky(cross @ of_state.T + np.eye(len(value))), dtype=np.float64)
    inverse = np.linalg.solve(
        lower, np.eye(len(value))
    )  # few rows: a product with it is faster than a solution for all columns
    return _Seen(lower, inverse @ cross, (inverse @ (value - mean @ of_state.T)[:, :, None])[:, :, 0])


def _condition(mean: Array, covariance: Array, forecast: _Seen) -> None:
    """Condition means and covariances on the readings, in place."""
    turned = forecast.half.transpose(0, 2, 1)
    mean += (turned @ forecast.white[:, :, None])[:, :, 0]
    covariance -= turned @ forecast.half


def _log_of_jumps(layout: _Layout, forecast: _Seen, places: Numbers, columns: Array, prior: float) -> Array:
    """Return (a, jumps x sizes): ln (prior x likelihood), by N(white; 0, I + size^2 A A'), A = lower^-1 H B."""
    white = forecast.white[places]
    moved = np.linalg.solve(forecast.lower[places], (columns @ layout.ways)[None])
    count = int(layout.of.max()) + 1
    parts = [moved[:, :, layout.of == j] for j in range(count)]
    gram = np.stack([p @ p.transpose(0, 2, 1) for p in parts], axis=1)
    wider = np.eye(white.shape[1]) + np.square(SIZES)[:, None, None] * gram[:, :, None]
    lower = np.linalg.cholesky(wider)  # (a, jumps, sizes, r, r)
    left = np.linalg.solve(lower, np.broadcast_to(white[:, None, None, :, None], (*lower.shape[:-1], 1)))
    fits = 0.5 * ((white**2).sum(axis=1)[:, None, None] - (left[..., 0] ** 2).sum(axis=-1))
    logs = fits - np.log(np.diagonal(lower, axis1=-2, axis2=-1)).sum(axis=-1)
    return np.asarray(
        prior + (forecast.log_likelihood[places][:, None, None] + logs).reshape(len(places), -1)
    )


def _join(
    layout: _Layout, before: tuple[Array, Array], columns: Array, value: Array, logs: Array
) -> tuple[tuple[Array, Array], Array]:
    """Return the means and covariances of the mixtures of all hypotheses that matter, with p, and ln of the likelihoods."""
    full = len(layout.ways)
    mean, covariance = (np.pad(x, [(0, 0)] + [(0, full - x.shape[1])] * (x.ndim - 1)) for x in before)
    top = logs.max(axis=1, keepdims=True)
    weights = np.exp(logs - top)
    total = top[:, 0] + np.log(weights.sum(axis=1))
    weights /= weights.sum(axis=1, keepdims=True)
    weights = np.where(weights > MATTERS, weights, 0.0)
    rows, numbers = np.nonzero(weights)
    share = weights[rows, numbers] / weights.sum(axis=1)[rows]
    jump = np.maximum(numbers - 1, 0) // len(SIZES)
    wider = np.where(numbers > 0, np.take(SIZES, (numbers - 1) % len(SIZES)), 0.0) ** 2
    m, p = mean[rows], covariance[rows] + wider[:, None, None] * layout.gram[jump]
    _condition(m, p, _see(m, p, columns, value))
    first = np.searchsorted(rows, np.arange(len(weights)))
    means = np.add.reduceat(share[:, None] * m, first, axis=0)
    away = m - means[rows]
    p += away[:, :, None] * away[:, None, :]
    return (means, np.add.reduceat(share[:, None, None] * p, first, axis=0)), total


def _put(mean: Array, covariance: Array, places: Numbers, joined: tuple[Array, Array]) -> tuple[Array, Array]:
    """Return the joined states in their places; all are widened by p where one of them has it now."""
    n, full = mean.shape[1], joined[0].shape[1]
    if n < full and np.any(_diagonal(joined[1])[:, n:]):
        mean = np.pad(mean, [(0, 0), (0, full - n)])
        covariance = np.pad(covariance, [(0, 0), (0, full - n), (0, full - n)])
        n = full
    mean[places], covariance[places] = joined[0][:, :n], joined[1][:, :n, :n]
    return mean, covariance
