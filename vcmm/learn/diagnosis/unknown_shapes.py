"""Test whether the residual of the named terms is white; if not, propose place and shape, without a name.

A sparse formula for physics outside the catalogue: a proposal, not physics.

A small library over at most three localised covariates (powers, harmonics of an angle, sines, one smooth step or bump,
and products of two) is weighed by evidence; the number of candidates is paid for (look-elsewhere), and a formula must
predict rows that lie beyond those it was fitted on, or it is not shown.

Test whether the size of a named term depends on a condition that its law does not contain.

A change of geometry is the same at every speed; a screw's pitch error is the same in the morning. If the fitted signal of
such a term grows with the speed, the time, a temperature or a load, the finding is half of a product: the place is
right, the name is not the whole story. One column is tried per term and condition,

    signal of the term x (condition - mean) / standard deviation,

outside the span of all terms, and the number of columns tried is paid for.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import SCALES, Whitener, best_width, blocks, log_evidence, without_span
from vcmm.core.axes import axis_of, is_axis
from vcmm.core.effect import required
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import Family, Option, first_place
from vcmm.learn.diagnosis.constants import MISMATCH, STRONG, UNSEEN
from vcmm.learn.diagnosis.discrepancy import covariate_values, fit_shape, is_angle
from vcmm.learn.diagnosis.evidence import Dictionary, orthonormal, scorer
from vcmm.learn.diagnosis.holdout import Fold, failing_terms, predict_fold
from vcmm.learn.diagnosis.locate import (
    Place,
    direction_factors,
    direction_text,
    locate,
    path_speed,
    without_unit,
)
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.result import Unknown
from vcmm.learn.diagnosis.scans import spectral_lines
from vcmm.learn.diagnosis.select import (
    SelectedTerm,
    Selection,
    Setting,
    best_option,
    fit_jointly,
    mismatch,
    white_columns,
)


def find_unknown_shape(
    generic: Dictionary, selection: Selection, white: Whitener, chance: Array, threshold: float
) -> Unknown | None:
    """Return model-free shapes on the residual, given the chosen terms; None where none exceeds the null's threshold."""
    given = scorer(generic, white_columns(selection.terms))
    if not generic.families:
        return None
    options = given.options(selection.y[:, None])
    scores = given.families(options)[:, 0]
    if scores.max() <= threshold + mismatch(selection):
        return None
    places = locate(given, selection.y, chance)
    best = int(np.argmax(scores))
    return describe_family(generic, given.basis, selection, white, places, best, options[:, 0])


def covariate_name(name: str) -> str:
    """Return a covariate without the word for its shape: X (periodic) -> X."""
    return name.split(" (")[0]


def describe_family(
    generic: Dictionary,
    basis: Array,
    selection: Selection,
    white: Whitener,
    places: tuple[Place, ...],
    best: int,
    options: Array,
) -> Unknown:
    """Return a family of shapes in words, fitted outside `basis`."""
    x = generic.columns(best_option(generic, options, best))
    x = x - basis @ (basis.T @ x)
    fit = best_width(x, selection.y, generic.dof)
    signal = x @ fit.mean
    rms = float(np.sqrt(np.mean((signal / white.weight) ** 2)))
    family = generic.families[best]
    names = tuple(dict.fromkeys([family.name, *(p.covariate for p in places)]))[:3]
    covariates = tuple(dict.fromkeys(covariate_name(c) for n in names for c in n.split(" and ")))
    along = direction_text(family.where["direction"])
    words = f"a dependence on {family.name} {along} that no effect of the catalogue explains"
    return Unknown(covariates[:3], words, rms, family.where["direction"], " and " in family.name)


def add_shape_and_formula(
    rest: Unknown | None, problem: Problem, setting: Setting, selection: Selection, parts: Sequence[Fold]
) -> Unknown | None:
    """Return the same with the fitted shape and, where one pays for its search and extrapolates, a formula."""
    if rest is None or not rest.is_drawable:
        return rest
    whites = [t.white for t in selection.terms]
    basis = orthonormal(np.concatenate([np.zeros((problem.m, 0)), *whites], axis=1))
    white = setting.white
    shape = fit_shape(problem, white, selection, rest.covariates, rest.direction, rest.pair, basis)
    formula = propose_formula(problem, setting, selection, rest.covariates, rest.direction, parts, basis)
    rest = replace(rest, shape=shape)
    return rest if formula is None else replace(rest, formula=formula.text, gain=formula.gain)


POWERS, HARMONICS, SINES = 3, 6, 40
BEST = 4  # sines of a covariate that enter products
MOST_ATOMS = 2


@dataclass(frozen=True, eq=False)
class Atom:
    """A shape of one covariate: columns (m, k) and its notation, one text per column."""

    covariate: str
    columns: Array
    texts: tuple[str, ...]
    order: float = 1.0


@dataclass(frozen=True, eq=False)
class Formula:
    """text with numbers; rms gained on rows never fitted, in nats; the term itself."""

    text: str
    gain: float
    term: SelectedTerm


def propose_formula(
    problem: Problem,
    setting: Setting,
    selection: Selection,
    names: Sequence[str],
    direction: str,
    parts: Sequence[Fold],
    basis: Array,
) -> Formula | None:
    """Return the best formula for the residual of the named terms, or None where none pays for its search or none extrapolates."""
    factor = direction_factors(problem).get(direction, np.ones(problem.m))
    rest, formula, size = selection.rest, None, float(np.median(problem.u))
    chosen: list[Atom] = []
    for _ in range(MOST_ATOMS):
        best = _best_atom(
            problem, setting, names, factor * size, rest, _with_atoms(basis, chosen, setting, factor * size)
        )
        if best is None:
            break
        term = _formula_term([*chosen, best], factor * size, setting)
        longer = fit_jointly([*selection.terms, term], setting)
        if len(selection.terms) in failing_terms(problem, parts, longer):
            break
        gains = [
            predict_fold(problem, p, longer, longer.terms).gain - _gain_without(problem, p, longer)
            for p in parts
        ]
        if gains and sum(gains) <= 0:
            break
        chosen.append(best)
        text = _formula_text(chosen, longer, direction, size, problem.recording.kind)
        formula = Formula(text, float(sum(gains)), term)
    return formula


def _gain_without(problem: Problem, part: Fold, longer: Selection) -> float:
    return predict_fold(problem, part, longer, longer.terms[:-1]).gain


def _with_atoms(basis: Array, chosen: Sequence[Atom], setting: Setting, factor: Array) -> Array:
    if not chosen:
        return basis
    columns = [setting.white.apply(a.columns * factor[:, None]) for a in chosen]
    return orthonormal(np.concatenate([basis, *columns], axis=1))


def _formula_term(atoms: Sequence[Atom], factor: Array, setting: Setting) -> SelectedTerm:
    columns = np.concatenate([a.columns for a in atoms], axis=1) * factor[:, None]
    texts = tuple(t for a in atoms for t in a.texts)
    option = Option(None, columns, np.ones(columns.shape[1]), texts, 0.0)
    return SelectedTerm(Family("formula", {}, (option,)), option, setting.white.apply(columns), SCALES[-2])


def _best_atom(
    problem: Problem, setting: Setting, names: Sequence[str], factor: Array, rest: Array, basis: Array
) -> Atom | None:
    """Return the atom or product of highest evidence, if it is STRONG more than the search costs."""
    lists = [_atoms(problem, n) for n in names]
    singles = [a for atoms in lists for a in atoms]
    if not singles:
        return None
    scores = _atom_scores(singles, setting, factor, rest, basis)
    short = [_shortlist(atoms, singles, scores) for atoms in lists]
    products = [_atom_product(a, b) for p, q in itertools.combinations(short, 2) for a in p for b in q]
    everything = singles + products
    both = np.concatenate([scores, _atom_scores(products, setting, factor, rest, basis)])
    top = int(np.argmax(both))
    return everything[top] if both[top] - np.log(len(everything)) > STRONG else None


def _shortlist(atoms: Sequence[Atom], singles: Sequence[Atom], scores: Array) -> list[Atom]:
    """Return powers and harmonics, and the few best of the sines, from which products are made."""
    plain = [a for a in atoms if a.order <= HARMONICS]
    score = {id(a): s for a, s in zip(singles, scores)}
    waves = sorted((a for a in atoms if a.order > HARMONICS), key=lambda a: -score[id(a)])[:BEST]
    return plain + waves


def _atom_scores(atoms: Sequence[Atom], setting: Setting, factor: Array, rest: Array, basis: Array) -> Array:
    if not atoms:
        return np.zeros(0)
    columns = np.concatenate([a.columns for a in atoms], axis=1) * factor[:, None]
    start = np.cumsum([0, *(a.columns.shape[1] for a in atoms)])[:-1].astype(np.intp)
    white = without_span(setting.white.apply(columns), basis)
    return log_evidence(blocks(white, start), rest[:, None], setting.candidates.dof)[:, 0]


def _atoms(problem: Problem, name: str) -> list[Atom]:
    values = covariate_values(problem, name)
    if values is None or np.ptp(values) == 0:
        return []
    if is_angle(problem, name):
        return [_wave(name, values, k, f"{k} {name}" if k > 1 else name, k) for k in range(1, HARMONICS + 1)]
    middle, half = float(values.min() + np.ptp(values) / 2), float(np.ptp(values) / 2)
    z, text = (values - middle) / half, f"(({name} - {middle:.4g}) / {half:.4g})"
    out = [Atom(name, (z**k)[:, None], (f"{text}^{k}" if k > 1 else text,), k) for k in range(1, POWERS + 1)]
    if len(np.unique(values)) < 4:
        return out[: max(len(np.unique(values)) - 1, 1)]
    for centre, width in itertools.product((-0.6, -0.2, 0.2, 0.6), (0.15, 0.3, 0.6)):
        bump = np.exp(-(((z - centre) / width) ** 2))
        words = f"exp(-(({name} - {middle + centre * half:.4g}) / {width * half:.3g})^2)"
        out.append(Atom(name, bump[:, None], (words,), 4))
    for p in spectral_lines(values)[:SINES]:
        out.append(_wave(name, values, 2 * np.pi / p, f"2 pi {name} / {p:.4g}", HARMONICS + 1))
    return out


def _wave(name: str, values: Array, k: float, phase: str, order: float) -> Atom:
    columns = np.stack([np.cos(k * values), np.sin(k * values)], axis=1)
    return Atom(name, columns, (f"cos({phase})", f"sin({phase})"), order)


def _atom_product(a: Atom, b: Atom) -> Atom:
    columns = np.concatenate([a.columns * b.columns[:, [j]] for j in range(b.columns.shape[1])], axis=1)
    texts = tuple(f"{x} {y}" for y in b.texts for x in a.texts)
    return Atom(f"{a.covariate} and {b.covariate}", columns, texts, a.order + b.order)


def _formula_text(atoms: Sequence[Atom], longer: Selection, direction: str, size: float, kind: str) -> str:
    """Return the formula with its numbers in um (urad where angles were recorded), largest first."""
    assert longer.fit is not None
    micro = 1e6 if kind == "angle" else 1e3
    numbers = longer.fit.mean[longer.span(len(longer.terms) - 1)] * size * micro
    texts = [t for a in atoms for t in a.texts]
    order = np.argsort(-np.abs(numbers))
    terms = [
        f"{numbers[i]:+.3g} {texts[i]}" for i in order if abs(numbers[i]) > MISMATCH * np.abs(numbers).max()
    ]
    return f"({' '.join(terms)}) {direction_text(direction)}"


CONDITIONS = (
    "time_s",
    "load_kg",
    "pressure_hPa",
    "spindle_rpm",
)  # beside temperatures and the speed on the way
OF_TIME = ("sensor", "tau", "t1", "time", "start")  # fields of effects that follow a log or the clock


def conditions(problem: Problem) -> dict[str, Array]:
    """Name -> values (m,) of what is the same for every place and direction, as far as it varies."""
    run = problem.run
    out = {without_unit(c): run.columns[c] for c in run.columns if c in CONDITIONS or c.startswith("temp_")}
    speed = path_speed(run)
    if speed is not None:
        out["speed"] = speed
    return {name: problem.per_observation(v) for name, v in out.items() if float(np.ptp(v)) > UNSEEN}


def contains_condition(term: SelectedTerm, condition: str) -> bool:
    """Return whether the law of the term contains this condition, or depends on events, a log or the clock so that it is not tested."""
    effect = term.option.effect
    if effect is None or effect.per in ("event", "clamp") or any(hasattr(effect, f) for f in OF_TIME):
        return True
    needed = {without_unit(c) for c in required(effect)}
    if condition == "speed":
        return any(n.startswith(("speed_", "accel_")) for n in needed)
    clock = condition == "time" or condition.startswith("temp_")
    return condition in needed or (clock and any(n == "time" or n.startswith("temp_") for n in needed))


def find_modulation(
    problem: Problem, selection: Selection, white: Whitener, threshold: float
) -> Unknown | None:
    """Return the term and condition of highest evidence, where it exceeds the threshold of shapes without a name."""
    varied = conditions(problem)
    tried = [
        (i, name)
        for i, term in enumerate(selection.terms)
        for name in varied
        if not contains_condition(term, name)
    ]
    if not tried or selection.fit is None:
        return None
    basis = orthonormal(np.concatenate([t.white for t in selection.terms], axis=1))
    columns = np.stack([_signal(selection, i) * _standard(varied[name]) for i, name in tried], axis=1)
    x = without_span(white.apply(columns), basis)
    dof = white.dof - basis.shape[1]
    scores = log_evidence(blocks(x, np.arange(len(tried))), selection.rest[:, None], dof)[:, 0]
    best = int(np.argmax(scores))
    if scores[best] - np.log(len(tried)) <= threshold + mismatch(selection):
        return None
    term, name = selection.terms[tried[best][0]], tried[best][1]
    share = float(x[:, best] @ selection.rest) / float(x[:, best] @ x[:, best])
    words = (
        f"the size of {term.family.id} depends on {name}, which its law does not hold: {share:+.0%} of it per standard"
        f" deviation of {name}"
    )
    rms = abs(share) * float(np.sqrt(np.mean(columns[:, best] ** 2)))
    return Unknown(_covariates(problem, term, name), words, rms)


def _signal(selection: Selection, i: int) -> Array:
    """Return the effect of term i on the observation (m,), mm or rad."""
    assert selection.fit is not None
    return np.asarray(selection.terms[i].option.columns @ selection.fit.mean[selection.span(i)])


def _standard(values: Array) -> Array:
    return np.asarray((values - values.mean()) / values.std())


def _covariates(problem: Problem, term: SelectedTerm, name: str) -> tuple[str, ...]:
    """Return the axis of the term's place, where it has one, and the condition."""
    place = first_place(term.family)
    axis = axis_of(place) or (place if is_axis(place) else place[-1:].upper())
    return (axis, name) if axis in problem.run.position else (name,)
