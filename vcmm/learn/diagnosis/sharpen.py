"""Sharpen time constants, distances and periods of all competitors before names are compared.

A coarse grid of trial values decides nothing between two names that both need a value off the grid: with a strong signal the
half step that is missing costs tens of nats. So after a first search the names that explain most, alone and beside all
chosen terms but one, get an option at their own best values, in every shape (one lag or two); then the search runs again.

Such an option weighs as its cell of the grid, times the share of the cell that the rows leave open:
sqrt(2 pi) s / width, s from the curvature of the evidence (Laplace's approximation of the mean over the cell).

Of a wave the highest lines of the spectrum are searched and not the highest alone: half a step off its best, the true line may
stand below a side lobe that the grid happens to hit. Lines without a trial period come from the continuous spectrum.

Waves with a period on no list: the spectrum of the residual, at every frequency that the rows can tell from a lower one.

    P(f) = v' M^-1 v,  v = sum_k z_k (cos, sin)(2 pi f q_k),  M = sum_k (D_k / u_k)^2 (cos, sin)' (cos, sin)(2 pi f q_k)

z: the white residual pulled back to the rows (Whitener.adjoint) times D, the effect of a unit motion of the axis on the observation; q: the
places, even or not. P is the sum of squares that a sine and a cosine take away (Lomb, Astrophys. Space Sci. 39 (1976) 447; Scargle,
Astrophys. J. 263 (1982) 835), worth -dof / 2 ln(1 - P / sum of squares) nats. It is made by one FFT of the rows in bins an eighth of the
shortest wave wide, of v and, at 2 f, of M; from a wave that is twice as fine as the finest usual one, or from what rows on a lattice can tell.

The highest lines become options at their best period. The price of having looked elsewhere is simulated: nats of the highest line of M independent
ones, in noise alone, are ln M plus a Gumbel variable of mean 0.5772 and standard deviation 1.28, so the mean of FEWEST of them less 0.5772 is ln M to 0.3.
Of a wide spectrum the lowest ENOUGH_FREQUENCIES frequencies are simulated. A band c times as wide holds c times as many lines, and nats of a line in noise are
exponential of mean b (1, less what nuisance and calibration take), so the highest of it has b ln c more.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vcmm.answer.evaluation.gaussian import Ints, Whitener, without_span
from vcmm.core.effect import Effect, parameter_fields
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import Option
from vcmm.learn.diagnosis.constants import FEWEST, LEAST_FRACTION, MOST_SHAPES, SAME_SHARE, UNSEEN
from vcmm.learn.diagnosis.evidence import Dictionary
from vcmm.learn.diagnosis.periods import MOST_BINS, NEAR_PERIODS, TURNS, coordinate, shortest_period
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.refine import Refiner, at_value, scanned_names
from vcmm.learn.diagnosis.scans import turns_round
from vcmm.learn.diagnosis.select import (
    SelectedTerm,
    Selection,
    Setting,
    all_but_one,
    conditional_evidence,
    family_scores,
    terms_basis,
)

FINER = 2.0  # times finer than the finest usual period: what is looked at
GRID = 0.5  # of 1 / range: a trial period that is closer is on the line already


@dataclass(frozen=True, eq=False)
class Spectrum:
    """Frequencies (k,) and, of rows (m,), what they need: bins, factor D, whitener."""

    frequency: Array
    band: slice
    bins: Ints
    factor: Array
    white: Whitener
    points: int
    length: float
    cc: Array  # M of every frequency: cos cos, sin sin, cos sin
    ss: Array
    cs: Array

    def nats(self, r: Array) -> Array:
        """Return the nats (k,) of a wave of each frequency in a white residual r (m,)."""
        z = self.white.adjoint(r) * self.factor
        turned = np.fft.rfft(np.bincount(self.bins, z, minlength=self.points))[self.band]
        c, s = turned.real, -turned.imag
        taken = (self.ss * c**2 + self.cc * s**2 - 2.0 * self.cs * c * s) / (self.cc * self.ss - self.cs**2)
        share = np.clip(taken / max(float(r @ r), LEAST_FRACTION), 0.0, 1.0 - UNSEEN)
        return np.asarray(-0.5 * self.white.dof * np.log1p(-share))

    @cached_property
    def price(self) -> float:
        """The logarithm of the number of independent lines, by simulation."""
        rng = np.random.default_rng(0)
        low = self.lowest()
        highest, mean = [], []
        for _ in range(FEWEST):
            x = rng.standard_normal(len(self.factor))
            nats = low.nats(x - self.white.nuisance @ (self.white.nuisance.T @ x))
            highest.append(float(nats.max()))
            mean.append(float(nats.mean()))
        further = float(np.mean(mean) * np.log(len(self.frequency) / len(low.frequency)))
        return max(float(np.mean(highest)) + further - float(np.euler_gamma), 0.0)

    def lowest(self) -> Spectrum:
        """Return the lowest ENOUGH_FREQUENCIES frequencies, in bins that are wider by as much; all where they are no more."""
        wider = 1 << max(int(np.log2(len(self.frequency) / ENOUGH_FREQUENCIES)), 0)
        if wider == 1:
            return self
        count = len(self.frequency) // wider
        return replace(
            self, frequency=self.frequency[:count], band=slice(self.band.start, self.band.start + count),
            bins=np.round(self.bins / wider).astype(np.intp), points=self.points // wider,
            cc=self.cc[:count], ss=self.ss[:count], cs=self.cs[:count],
        )  # fmt: skip


def highest_lines(
    template: Option,
    r: Array,
    basis: Array,
    refine: Refiner,
    floor: float,
    trial_periods: Sequence[float],
    most: int,
) -> list[tuple[Option, float]]:
    """Return the highest lines that no trial period covers, as options, and ln of their share of all lines.

    r (m,): white residual outside `basis`; floor: nats that a line must have beyond its price; trial_periods: how many of each lie
    within the range of the places.
    """
    spectrum = _spectrum_of(template, refine)
    if spectrum is None:
        return []
    nats = spectrum.nats(r)
    if float(nats.max()) <= floor:
        return []
    price = spectrum.price
    out: list[tuple[Option, float]] = []
    taken = [periods / spectrum.length for periods in trial_periods]
    for k in np.argsort(-nats)[: MOST_SHAPES * FEWEST]:
        f = float(spectrum.frequency[k])
        if nats[k] <= floor + price or len(out) == most:
            break
        if any(abs(f - other) * spectrum.length < GRID for other in taken):
            continue
        option = at_value(template, "period", 1.0 / f, refine.problem)
        if option is not None:
            out.append((option, -price))
            taken.append(f)
    return out


def _spectrum_of(template: Option, refine: Refiner) -> Spectrum | None:
    """Return the spectrum, made once for all answers that are compared under one preparation of the noise."""
    effect = template.effect
    if effect is None:
        return None
    if effect.id not in refine.spectra:
        refine.spectra[effect.id] = spectrum_of(effect, refine.problem, refine.white)
    return refine.spectra[effect.id]


def spectrum_of(effect: Effect, problem: Problem, white: Whitener) -> Spectrum | None:
    """Return the frequencies of one wave on the rows of a problem; None where it has none to be searched."""
    q = coordinate(effect, problem.run)
    if q is None or turns_round(effect) or (problem.recording.other >= 0).any():
        return None
    spec = next(f for f in parameter_fields(effect) if f.name == "period")
    finest = min(spec.metadata["scan"]) / FINER
    at = problem.per_observation(q)
    length = float(np.ptp(at))
    highest = min(1.0 / shortest_period(q, finest), MOST_BINS * NEAR_PERIODS / max(length, LEAST_FRACTION))
    if length <= 0 or highest * length <= TURNS + 1:
        return None
    width = NEAR_PERIODS / highest
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
    cs = np.clip(-0.5 * twice.imag, -SAME_SHARE * np.sqrt(cc * ss), SAME_SHARE * np.sqrt(cc * ss))
    return Spectrum(frequency[kept], kept, bins, factor, white, points, length, cc, ss, cs)


def _factor(effect: Effect, problem: Problem, at: Array) -> Array:
    """Return the effect of a unit motion of the axis on the observation (m,): D of D sin and D cos; at (m,): the places."""
    sine, cosine = problem.columns(effect, ["sine", "cosine"]).T
    phase = 2.0 * np.pi * int(getattr(effect, "harmonic", 1)) / float(getattr(effect, "period"))  # noqa: B009
    return np.asarray(sine * np.sin(phase * at) + cosine * np.cos(phase * at))


MOST_COMPETITORS = 6  # competitors that are looked at, given some terms
LINES = 3  # of a spectrum whose best values are searched: the highest on the grid may be a side lobe
ENOUGH_FREQUENCIES = 2**12  # frequencies whose highest line is simulated
LINE_SPACING = 0.75  # of 1 / range: two trial frequencies that are closer stand on one line
SharpOption = tuple[int, Option, float]  # family, option at its best, ln weight within the family


def sharpen(setting: Setting, state: Selection) -> Setting:
    """Return the setting with further options; the same one where no competitor has a value to be searched."""
    if not setting.candidates.families:
        return setting
    new: dict[tuple[int, str, tuple[float, ...]], SharpOption] = {}
    for given in ([], *all_but_one(state.terms)):
        for sharp in _of_competitors(given, setting, state):
            values = tuple(
                round(float(np.log(getattr(sharp[1].effect, n))), 2) for n in scanned_names(sharp[1])
            )
            new.setdefault((sharp[0], type(sharp[1].effect).__name__, values), sharp)
    return replace(setting, candidates=_extend_dictionary(setting, list(new.values()))) if new else setting


def _of_competitors(given: Sequence[SelectedTerm], setting: Setting, state: Selection) -> list[SharpOption]:
    options = conditional_evidence(given, state, setting)
    scores = family_scores(setting.candidates, options)
    taken = {t.family.id for t in given}
    order = [int(j) for j in np.argsort(-scores, kind="stable") if scores[j] > setting.threshold]
    families = [
        j
        for j in order
        if setting.candidates.families[j].id not in taken and _has_scans(setting.candidates, j)
    ]
    basis = terms_basis(given, len(state.y))
    r = without_span(state.y, basis)
    listed = [s for j in families[:MOST_COMPETITORS] for s in _of_family(j, options, r, basis, setting)]
    waves = [j for j in range(len(scores)) if setting.candidates.families[j].id not in taken]
    return listed + [s for j in waves for s in _off_the_list(j, r, basis, setting)]


def _off_the_list(j: int, r: Array, basis: Array, setting: Setting) -> list[SharpOption]:
    """Return the highest lines of the spectrum that no trial period of a family covers, at their best values."""
    options = [setting.candidates.options[k] for k in setting.candidates.of_family(j)]
    wave = next((o for o in options if _is_wave(o)), None)
    if wave is None:
        return []
    refine = setting.refine
    frequencies = [f for o in options if (f := _frequency(o, setting)) is not None]
    lines = highest_lines(wave, r, basis, refine, setting.threshold, frequencies, LINES)
    sharp = [(refine(option, r, basis), weight) for option, weight in lines]
    return [(j, option, weight + refine.open_share(option, r, basis)) for option, weight in sharp]


def _is_wave(option: Option) -> bool:
    """Return whether an option is a sine and a cosine of one period that is to be searched, once per period."""
    effect = option.effect
    single = effect is not None and {"sine", "cosine"} <= {f.name for f in parameter_fields(effect)}
    return single and "period" in scanned_names(option) and int(getattr(effect, "harmonic", 1)) == 1


def _has_scans(candidates: Dictionary, j: int) -> bool:
    return any(scanned_names(candidates.options[k]) for k in candidates.of_family(j))


def _of_family(j: int, options: Array, r: Array, basis: Array, setting: Setting) -> list[SharpOption]:
    """Return the best options of every shape of a family, at their best values: one, or of a spectrum the highest lines."""
    candidates = setting.candidates
    shapes: dict[str, list[int]] = {}
    for k in sorted(candidates.of_family(j), key=lambda k: -float(options[k])):
        if scanned_names(candidates.options[k]):
            shapes.setdefault(type(candidates.options[k].effect).__name__, []).append(k)
    out = []
    for k in (k for members in shapes.values() for k in _lines(members, setting)):
        option = setting.refine(candidates.options[k], r, basis)
        out.append((j, option, float(candidates.weight[k]) + setting.refine.open_share(option, r, basis)))
    return out


def _lines(members: Sequence[int], setting: Setting) -> list[int]:
    """Return, of options in the order of their evidence, the first, and of waves the first on LINES different lines."""
    kept: list[int] = []
    for k in members:
        wave = _frequency(setting.candidates.options[k], setting)
        others = [_frequency(setting.candidates.options[i], setting) for i in kept]
        if not kept or (
            wave is not None and all(o is not None and abs(wave - o) > LINE_SPACING for o in others)
        ):
            kept.append(k)
        if len(kept) == LINES or wave is None:
            break
    return kept


def _frequency(option: Option, setting: Setting) -> float | None:
    """Return the periods within the range of the places; None where the option has none to be searched."""
    if option.effect is None or "period" not in scanned_names(option):
        return None
    q = coordinate(option.effect, setting.refine.problem.run)
    period = float(getattr(option.effect, "period")) / int(getattr(option.effect, "harmonic", 1))  # noqa: B009
    return None if q is None else float(np.ptp(q)) / period


def _extend_dictionary(setting: Setting, new: Sequence[SharpOption]) -> Dictionary:
    """Return the dictionary with further options, each beside the others of its family."""
    candidates = setting.candidates
    options: list[Option] = []
    columns: list[Array] = []
    weight: list[float] = []
    first: list[int] = []
    for j in range(len(candidates.families)):
        first.append(len(options))
        members = candidates.of_family(j)
        options += [candidates.options[k] for k in members]
        weight += [float(candidates.weight[k]) for k in members]
        stop = (
            int(candidates.start[members[-1] + 1])
            if members[-1] + 1 < len(candidates.start)
            else candidates.white.shape[1]
        )
        columns.append(candidates.white[:, int(candidates.start[members[0]]) : stop])
        for _, option, share in (s for s in new if s[0] == j):
            options.append(option)
            weight.append(share)
            columns.append(setting.white.apply(option.columns))
    widths = [o.columns.shape[1] for o in options]
    start: Ints = np.cumsum([0, *widths])[:-1].astype(np.intp)
    families = tuple(
        replace(f, options=tuple(options[k] for k in range(a, b)))
        for f, a, b in zip(candidates.families, first, [*first[1:], len(options)])
    )
    return replace(
        candidates, families=families, options=tuple(options), white=np.concatenate(columns, axis=1), start=start,
        first=np.array(first, dtype=np.intp), weight=np.array(weight),
    )  # fmt: skip
