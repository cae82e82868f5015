"""Selection of terms: forward by evidence, joint refit, backward elimination, swaps, and the best subset at the end.

Every term must pay the threshold of the null (nats). A strong effect's template is never exact: what it leaves,
MISMATCH of its size, must not be taken for a second effect, so the threshold grows by (MISMATCH delta)^2 / 2.
An error of a template points anywhere; that one or two names of one number each take all of it and leave the stated noise
is no accident. Names that close the account pay the threshold of the null alone.
"""

from __future__ import annotations

import itertools
from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import (
    SCALES,
    Posterior,
    Whitener,
    best_width,
    left_beside,
    posterior,
    without_span,
)  # fmt: skip
from vcmm.core.effect import parameter_fields
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import Family, Option
from vcmm.learn.diagnosis.constants import CLOSING, DEVIATIONS, MISMATCH, MOST_TERMS, SAME_SHARE, SIMPLER
from vcmm.learn.diagnosis.evidence import Dictionary, dictionary_of_family, orthonormal, scorer
from vcmm.learn.diagnosis.null_recordings import clip_residuals, robust_scale
from vcmm.learn.diagnosis.refine import Refiner


@dataclass(frozen=True, eq=False)
class SelectedTerm:
    """One selected answer: family, option (scans refined), its white columns (m, k), prior width in typical units."""

    family: Family
    option: Option
    white: Array
    width: float = SCALES[2]


@dataclass(frozen=True, eq=False)
class Selection:
    """terms, joint posterior of all their columns, residual y (prepared, white) and its remainder after the terms.

    factor: of the covariance of `fit` over that of clean rows of known scale.
    """

    terms: tuple[SelectedTerm, ...]
    fit: Posterior | None
    y: Array
    rest: Array
    factor: float = 1.0

    def signal(self, i: int) -> Array:
        """Return the white signal (m,) of term i at the fitted coefficients."""
        assert self.fit is not None
        return self.terms[i].white @ self.fit.mean[self.span(i)]

    def span(self, i: int) -> slice:
        at = sum(t.white.shape[1] for t in self.terms[:i])
        return slice(at, at + self.terms[i].white.shape[1])

    def sigma(self, dof: int) -> float:
        """Return the noise over the stated one, after the terms; dof: of the white rows."""
        return self.fit.sigma if self.fit else float(np.sqrt(self.y @ self.y / dof))

    def delta(self, i: int) -> float:
        """Return the size of term i in units of the noise."""
        assert self.fit is not None
        return float(np.linalg.norm(self.signal(i))) / self.fit.sigma


@dataclass(frozen=True, eq=False)
class Setting:
    """Data of the selection. raw (m,): white residual before clipping; start (m,): the same with outliers limited about the names found last;
    refine: continuous search of scans; most: numbers that a name may have.
    """

    candidates: Dictionary
    white: Whitener
    raw: Array
    clip: float
    threshold: float
    refine: Refiner
    start: Array | None = None  # None: raw, outliers pulled in about nothing
    most: int | None = None
    spread: float = 1.0  # further factor of the covariance, of rows that move together


def fit_jointly(terms: Sequence[SelectedTerm], setting: Setting) -> Selection:
    """Refit all terms together; outliers are clipped about the fit, three times. Clipping multiplies the covariance by
    1 / (share of the rows that are not clipped)^2 (Huber, Robust Statistics (1981), 7.6).
    """
    y = clip_residuals(setting.raw, setting.white, setting.clip) if setting.start is None else setting.start
    if not terms:
        return Selection((), None, y, y)
    x = np.concatenate([t.white for t in terms], axis=1)
    width = np.concatenate([np.full(t.white.shape[1], t.width) for t in terms])
    for _ in range(3):
        fit = posterior(x, y, setting.candidates.dof, width)
        signal = x @ fit.mean
        y = signal + clip_residuals(setting.raw - signal, setting.white, setting.clip)
    fit = posterior(x, y, setting.candidates.dof, width)
    rest = setting.raw - x @ fit.mean
    kept = float(np.mean(np.abs(rest) <= setting.clip * robust_scale(rest)))
    factor = setting.spread * _spread(fit, setting.candidates.dof, width) / kept**2
    fit = replace(fit, covariance=factor * fit.covariance)
    return Selection(tuple(terms), fit, y, y - x @ fit.mean, factor)


def _spread(fit: Posterior, dof: int, width: Array) -> float:
    """Return a factor on a covariance: sigma^2 is the sum of squares over the rows, less one for each number that the rows fix.

    A number with prior width w and posterior standard deviation s is fixed by them in the share 1 - (s / (sigma w))^2.
    """
    fixed = float(np.sum(1.0 - np.diag(fit.covariance) / (fit.sigma * width) ** 2))
    return dof / max(dof - fixed, 1.0)


def refit(terms: Sequence[SelectedTerm], setting: Setting, rounds: int = 2) -> Selection:
    """Refit the same names under a setting of their own: scanned values and prior widths found again, one term given the others."""
    now = fit_jointly([replace(t, white=setting.white.apply(t.option.columns)) for t in terms], setting)
    for _ in range(rounds):
        for i in range(len(terms)):
            others = now.terms[:i] + now.terms[i + 1 :]
            new = _adjust_term(now.terms[i], others, now.y, setting)
            now = fit_jointly((*now.terms[:i], new, *now.terms[i + 1 :]), setting)
    return now


def _adjust_term(
    term: SelectedTerm, others: Sequence[SelectedTerm], y: Array, setting: Setting
) -> SelectedTerm:
    """Return a term at its best scanned values and prior width, others projected out."""
    basis = terms_basis(others, len(y))
    r = without_span(y, basis)
    option = setting.refine(term.option, r, basis)
    white = setting.white.apply(option.columns)
    x = without_span(white, basis)
    fits = [posterior(x, r, setting.candidates.dof, np.full(x.shape[1], s)) for s in SCALES]
    return replace(
        term, option=option, white=white, width=SCALES[int(np.argmax([f.log_evidence for f in fits]))]
    )


def refit_in_dictionary(state: Selection, setting: Setting) -> Selection:
    """Return the same terms as families of another dictionary of the same names."""
    by_id = {f.id: f for f in setting.candidates.families}
    return refit([replace(t, family=by_id[t.family.id]) for t in state.terms], setting)


def mismatch(selection: Selection) -> float:
    """Return the nats that template errors of the chosen terms may bring to any other candidate."""
    return sum(0.5 * (MISMATCH * selection.delta(i)) ** 2 for i in range(len(selection.terms)))


def clean_outliers(setting: Setting) -> Setting:
    """Return the setting with outliers limited about the names found in all rows as they are; about zero where none is found."""
    first = select(replace(setting, start=setting.raw))
    return replace(setting, start=first.y) if first.terms else setting


def select(setting: Setting) -> Selection:
    """Return the terms that the recording supports."""
    return _simpler_shapes(best_subset(_forward(fit_jointly((), setting), setting), setting), setting)


def _simpler_shapes(state: Selection, setting: Setting) -> Selection:
    """Replace a name with a lag, distance or period by a shape of fewer numbers where that has more evidence beside the other terms."""
    for i in range(len(state.terms)):
        term, others = state.terms[i], state.terms[:i] + state.terms[i + 1 :]
        shapes = dictionary_of_family(setting.candidates, setting.candidates.families.index(term.family))
        width = term.white.shape[1]
        fewer = np.array([o.columns.shape[1] < width for o in shapes.options])
        if not fewer.any() or not _has_scan(term.option):
            continue
        nats = scorer(shapes, white_columns(others)).options(state.y[:, None])[:, 0] + shapes.weight
        option = shapes.options[int(np.argmax(np.where(fewer, nats, -np.inf)))]
        shapes_tried = (SelectedTerm(term.family, option, option.columns), term)
        new, same = (_adjust_term(t, others, state.y, setting) for t in shapes_tried)
        if _net_evidence((*others, new), state.y, setting) > _net_evidence((*others, same), state.y, setting):
            state = fit_jointly((*state.terms[:i], new, *state.terms[i + 1 :]), setting)
    return state


def _is_one_number(family: Family) -> bool:
    """Return whether a family has one number and no lag, moment or period: a free curve absorbs any error of a template."""
    return min(o.freedom for o in family.options) == 1


def net_evidence(state: Selection, setting: Setting) -> float:
    """Return the nats of all terms together, each having paid the threshold."""
    return _net_evidence(state.terms, state.y, setting)


def _forward(state: Selection, setting: Setting) -> Selection:
    """Add and prune terms until the threshold stops it."""
    states: set[tuple[str, ...]] = set()
    while len(state.terms) < MOST_TERMS and len(setting.candidates.families):
        new = _best_addition(state, setting)
        if new is None:
            return _close_account(state, setting) or state
        state = _prune(fit_jointly((*state.terms, new), setting), setting)
        key = tuple(sorted(t.family.id for t in state.terms))
        if key in states:
            break
        states.add(key)
    return state


def _close_account(state: Selection, setting: Setting) -> Selection | None:
    """Return `state` with the few names of one number that leave the stated noise and nothing beyond; None where none do."""
    if not state.terms or _is_noise(state, setting):
        return None
    for _ in range(min(CLOSING, MOST_TERMS - len(state.terms))):
        new = _best_addition(state, setting, _is_one_number, 0.0)
        if new is None:
            return None
        state = fit_jointly((*state.terms, new), setting)
        if _is_noise(state, setting):
            return state
    return None


def _is_noise(state: Selection, setting: Setting) -> bool:
    """Return whether the residual of the terms is within the 99 % point of the stated noise. Of dof squares the mean varies by sqrt(2 / dof)."""
    dof = setting.candidates.dof
    return float(state.rest @ state.rest) / dof <= 1.0 + DEVIATIONS * float(np.sqrt(2.0 / dof))


def _best_addition(
    state: Selection,
    setting: Setting,
    allowed: Callable[[Family], bool] | None = None,
    allowance: float | None = None,
) -> SelectedTerm | None:
    """Return the name of highest evidence above the threshold and the allowance for templates (by default the mismatch)."""
    options, scores = _competing_scores(state.terms, state, setting)
    if allowed is not None:
        scores[[not allowed(f) for f in setting.candidates.families]] = -np.inf
    best = int(np.argmax(scores))
    if scores[best] <= setting.threshold + (mismatch(state) if allowance is None else allowance):
        return None
    best = _simplest(best, scores, options, state, setting)
    return _term(best, options, state.terms, state, setting)


def _competing_scores(
    given: Sequence[SelectedTerm], state: Selection, setting: Setting
) -> tuple[Array, Array]:
    """Return the nats of all options and of all families beside some terms; -inf for these themselves, and for names with too many numbers."""
    options = conditional_evidence(given, state, setting)
    scores = family_scores(setting.candidates, options)
    taken = {t.family.id for t in given}
    for i, family in enumerate(setting.candidates.families):
        if family.id in taken or (setting.most is not None and fewest_numbers(family) > setting.most):
            scores[i] = -np.inf
    return options, scores


def fewest_numbers(family: Family) -> int:
    """Return the numbers of the simplest shape of a name."""
    return min(o.columns.shape[1] for o in family.options)


def conditional_evidence(given: Sequence[SelectedTerm], state: Selection, setting: Setting) -> Array:
    """Return ln BF (options,) of everything, given some terms."""
    return scorer(setting.candidates, white_columns(given)).options(state.y[:, None])[:, 0]


def family_scores(candidates: Dictionary, options: Array) -> Array:
    """Return the nats (families,), priors included, from those of the options."""
    return np.asarray(np.logaddexp.reduceat(options + candidates.weight, candidates.first) + candidates.prior)


def best_option(candidates: Dictionary, options: Array, family: int) -> int:
    """Return the number of the option of highest evidence within a family."""
    members = candidates.of_family(family)
    return members[int(np.argmax((options + candidates.weight)[members.start : members.stop]))]


def _term(
    family: int, options: Array, given: Sequence[SelectedTerm], state: Selection, setting: Setting
) -> SelectedTerm:
    """Return a term with its scans refined and its prior width chosen, given others; with one lag where a second does not pay.

    A second lag is a second template over the same sensor: like a second name it must pay what the error of the first may
    bring, else it takes what another sensor's lag explains.
    """
    candidates = setting.candidates
    members = candidates.of_family(family)
    best = best_option(candidates, options, family)
    width = candidates.options[best].columns.shape[1]
    shapes = candidates.options
    fewer = [k for k in members if _has_scan(shapes[k]) and shapes[k].columns.shape[1] < width]
    large = _adjust_term(_at_option(candidates, family, best), given, state.y, setting)
    if not fewer or not _has_scan(candidates.options[best]):
        return large
    simple = max(fewer, key=lambda k: float(options[k] + candidates.weight[k]))
    small = _adjust_term(_at_option(candidates, family, simple), given, state.y, setting)
    alone = fit_jointly((*given, small), setting)
    lead = _net_evidence((*given, large), alone.y, setting) - _net_evidence(alone.terms, alone.y, setting)
    return large if lead > 0.5 * (MISMATCH * alone.delta(len(given))) ** 2 else small


def _at_option(candidates: Dictionary, family: int, option: int) -> SelectedTerm:
    return SelectedTerm(
        candidates.families[family], candidates.options[option], candidates.options[option].columns
    )


def _has_scan(option: Option) -> bool:
    """Return whether the shape is one of a lag, a distance or a period."""
    return option.effect is not None and any(f.metadata["scan"] for f in parameter_fields(option.effect))


def white_columns(terms: Sequence[SelectedTerm]) -> Array | None:
    """Return the white columns of terms side by side (m, p); None of no terms."""
    return np.concatenate([t.white for t in terms], axis=1) if terms else None


def all_but_one(terms: Sequence[SelectedTerm]) -> list[list[SelectedTerm]]:
    """Return the terms without each of them in turn; nothing of fewer than two."""
    return [[t for t in terms if t is not term] for term in terms] if len(terms) > 1 else []


def terms_basis(given: Sequence[SelectedTerm], m: int) -> Array:
    """Return the orthonormal basis of the white columns of some terms (m, p)."""
    return orthonormal(np.concatenate([np.zeros((m, 0)), *(t.white for t in given)], axis=1))


def _simplest(best: int, scores: Array, options: Array, state: Selection, setting: Setting) -> int:
    """Return, of nested answers, the one with fewest free numbers, scanned ones among them, that the data cannot refuse."""
    candidates = setting.candidates
    option = [best_option(candidates, options, j) for j in range(len(scores))]
    freedom = np.array([candidates.options[k].freedom for k in option])
    for i in np.argsort(freedom, kind="stable"):
        if scores[i] < scores[best] - SIMPLER or freedom[i] >= freedom[best]:
            continue
        if _holds(candidates.columns(option[best]), candidates.columns(option[i]), state.y, setting):
            return int(i)
    return best


def _holds(large: Array, small: Array, y: Array, setting: Setting) -> bool:
    """Return whether the span of `large` contains the signal that `small` would explain."""
    fit = best_width(small, y, setting.candidates.dof)
    signal = small @ fit.mean
    share = signal - left_beside(signal, large)
    return float(share @ share) >= SAME_SHARE * float(signal @ signal)


def _prune(state: Selection, setting: Setting) -> Selection:
    """Eliminate terms backwards and swap them until nothing changes: an early wrong pick does not survive."""
    for _ in range(2 * MOST_TERMS):
        change = _one_change(state, setting)
        if change is None:
            return state
        state = fit_jointly(change, setting)
    return state


def _one_change(state: Selection, setting: Setting) -> tuple[SelectedTerm, ...] | None:
    if len(state.terms) < 2:
        return None
    for i in range(len(state.terms)):
        others = state.terms[:i] + state.terms[i + 1 :]
        options, scores = _competing_scores(others, state, setting)
        best = int(np.argmax(scores))
        if scores[best] <= setting.threshold:
            return others
        family = setting.candidates.families.index(state.terms[i].family)
        if scores[best] > scores[family] + SIMPLER and best != family:
            return (*others, _term(best, options, others, state, setting))
    return None


def best_subset(state: Selection, setting: Setting) -> Selection:
    """Return, among all subsets of the chosen terms, the one of highest joint evidence, each term paying the threshold."""
    if len(state.terms) < 2:
        return state
    subsets = (s for k in range(len(state.terms) + 1) for s in itertools.combinations(state.terms, k))
    best = max(subsets, key=lambda subset: _net_evidence(subset, state.y, setting))
    return state if len(best) == len(state.terms) else fit_jointly(best, setting)


def _net_evidence(subset: Sequence[SelectedTerm], y: Array, setting: Setting) -> float:
    if not subset:
        return 0.0
    x = np.concatenate([t.white for t in subset], axis=1)
    width = np.concatenate([np.full(t.white.shape[1], t.width) for t in subset])
    prior = sum(t.family.log_prior + t.option.log_prior for t in subset)
    return (
        posterior(x, y, setting.candidates.dof, width).log_evidence + prior - setting.threshold * len(subset)
    )
