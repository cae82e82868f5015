"""Profile filters of ISO 16610: extract the long waves of a dense profile, for form tolerances with a filter.

gaussian  ISO 16610-21: weights exp(-pi (x / (alpha lc))^2) with alpha = sqrt(ln 2 / pi) = 0.4697; a wave of length l passes with
          2^-((lc / l)^2): half of it at the cut-off, 2^-(1/16) = 95.8 % of one four times as long
spline    ISO 16610-22: 1 / (1 + (sin(pi d / l) / sin(pi d / lc))^4) of evenly spaced points at distance d; half at the cut-off
closed    round profiles: the cut-off is a number of undulations per revolution (UPR)
open      lines: the cut-off is a length. Beyond the ends there is nothing: Gaussian weights are taken of what is there, the spline
          ends free (its second difference is 0)

Filters are linear; they act on deviations from an element, in any order of the points.
"""

from __future__ import annotations

import math

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.pose import Array
from vcmm.part.characteristic import Filter
from vcmm.part.fit import FittedElement, associate, profile_line
from vcmm.part.part import Characteristic, Feature, frame

ALPHA = math.sqrt(math.log(2.0) / math.pi)
GAUSSIAN, SPLINE = "gaussian", "spline"
FILTER_KINDS = (GAUSSIAN, SPLINE)
PER_WAVE = 7  # points per wave of the cut-off that a profile needs (ISO 12181-2, ISO 12780-2)
EVEN = 0.05  # of a step that evenly spaced points may be off
WEIGHT_REACH_CUTOFFS = 1.6  # cut-offs beyond which Gaussian weights are below 1e-15


def words(f: Filter) -> str:
    """Describe the filter in words, for display beside a result."""
    number = "21" if f.kind == GAUSSIAN else "22"
    end = f"{f.upr:g} UPR" if f.upr is not None else f"cut-off {f.cutoff:g} mm"
    return f"{f.kind} filter ISO 16610-{number}, {end}"


def check_filter(c: Characteristic, feature: Feature) -> None:
    """Raise UsageError for a filter that is unknown, has no cut-off, or belongs to a form without a single profile."""
    if c.filter is None:
        return
    f, closed = c.filter, feature.kind == "circle"
    if f.kind not in FILTER_KINDS:
        raise UsageError(f'"{c.name}": filter = "{f.kind}".{choose_from(f.kind, FILTER_KINDS)}')
    if (c.type, feature.kind) not in (("roundness", "circle"), ("straightness", "line")):
        raise UsageError(
            f'"{c.name}": a filter is of one profile: roundness of a circle or straightness of a line. A {feature.kind} has profiles in '
            "many sections and directions; state the form of one of them as a circle or line, or leave the filter out."
        )
    if c.criterion not in ("G", "GG", "C"):
        raise UsageError(
            f'"{c.name}": a filtered form is about the least-squares element (G) or its minimum zone (C): what touches '
            "peaks or valleys touches those that the filter takes away."
        )
    key, given, other = ("upr", f.upr, f.cutoff) if closed else ("cutoff", f.cutoff, f.upr)
    if given is None or other is not None or not given > 0:
        example = "upr = 50" if closed else 'cutoff = "0.8 mm"'
        raise UsageError(
            f'"{c.name}": the filter of a {feature.kind} needs its {key} alone, for example {example}'
        )


def check_density(c: Characteristic, feature: Feature, points: Array) -> None:
    """Raise UsageError where points (n, 3) are too few for the cut-off, or not evenly spaced for a spline."""
    if c.filter is None:
        return
    at, around = profile_places(feature, points)
    order = np.argsort(at, kind="stable")
    steps = np.diff(at[order])
    whole = around if around else float(np.ptp(at))
    waves = c.filter.upr if c.filter.upr is not None else whole / float(c.filter.cutoff or whole)
    if len(at) < PER_WAVE * waves:
        raise UsageError(
            f'"{c.name}": {len(at)} points on "{feature.name}" do not hold {waves:.3g} waves; its filter needs '
            f"{math.ceil(PER_WAVE * waves)} points, {PER_WAVE} per wave (or a longer cut-off)"
        )
    if c.filter.kind == SPLINE and not _even(steps, around, len(at)):
        raise UsageError(f'"{c.name}": a spline filter needs evenly spaced points; use filter = "gaussian".')


def profile_places(feature: Feature, points: Array) -> tuple[Array, float]:
    """Return where points (n, 3) lie along the profile (n,), and its length if it is closed (else 0): rad for a circle, mm for a line."""
    u, v, w = frame(feature)
    arm = points - feature.point
    if feature.kind == "circle":
        return np.arctan2(arm @ v, arm @ u), 2.0 * math.pi
    return np.asarray(arm @ w), 0.0


def apply_filter(f: Filter, feature: Feature, points: Array, deviations: Array) -> Array:
    """Return the long waves (..., n) of deviations (..., n) at points (n, 3)."""
    at, around = profile_places(feature, points)
    order = np.argsort(at, kind="stable")
    values, places = deviations[..., order], at[order]
    out = np.empty_like(values, dtype=float)
    out[..., order] = _filter_closed_profile(f, places, values) if around else _open(f, places, values)
    return out


def minimum_zone(feature: Feature, points: Array, deviations: Array) -> Array:
    """Return the width (...) of the minimum zone of a profile: of deviations (..., n) from its feature at points (n, 3), mm."""
    at, around = profile_places(feature, points)
    u, v, w = frame(feature)
    if not around:
        along = at[:, None] * w + deviations[..., None] * u
        return _range(profile_line("C", along, feature.axis, u).element.residuals)
    way = np.cos(at)[:, None] * u + np.sin(at)[:, None] * v
    about = np.zeros((*deviations.shape[:-1], 3))
    base = FittedElement(
        "circle",
        about,
        about + feature.axis,
        about[..., :1] + feature.sizes[:1],
        np.zeros(0),
        np.zeros((0, 3)),
    )
    ring = (feature.sizes[0] + deviations[..., None]) * way
    return _range(
        associate("circle", "C", ring, base, fixed_axis=feature.axis, judged=False).element.residuals
    )


def _range(values: Array) -> Array:
    return np.asarray(values.max(axis=-1) - values.min(axis=-1))


def transmission(f: Filter, waves: Array, n: int) -> Array:
    """Return the share of a closed profile of n points that passes, for waves (k,) per revolution."""
    upr = float(f.upr or 1.0)
    if f.kind == GAUSSIAN:
        return np.asarray(np.exp2(-((waves / upr) ** 2)))
    ratio = np.sin(np.pi * waves / n) / math.sin(math.pi * min(upr / n, 0.5))
    return np.asarray(1.0 / (1.0 + ratio**4))


def _filter_closed_profile(f: Filter, at: Array, values: Array) -> Array:
    n = len(at)
    if f.kind == SPLINE or _even(np.diff(at), 2.0 * math.pi, n):
        share = transmission(f, np.arange(n // 2 + 1, dtype=float), n)
        return np.asarray(np.fft.irfft(np.fft.rfft(values, axis=-1) * share, n, axis=-1))
    cut = 2.0 * math.pi / float(f.upr or 1.0)
    apart = np.abs(at[:, None] - at[None, :])
    weight = _weights(np.minimum(apart, 2.0 * math.pi - apart), cut) * _lengths(at, 2.0 * math.pi)
    return np.asarray(values @ (weight / weight.sum(axis=1, keepdims=True)).T)


def _open(f: Filter, at: Array, values: Array) -> Array:
    cut, n = float(f.cutoff or 1.0), len(at)
    if f.kind == SPLINE:
        return _open_spline(float(np.mean(np.diff(at))), cut, values)
    if not _even(np.diff(at), 0.0, n):
        weight = _weights(np.abs(at[:, None] - at[None, :]), cut) * _lengths(at, 0.0)
        return np.asarray(values @ (weight / weight.sum(axis=1, keepdims=True)).T)
    from scipy.signal import fftconvolve

    step = float(np.ptp(at)) / (n - 1)
    reach = min(n - 1, math.ceil(WEIGHT_REACH_CUTOFFS * cut / step))
    kernel = _weights(np.arange(-reach, reach + 1, dtype=float) * step, cut)
    rows = values.reshape(-1, n)
    smooth = fftconvolve(rows, kernel[None], mode="full", axes=1)[:, reach : reach + n]
    there = fftconvolve(np.ones(n), kernel, mode="full")[reach : reach + n]
    return np.asarray((smooth / there).reshape(values.shape))


def _open_spline(step: float, cut: float, values: Array) -> Array:
    """Solve (I + a^4 Q) w = z, Q of second differences with free ends; a = 1 / (2 sin(pi d / lc))."""
    from scipy.linalg import solveh_banded

    n = values.shape[-1]
    a4 = (1.0 / (2.0 * math.sin(math.pi * min(step / cut, 0.5)))) ** 4
    main, next_, third = np.full(n, 6.0), np.full(n, -4.0), np.ones(n)
    main[[0, -1]], main[[1, -2]] = 1.0, 5.0
    next_[[1, -1]] = -2.0  # next_[0] is outside the matrix
    bands = np.stack([a4 * third, a4 * next_, 1.0 + a4 * main])
    return np.asarray(solveh_banded(bands, values.reshape(-1, n).T).T.reshape(values.shape))


def _weights(away: Array, cut: float) -> Array:
    return np.asarray(np.exp(-np.pi * (away / (ALPHA * cut)) ** 2))


def _lengths(at: Array, around: float) -> Array:
    """Return the length of the profile that each point represents (n,): half way to its neighbours."""
    gaps = np.diff(np.concatenate([at, [at[0] + around]])) if around else np.diff(at)
    if around:
        return np.asarray((gaps + np.roll(gaps, 1)) / 2.0)
    return np.asarray((np.append(gaps, gaps[-1]) + np.insert(gaps, 0, gaps[0])) / 2.0)


def _even(steps: Array, around: float, n: int) -> bool:
    step = around / n if around else float(steps.sum()) / max(n - 1, 1)
    return bool(np.abs(steps - step).max(initial=0.0) <= EVEN * step)
