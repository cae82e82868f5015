"""Test whether the residual of the named terms is white; if not, propose place and shape, without a name.

A sparse formula for physics outside the catalogue: a proposal, not physics.

A small library over at most three localised covariates (powers, harmonics of an angle, sines, one smooth step or bump,
and products of two) is weighed by evidence; the number of candidates is paid for (look-elsewhere), and a formula must
predict rows that lie beyond those it was fitted on, or it is not shown.
"""

from __future__ import annotations

import itertools
from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import SCALES, Whitener, best_width, blocks, log_evidence, without_span
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import Family, Option
from vcmm.learn.diagnosis.constants import MISMATCH, STRONG
from vcmm.learn.diagnosis.discrepancy import is_angle, shape_of, values_of
from vcmm.learn.diagnosis.evidence import Dictionary, orthonormal, scorer
from vcmm.learn.diagnosis.holdout import Fold, gate, judge
from vcmm.learn.diagnosis.locate import Place, locate, modulators
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.result import Unknown
from vcmm.learn.diagnosis.scans import spectral_lines
from vcmm.learn.diagnosis.select import Selection, Setting, Term, joint, mismatch


def unknown_rest(
    generic: Dictionary, selection: Selection, white: Whitener, chance: Array, threshold: float
) -> Unknown | None:
    """Return model-free shapes on the residual, given the chosen terms; None where none exceeds the null's threshold."""
    chosen = np.concatenate([t.white for t in selection.terms], axis=1) if selection.terms else None
    given = scorer(generic, chosen)
    if not generic.families:
        return None
    options = given.options(selection.y[:, None])
    scores = given.families(options)[:, 0]
    if scores.max() <= threshold + mismatch(selection):
        return None
    places = locate(given, selection.y, chance)
    best = int(np.argmax(scores))
    return described_shape(generic, given.basis, selection, white, places, best, options[:, 0])


def plain(name: str) -> str:
    """Return a covariate without the word for its shape: X (periodic) -> X."""
    return name.split(" (")[0]


def described_shape(
    generic: Dictionary,
    basis: Array,
    selection: Selection,
    white: Whitener,
    places: tuple[Place, ...],
    best: int,
    options: Array,
) -> Unknown:
    """Return a family of shapes in words, fitted outside `basis`."""
    stop = generic.first[best + 1] if best + 1 < len(generic.first) else len(generic.options)
    part = slice(int(generic.first[best]), int(stop))
    option = int(generic.first[best] + np.argmax((options + generic.weight)[part]))
    x = generic.columns(option)
    x = x - basis @ (basis.T @ x)
    fit = best_width(x, selection.y, generic.dof)
    signal = x @ fit.mean
    rms = float(np.sqrt(np.mean((signal / white.weight) ** 2)))
    family = generic.families[best]
    names = tuple(dict.fromkeys([family.name, *(p.covariate for p in places)]))[:3]
    covariates = tuple(dict.fromkeys(plain(c) for n in names for c in n.split(" and ")))
    along = "along the normal" if family.where["direction"] == "normal" else f"in {family.where['direction']}"
    words = f"a dependence on {family.name} {along} that no effect of the catalogue explains"
    return Unknown(covariates[:3], words, rms, family.where["direction"], " and " in family.name)


def describe_shape(
    rest: Unknown | None, problem: Problem, setting: Setting, selection: Selection, parts: Sequence[Fold]
) -> Unknown | None:
    """Return the same with the fitted shape and, where one pays for its search and extrapolates, a formula."""
    if rest is None or not rest.drawn:
        return rest
    whites = [t.white for t in selection.terms]
    basis = orthonormal(np.concatenate([np.zeros((problem.m, 0)), *whites], axis=1))
    white = setting.white
    shape = shape_of(problem, white, selection, rest.covariates, rest.direction, rest.pair, basis)
    formula = propose(problem, setting, selection, rest.covariates, rest.direction, parts, basis)
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
    term: Term


def propose(
    problem: Problem,
    setting: Setting,
    selection: Selection,
    names: Sequence[str],
    direction: str,
    parts: Sequence[Fold],
    basis: Array,
) -> Formula | None:
    """Return the best formula for the residual of the named terms, or None where none pays for its search or none extrapolates."""
    factor = modulators(problem).get(direction, np.ones(problem.m))
    rest, formula, size = selection.rest, None, float(np.median(problem.u))
    chosen: list[Atom] = []
    for _ in range(MOST_ATOMS):
        best = _best(
            problem, setting, names, factor * size, rest, _with(basis, chosen, setting, factor * size)
        )
        if best is None:
            break
        term = _term([*chosen, best], factor * size, setting)
        longer = joint([*selection.terms, term], setting)
        if len(selection.terms) in gate(problem, parts, longer):
            break
        gains = [judge(problem, p, longer, longer.terms).gain - _without(problem, p, longer) for p in parts]
        if gains and sum(gains) <= 0:
            break
        chosen.append(best)
        text = _formula_text(chosen, longer, direction, size, problem.recording.kind)
        formula = Formula(text, float(sum(gains)), term)
    return formula


def _without(problem: Problem, part: Fold, longer: Selection) -> float:
    return judge(problem, part, longer, longer.terms[:-1]).gain


def _with(basis: Array, chosen: Sequence[Atom], setting: Setting, factor: Array) -> Array:
    if not chosen:
        return basis
    from vcmm.learn.diagnosis.evidence import orthonormal

    columns = [setting.white.apply(a.columns * factor[:, None]) for a in chosen]
    return orthonormal(np.concatenate([basis, *columns], axis=1))


def _term(atoms: Sequence[Atom], factor: Array, setting: Setting) -> Term:
    columns = np.concatenate([a.columns for a in atoms], axis=1) * factor[:, None]
    texts = tuple(t for a in atoms for t in a.texts)
    option = Option(None, columns, np.ones(columns.shape[1]), texts, 0.0)
    return Term(Family("formula", {}, (option,)), option, setting.white.apply(columns), SCALES[-2])


def _best(
    problem: Problem, setting: Setting, names: Sequence[str], factor: Array, rest: Array, basis: Array
) -> Atom | None:
    """Return the atom or product of highest evidence, if it is STRONG more than the search costs."""
    lists = [_atoms(problem, n) for n in names]
    singles = [a for atoms in lists for a in atoms]
    if not singles:
        return None
    scores = _scores(singles, setting, factor, rest, basis)
    short = [_shortlist(atoms, singles, scores) for atoms in lists]
    products = [_product(a, b) for p, q in itertools.combinations(short, 2) for a in p for b in q]
    everything = singles + products
    both = np.concatenate([scores, _scores(products, setting, factor, rest, basis)])
    top = int(np.argmax(both))
    return everything[top] if both[top] - np.log(len(everything)) > STRONG else None


def _shortlist(atoms: Sequence[Atom], singles: Sequence[Atom], scores: Array) -> list[Atom]:
    """Return powers and harmonics, and the few best of the sines, from which products are made."""
    plain = [a for a in atoms if a.order <= HARMONICS]
    score = {id(a): s for a, s in zip(singles, scores)}
    waves = sorted((a for a in atoms if a.order > HARMONICS), key=lambda a: -score[id(a)])[:BEST]
    return plain + waves


def _scores(atoms: Sequence[Atom], setting: Setting, factor: Array, rest: Array, basis: Array) -> Array:
    if not atoms:
        return np.zeros(0)
    columns = np.concatenate([a.columns for a in atoms], axis=1) * factor[:, None]
    start = np.cumsum([0, *(a.columns.shape[1] for a in atoms)])[:-1].astype(np.intp)
    white = without_span(setting.white.apply(columns), basis)
    return log_evidence(blocks(white, start), rest[:, None], setting.found.dof)[:, 0]


def _atoms(problem: Problem, name: str) -> list[Atom]:
    values = values_of(problem, name)
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


def _product(a: Atom, b: Atom) -> Atom:
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
    along = "along the normal" if direction == "normal" else f"in {direction}"
    return f"({' '.join(terms)}) {along}"
