"""Waves whose period stands on no list: the spectrum of what is left, at every frequency that the rows can tell from a lower one.

    P(f) = v' M^-1 v,  v = sum_k z_k (cos, sin)(2 pi f q_k),  M = sum_k (D_k / u_k)^2 (cos, sin)' (cos, sin)(2 pi f q_k)

z: the white residual pulled back to the rows (Whitener.adjoint) times D, what a unit motion of the axis does to the observation; q: the
places, however uneven. P is the sum of squares that a sine and a cosine take away (Lomb, Astrophys. Space Sci. 39 (1976) 447; Scargle,
Astrophys. J. 263 (1982) 835), worth -dof / 2 ln(1 - P / sum of squares) nats. It is made by one FFT of the rows in bins an eighth of the
shortest wave wide, of v and, at 2 f, of M; from a wave that is twice as fine as the finest usual one, or from what rows on a lattice can tell.

The highest lines become options at their best period. The price of having looked elsewhere is simulated: nats of the highest line of M independent
ones, in noise alone, are ln M plus a Gumbel variable of mean 0.5772 and standard deviation 1.28, so the mean of FEWEST of them less 0.5772 is ln M to 0.3.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.answer.evaluation.gaussian import Ints, Whitener, without_span
from vcmm.core.effect import Effect, parameter_fields
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import Option
from vcmm.learn.diagnosis.constants import FEWEST, MOST_SHAPES, NOTHING, SAME, UNSEEN
from vcmm.learn.diagnosis.periods import MOST_BINS, NEAR, TURNS, coordinate, shortest
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.refine import at_value
from vcmm.learn.diagnosis.scans import turns_round

FINER = 2.0  # times finer than the finest usual period: what is looked at
GRID = 0.5  # of 1 / range: a trial period that is closer stands on the line already


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Frequencies (k,) and, of rows (m,), what they need: bins, factor D, whitener."""

    frequency: Array
    kept: slice
    bins: Ints
    factor: Array
    white: Whitener
    points: int
    length: float
    cc: Array  # M of every frequency: cos cos, sin sin, cos sin
    ss: Array
    cs: Array

    def nats(self, r: Array) -> Array:
        """Nats (k,) of a wave of each frequency in a white residual r (m,)."""
        z = self.white.adjoint(r) * self.factor
        turned = np.fft.rfft(np.bincount(self.bins, z, minlength=self.points))[self.kept]
        c, s = turned.real, -turned.imag
        taken = (self.ss * c**2 + self.cc * s**2 - 2.0 * self.cs * c * s) / (self.cc * self.ss - self.cs**2)
        share = np.clip(taken / max(float(r @ r), NOTHING), 0.0, 1.0 - UNSEEN)
        return np.asarray(-0.5 * self.white.dof * np.log1p(-share))


def lines_of(
    template: Option,
    r: Array,
    basis: Array,
    white: Whitener,
    problem: Problem,
    floor: float,
    known: Sequence[float],
    most: int,
) -> list[tuple[Option, float]]:
    """The highest lines that no trial period stands on, as options, and ln of their share of all lines.

    r (m,): white residual outside `basis`; floor: nats that a line must have beyond its price; known: trial periods, as how many lie
    within the range of the places.
    """
    effect = template.effect
    spectrum = None if effect is None else spectrum_of(effect, problem, white)
    if effect is None or spectrum is None:
        return []
    nats = spectrum.nats(r)
    if float(nats.max()) <= floor:
        return []
    price = price_of(spectrum, basis)
    out: list[tuple[Option, float]] = []
    taken = [periods / spectrum.length for periods in known]
    for k in np.argsort(-nats)[: MOST_SHAPES * FEWEST]:
        f = float(spectrum.frequency[k])
        if nats[k] <= floor + price or len(out) == most:
            break
        if any(abs(f - other) * spectrum.length < GRID for other in taken):
            continue
        option = at_value(template, "period", 1.0 / f, problem)
        if option is not None:
            out.append((option, -price))
            taken.append(f)
    return out


def spectrum_of(effect: Effect, problem: Problem, white: Whitener) -> Spectrum | None:
    """The frequencies of one wave on the rows of a problem; None where it has none to be searched."""
    q = coordinate(effect, problem.run)
    if q is None or turns_round(effect) or (problem.recording.other >= 0).any():
        return None
    spec = next(f for f in parameter_fields(effect) if f.name == "period")
    finest = min(spec.metadata["scan"]) / FINER
    at = problem.of_rows(q)
    length = float(np.ptp(at))
    highest = min(1.0 / shortest(q, finest), MOST_BINS * NEAR / max(length, NOTHING))
    if length <= 0 or highest * length <= TURNS + 1:
        return None
    width = NEAR / highest
    bins = np.round((at - at.min()) / width).astype(np.intp)
    points = 1 << int(np.ceil(np.log2(2 * (int(bins.max()) + 1))))
    frequency = np.arange(points // 2 + 1) / (points * width)
    first, last = np.searchsorted(frequency, [TURNS / length, highest])
    factor = _factor(effect, problem, at)
    energy = (factor * white.weight) ** 2
    total = float(energy.sum())
    if total <= 0 or last - first < 2:
        return None
    kept = slice(int(first), int(last))
    twice = np.fft.rfft(np.bincount(bins, energy, minlength=points))[2 * int(first) : 2 * int(last) : 2]
    cc, ss = (np.maximum(0.5 * (total + sign * twice.real), UNSEEN * total) for sign in (1.0, -1.0))
    cs = np.clip(-0.5 * twice.imag, -SAME * np.sqrt(cc * ss), SAME * np.sqrt(cc * ss))
    return Spectrum(frequency[kept], kept, bins, factor, white, points, length, cc, ss, cs)


def _factor(effect: Effect, problem: Problem, at: Array) -> Array:
    """What a unit motion of the axis does to the observation (m,): D of D sin and D cos; at (m,): the places."""
    sine, cosine = problem.columns(effect, ["sine", "cosine"]).T
    phase = 2.0 * np.pi * int(getattr(effect, "harmonic", 1)) / float(getattr(effect, "period"))  # noqa: B009
    return np.asarray(sine * np.sin(phase * at) + cosine * np.cos(phase * at))


def price_of(spectrum: Spectrum, basis: Array) -> float:
    """ln of the number of independent lines, by simulation."""
    rng = np.random.default_rng(0)
    highest = []
    for _ in range(FEWEST):
        x = rng.standard_normal(len(spectrum.factor))
        x = x - spectrum.white.nuisance @ (spectrum.white.nuisance.T @ x)
        highest.append(float(spectrum.nats(without_span(x, basis)).max()))
    return max(float(np.mean(highest)) - float(np.euler_gamma), 0.0)
