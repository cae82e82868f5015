"""One search: everything that depends on the noise preparation, the null, and the explanations by mistakes and effects.

Outliers enter the comparison of answers at their full cost.

Rows beyond `clip` robust standard deviations of a fit are limited to it, so that a few bad readings do not bend the fit. Limits about a fit
that lacks a name hide the name: a bed that becomes hot within the first readings shows in a dozen rows alone, and beside
a frame with two lags all of them are outliers. Limits about a fit to the rows as they are may create a name: two bad
readings before the end look like a step. A limited row costs c^2 / 2 nats at any distance, so evidence computed from limited
rows compares different rows. Here every row counts as it is, by the t law of HEAVY degrees of freedom (the heaviest tails
considered, in which an outlier costs the logarithm of its size), with the scale of the noise at its best:

    loss = min over s of  dof ln s + dof / m * sum of (h + 1) / 2 ln(1 + (r / s)^2 / (h - 2))

h - 2 in place of h, as s is the standard deviation (Lange, Little & Taylor, J. Am. Stat. Assoc. 84 (1989) 881).

One outlying reading that a name explains, while it explains little of the others (the first reading, by a lag of half a minute), is
either a bad reading or the effect of that name, and no other row decides between them: its distance is no evidence. So a name that is found
only with rows as they are must have enough evidence without the one row that supports it most.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import Catalogue, Family
from vcmm.learn.diagnosis.constants import FALSE_ALARM, FEW, HEAVY, LEAST_FRACTION, SIMPLER, STRONG
from vcmm.learn.diagnosis.evidence import Dictionary, Scorer, dictionary, scorer
from vcmm.learn.diagnosis.log_mistakes import MISTAKE, Mistake
from vcmm.learn.diagnosis.mistakes import factor_fits, find_mistake, generalises
from vcmm.learn.diagnosis.noise import Audit
from vcmm.learn.diagnosis.null_recordings import Noise, clip_residuals, draw_null_recordings, upper_quantile
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.refine import Refiner
from vcmm.learn.diagnosis.select import (
    SelectedTerm,
    Selection,
    Setting,
    clean_outliers,
    fewest_numbers,
    fit_jointly,
    net_evidence,
    refit,
    refit_in_dictionary,
    select,
)
from vcmm.learn.diagnosis.sharpen import sharpen

RECORDINGS = 400  # simulated
SPAN = 40.0  # of ln s that is searched
HALVINGS = 60  # of it


def heavy_loss(r: Array, dof: int) -> float:
    """Return the nats, up to a constant of the recording, that white residuals r (m,) cost at the best scale of the noise.

    Rows that are all zero, which no scale describes, cost -inf.
    """
    return float(np.sum(heavy_losses(r, dof))) if r.any() else -np.inf


def heavy_losses(r: Array, dof: int) -> Array:
    """Return the same of every row (m,), not all of them zero.

    At the best scale the mean of (h + 1) x^2 / (h - 2 + x^2) is one, x = r / s: it falls with s, so it is halved.
    """
    square = r**2
    high = float(np.log(square.mean() * (HEAVY + 1) / (HEAVY - 2))) / 2  # the largest: _pull is concave
    low = high - SPAN
    for _ in range(HALVINGS):
        middle = (low + high) / 2
        low, high = (middle, high) if _scale_pull(square / np.exp(2 * middle)) > 1 else (low, middle)
    far = np.log1p(square / np.exp(2 * high) / (HEAVY - 2))
    return np.asarray(dof / len(r) * (high + (HEAVY + 1) / 2 * far))


def _scale_pull(x: Array) -> float:
    """Return how much rows of squared size x (m,), in squared scales, widen the scale: one where it is at its best."""
    return float(np.mean((HEAVY + 1) * x / (HEAVY - 2 + x)))


def evidence_of_all_rows(state: Selection, setting: Setting) -> float:
    """Return the nats of all terms together, each having paid the threshold, with every row as it is; up to a constant of the recording."""
    dof = setting.candidates.dof
    if state.fit is None:
        return -heavy_loss(setting.raw, dof)
    fitted = 0.5 * dof * float(np.log(state.fit.sigma**2 * dof / (state.y @ state.y)))
    return net_evidence(state, setting) + fitted - heavy_loss(_residual(state, setting), dof)


def largest_row_support(state: Selection, setting: Setting, plain: Selection) -> float:
    """Return the nats of the row that supports an answer most and contradicts a plain one, every row as it is."""
    dof = setting.candidates.dof
    rests = [_residual(s, setting) for s in (plain, state)]
    if not all(r.any() for r in rests):
        return 0.0
    before, after = (heavy_losses(r, dof) for r in rests)
    return float(np.max(before - after))


def _residual(state: Selection, setting: Setting) -> Array:
    """Return white rows (m,) less the terms, without limits on outliers."""
    if state.fit is None:
        return setting.raw
    return np.asarray(setting.raw - np.concatenate([t.white for t in state.terms], axis=1) @ state.fit.mean)


def outlier_cost(state: Selection, setting: Setting) -> float:
    """Return the nats by which the limited rows cost more as they are, at the scale of the noise of the other rows."""
    return _outlier_excess(_residual(state, setting), state.rest, setting.candidates.dof, setting.clip)


def heavy_tail_allowance(setting: Setting) -> float:
    """Return the outlier cost that all but 1 % of recordings with heavy tails (the t law of HEAVY degrees of freedom) stay below."""
    dof, clip = setting.candidates.dof, setting.clip
    sample = draw_null_recordings(Noise(HEAVY), setting.white, 0, "what heavy tails owe", RECORDINGS)
    near = clip_residuals(sample, setting.white, clip)
    return upper_quantile(np.array([_outlier_excess(r, y, dof, clip) for r, y in zip(sample.T, near.T)]))


def _outlier_excess(r: Array, near: Array, dof: int, clip: float) -> float:
    """Return the sum of clip (|r| / sigma - clip) over the rows beyond the limit: r (m,) as it is; near (m,) limited, which gives sigma."""
    sigma = max(float(np.sqrt(near @ near / dof)), LEAST_FRACTION)
    return float(np.sum(clip * np.maximum(np.abs(r) / sigma - clip, 0.0))) if np.isfinite(clip) else 0.0


NULL_RECORDINGS = 1000  # null recordings of a long one: ten beyond a false alarm of 1 %


@dataclass(frozen=True, eq=False)
class Stage:
    """Everything that depends on the noise preparation."""

    white: Whitener
    u: Array
    noise: Audit
    candidates: Dictionary
    generic: Dictionary
    threshold: float
    generic_threshold: float
    chance: Array  # largest generic score of every null recording
    sample: Array  # the null recordings themselves, white and prepared
    screen: Stage | None = (
        None  # of a long recording, that of the rows in which the whole catalogue was searched
    )


def build_stage(
    problem: Problem,
    catalogue: Catalogue,
    generics: Sequence[Family],
    noise: Audit,
    seed: int,
    nulls: int,
    screen: Stage | None = None,
) -> Stage:
    """Return whitener, dictionaries and thresholds under the noise that the audit found.

    What the largest of so many candidates reaches by chance hardly depends on the number of rows: a long recording takes the
    thresholds of its screen.
    """
    u = noise.u(problem)
    white = problem.whitener(u, noise.rho)
    candidates, generic = dictionary(catalogue.families, white), dictionary(generics, white)
    sample = draw_null_recordings(
        noise.noise, white, seed, "null", nulls if screen is None else min(nulls, NULL_RECORDINGS)
    )
    sample = clip_residuals(sample, white, noise.noise.clip)
    if screen is not None:
        return replace(
            screen,
            white=white,
            u=u,
            noise=noise,
            candidates=candidates,
            generic=generic,
            sample=sample,
            screen=screen,
        )
    largest, chance = _largest_scores(scorer(candidates), sample), _largest_scores(scorer(generic), sample)
    return Stage(
        white,
        u,
        noise,
        candidates,
        generic,
        max(upper_quantile(largest, FALSE_ALARM), 1.0),
        max(upper_quantile(chance, FALSE_ALARM), 1.0),
        chance,
        sample,
    )


def _largest_scores(given: Scorer, sample: Array) -> Array:
    if not given.candidates.families:
        return np.zeros(sample.shape[1])
    return given.largest(sample)


def setting_of(problem: Problem, stage: Stage) -> Setting:
    """Return the setting of the selection."""
    return setting_under(problem, stage, stage.white)


def setting_under(problem: Problem, stage: Stage, white: Whitener) -> Setting:
    """Return the same with another whitener, that of another calibration."""
    raw = white.apply(problem.residual)
    return Setting(
        stage.candidates, white, raw, stage.noise.noise.clip, stage.threshold, Refiner(problem, white)
    )


@dataclass(frozen=True, eq=False)
class SearchResult:
    """Result of the search. problem: repaired; stage: with options at the best values of the competitors; mistake_rivals: ids of terms
    that a mistake of the table may explain."""

    selection: Selection
    mistake: Mistake | None
    problem: Problem
    stage: Stage
    mistake_rivals: tuple[str, ...] = ()


def search(problem: Problem, stage: Stage, earlier: Selection | None = None) -> SearchResult:
    """Search mistakes of the table first, then effects. A mistake is kept only while no free effect explains clearly more.

    earlier: findings under another preparation of the noise.
    """
    plain, candidates = search_names(setting_of(problem, stage), earlier)
    stage = replace(stage, candidates=candidates)
    raw = stage.white.apply(problem.residual)
    mistake = find_mistake(problem, stage.white, raw, stage.noise.noise.clip)
    if mistake is None:
        return SearchResult(plain, None, problem, stage)
    repaired = replace(problem, residual=problem.residual - mistake.departure)
    beside = setting_of(repaired, stage)
    with_it, candidates = settle_names(select(clean_outliers(beside)), beside, beside, None)
    if not _has_exact_factor(mistake, stage, with_it):
        return SearchResult(plain, None, problem, stage)
    best, rival = _best_without_mistake(plain, stage)
    lead = (
        mistake.score
        + _evidence(with_it)
        - best
        - stage.threshold * count_extra_names(with_it.terms, plain.terms)
    )
    kept = {t.family.id for t in with_it.terms}
    instead = [t.family for t in plain.terms if t.family.id not in kept]
    is_general = bool(instead) and all(generalises(f.name, MISTAKE) for f in instead)
    if lead < (-STRONG if is_general and len(with_it.terms) < len(plain.terms) else 0.0):
        return SearchResult(
            plain, None, problem, stage, tuple(f.id for f in instead) if lead > -STRONG else ()
        )
    free = tuple(dict.fromkeys(f.name for f in instead)) or rival
    return SearchResult(
        with_it, replace(mistake, lead=lead, free=free), repaired, replace(stage, candidates=candidates)
    )


def count_extra_names(with_it: Sequence[SelectedTerm], plain: Sequence[SelectedTerm]) -> int:
    """Return how many names an answer with a mistake has more than one without: each pays the threshold, and a mistake is a name. Where
    nothing is named without it, the best name is what it is compared with.
    """
    return 1 + len(with_it) - max(len(plain), 1)


def search_names(setting: Setting, earlier: Selection | None) -> tuple[Selection, Dictionary]:
    """Return the names, and the dictionary in which they were found.

    Where rows are limited, the answer depends on the fit about which they are limited: the names found in all rows as they are, zero, or,
    where the cost of the outliers exceeds that of heavy tails, no limit at all. The answers are then compared by the evidence
    of all rows as they are. An answer without limits must not leave outliers that cost more than heavy tails do; an answer
    with names that are not found with limits about zero must have enough evidence without the row that supports it most.
    """
    candidates, rivals = _at_best_values(setting)
    extended = replace(setting, candidates=candidates)
    return settle_names(max(rivals, key=lambda s: net_evidence(s, extended)), extended, setting, earlier)


def settle_names(
    near: Selection, near_setting: Setting, setting: Setting, earlier: Selection | None
) -> tuple[Selection, Dictionary]:
    """Return the names of a first search, or others where its limited rows cost more than the threshold (see `search_names`)."""
    debt = outlier_cost(near, near_setting)
    if max(debt, outlier_cost(fit_jointly((), setting), setting)) <= setting.threshold:
        return near, near_setting.candidates
    plain = select(near_setting)
    if debt <= setting.threshold:
        return (
            plain if _rests_on_one_row(near, near_setting, plain, near_setting) else near
        ), near_setting.candidates
    answers = [(near, near_setting)]
    free = heavy_tail_allowance(setting)
    if debt > free:
        answers += [(s, w) for s, w in _of_every_row(setting, earlier) if outlier_cost(s, w) <= free]
    robust = [(s, w) for s, w in answers if not _rests_on_one_row(s, w, plain, near_setting)]
    best, used = max([*robust, (plain, near_setting)], key=lambda a: evidence_of_all_rows(*a))
    return best, used.candidates


def _rests_on_one_row(state: Selection, setting: Setting, plain: Selection, plain_setting: Setting) -> bool:
    """Return whether an answer names more than a plain one and owes its larger evidence to one row."""
    if not {t.family.id for t in plain.terms} < {t.family.id for t in state.terms}:
        return False
    lead = evidence_of_all_rows(state, setting) - evidence_of_all_rows(plain, plain_setting)
    return lead <= largest_row_support(state, setting, plain)


def _of_every_row(setting: Setting, earlier: Selection | None) -> list[tuple[Selection, Setting]]:
    """Yield names with every row as it is, and the findings of another preparation, tested again."""
    wider, selections = _at_best_values(replace(setting, clip=np.inf))
    wide = replace(setting, candidates=wider, start=setting.raw)
    again = [refit(s.terms, wide) for s in selections]
    kept = {f.id for f in wider.families}
    if earlier is not None and all(t.family.id in kept for t in earlier.terms):
        again.append(refit_in_dictionary(earlier, wide))
    return [(s, wide) for s in again]


def _at_best_values(setting: Setting) -> tuple[Dictionary, list[Selection]]:
    """Return the dictionary with all competitors at their best lags, distances and periods; the names found with it and without.

    A curve of many numbers that explains most at first hides the simple names that together explain more: where one is named,
    the search is also made among names of at most FEW numbers. What is worth no more by SIMPLER nats says the same otherwise.
    """
    setting = clean_outliers(setting)
    plain = select(setting)
    sharp = sharpen(setting, plain)
    selections = [plain] if sharp is setting else [select(sharp), refit_in_dictionary(plain, sharp)]
    if any(fewest_numbers(t.family) > FEW for s in selections for t in s.terms):
        few = select(replace(sharp, most=FEW))
        selections += (
            [few]
            if net_evidence(few, sharp) > max(net_evidence(s, sharp) for s in selections) + SIMPLER
            else []
        )
    return sharp.candidates, selections


def _has_exact_factor(mistake: Mistake, stage: Stage, with_it: Selection) -> bool:
    """Return whether the number of the mistake fits, and not only some multiple of its shape."""
    chosen = np.concatenate([with_it.y[:, None][:, :0], *(t.white for t in with_it.terms)], axis=1)
    return factor_fits(
        stage.white.apply(mistake.departure), with_it.rest, chosen, with_it.sigma(stage.white.dof)
    )


def _best_without_mistake(plain: Selection, stage: Stage) -> tuple[float, tuple[str, ...]]:
    """Return the nats of the best explanation without a mistake, and its name where it is no term: a calibration that is stale by
    an amount too small to be named is still an alternative to a mistake.
    """
    if plain.terms or not stage.candidates.families:
        return _evidence(plain), ()
    scores = scorer(stage.candidates).scores(plain.y[:, None])[:, 0]
    best = int(np.argmax(scores))
    return max(float(scores[best]), 0.0), (stage.candidates.families[best].name,)


def _evidence(selection: Selection) -> float:
    """Return the nats of all chosen terms together, priors included."""
    if selection.fit is None:
        return 0.0
    return selection.fit.log_evidence + sum(t.family.log_prior + t.option.log_prior for t in selection.terms)
