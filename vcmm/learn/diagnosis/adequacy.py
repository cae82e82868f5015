"""Is what the named terms leave white? If not: where and what shape. A proposal, not a name."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener, best_width
from vcmm.core.run import Array
from vcmm.learn.diagnosis.discrepancy import shape_of
from vcmm.learn.diagnosis.evidence import Dictionary, orthonormal, scorer
from vcmm.learn.diagnosis.formula import propose
from vcmm.learn.diagnosis.holdout import Fold
from vcmm.learn.diagnosis.locate import Place, locate
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.result import Unknown
from vcmm.learn.diagnosis.select import Selection, Setting, mismatch


def unknown_rest(
    generic: Dictionary, selection: Selection, white: Whitener, chance: Array, threshold: float
) -> Unknown | None:
    """Model-free shapes on the residual, given the chosen terms; None where none exceeds the null's threshold."""
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
    """A covariate without the word for its shape: X (periodic) -> X."""
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
    """A family of shapes in words, fitted outside `basis`."""
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
    """The same with the fitted shape and, where one pays for its search and extrapolates, a formula."""
    if rest is None or not rest.drawn:
        return rest
    whites = [t.white for t in selection.terms]
    basis = orthonormal(np.concatenate([np.zeros((problem.m, 0)), *whites], axis=1))
    white = setting.white
    shape = shape_of(problem, white, selection, rest.covariates, rest.direction, rest.pair, basis)
    formula = propose(problem, setting, selection, rest.covariates, rest.direction, parts, basis)
    rest = replace(rest, shape=shape)
    return rest if formula is None else replace(rest, formula=formula.text, gain=formula.gain)
