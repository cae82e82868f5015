"""Judge the chosen terms: which hold, their rivals, and the residual without a name.

A field without a name that is accepted is put beside the calibration, as one more covariance, and the search is made again.

Test whether the size of a named term depends on a condition that its law does not contain.

A change of geometry is the same at every speed; a screw's pitch error is the same in the morning. If the fitted signal of
such a term grows with the speed, the time, a temperature or a load, the finding is half of a product: the place is
right, the name is not the whole story. One column is tried per term and condition,

    signal of the term x (condition - mean) / standard deviation,

outside the span of all terms, and the number of columns tried is paid for.

Test the named terms against the simulator's own null, with no shape assumed, in two ways:

folds    recordings with exactly the fitted terms and the noise found are simulated, and every fold predicts its held-out
         rows from the others; a fold of the real recording that gains far less than they do holds a wrong shape
scatter  the scatter left over, against that of null recordings of the stated noise; an excess that no finding about the
         noise names may be physics that no covariate shows
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import (
    Whitener,
    blocks,
    condition,
    log_density,
    log_evidence,
    without_span,
)
from vcmm.core.axes import axis_of, is_axis
from vcmm.core.effect import required
from vcmm.core.run import Array
from vcmm.learn.diagnosis.adequacy import describe_shape, unknown_rest
from vcmm.learn.diagnosis.answers import of_the_machine
from vcmm.learn.diagnosis.candidates import Catalogue, Family, first_place
from vcmm.learn.diagnosis.confusion import Standing, standing
from vcmm.learn.diagnosis.constants import (
    CHANCE,
    EVEN_ODDS,
    FALSE_ALARM,
    FAR,
    FEW,
    LEAST_SPREAD,
    MISMATCH,
    MOSTLY,
    UNSEEN,
)
from vcmm.learn.diagnosis.evidence import orthonormal
from vcmm.learn.diagnosis.families import by_simplest
from vcmm.learn.diagnosis.field import Field, kept_terms, rival_field
from vcmm.learn.diagnosis.holdout import Fold, folds, gate, is_free_curve, tells, wins_everywhere
from vcmm.learn.diagnosis.kernels import departure
from vcmm.learn.diagnosis.locate import path_speed, short
from vcmm.learn.diagnosis.log_mistakes import Mistake
from vcmm.learn.diagnosis.noise import Audit, chain_noise
from vcmm.learn.diagnosis.problem import FIELD, Problem, generator
from vcmm.learn.diagnosis.result import Unknown
from vcmm.learn.diagnosis.search import SearchResult, Stage, build_stage, search, setting_of
from vcmm.learn.diagnosis.select import Selection, Setting, Term, basis_of, joint, mismatch

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
    out = {short(c): run.columns[c] for c in run.columns if c in CONDITIONS or c.startswith("temp_")}
    speed = path_speed(run)
    if speed is not None:
        out["speed"] = speed
    return {name: problem.of_rows(v) for name, v in out.items() if float(np.ptp(v)) > UNSEEN}


def knows(term: Term, condition: str) -> bool:
    """Does the law of the term hold this condition, or is it not the kind of law that could be held to it?"""
    effect = term.option.effect
    if effect is None or effect.per in ("event", "clamp") or any(hasattr(effect, f) for f in OF_TIME):
        return True
    needed = {short(c) for c in required(effect)}
    if condition == "speed":
        return any(n.startswith(("speed_", "accel_")) for n in needed)
    clock = condition == "time" or condition.startswith("temp_")
    return condition in needed or (clock and any(n == "time" or n.startswith("temp_") for n in needed))


def find_modulation(
    problem: Problem, selection: Selection, white: Whitener, threshold: float
) -> Unknown | None:
    """Return the term and condition of highest evidence, where it exceeds the threshold of shapes without a name."""
    varied = conditions(problem)
    tried = [(i, name) for i, term in enumerate(selection.terms) for name in varied if not knows(term, name)]
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


def _covariates(problem: Problem, term: Term, name: str) -> tuple[str, ...]:
    """Return the axis of the term's place, where it has one, and the condition."""
    place = first_place(term.family)
    axis = axis_of(place) or (place if is_axis(place) else place[-1:].upper())
    return (axis, name) if axis in problem.run.position else (name,)


@dataclass(frozen=True, eq=False)
class Judgement:
    """Terms that hold, and their rivals. failed: terms were held back; thought: all that the search named; tied: see
    Chosen.
    """

    problem: Problem
    stage: Stage
    setting: Setting
    parts: Sequence[Fold]
    selection: Selection
    places: Sequence[Standing]
    mistake: Mistake | None
    tied: tuple[str, ...]
    failed: bool
    field: Field | None = None
    rest: Unknown | None = None
    thought: Sequence[Term] = ()


def judge_terms(chosen: SearchResult, stage: Stage, seed: int, in_field: bool = False) -> Judgement:
    """Return the terms that hold, their probabilities, and a field that may replace them.

    in_field: a field is beside the calibration already. No further shape without physics is weighed, and a fold, in which
    the field is as free again, refuses no term here; terms that make rows worse are still not delivered.
    """
    used, selection = chosen.problem, chosen.selection
    setting = replace(setting_of(used, stage), start=selection.y)
    parts = folds(used, stage.u, stage.noise.rho)
    shapes = None if in_field else stage.generic
    searched, selection = selection, selection if in_field else _gate_terms(used, parts, selection, setting)
    failed = len(selection.terms) < len(searched.terms)
    selection = of_the_machine(selection, _standings(selection, setting), setting)
    places = _standings(selection, setting)
    simple = by_simplest(selection, [p.kin for p in places if p.kin], setting)
    if simple is not selection:
        selection, places = simple, _standings(simple, setting)
    field = rival_field(used, selection, setting, stage.sample, shapes) if selection.terms else None
    rest = _rest(used, stage, selection, setting, parts, seed, field)
    return Judgement(
        used,
        stage,
        setting,
        parts,
        selection,
        places,
        chosen.mistake,
        chosen.tied,
        failed,
        field,
        rest,
        chosen.selection.terms,
    )


def beside_field(
    first: Judgement, known: Catalogue, generics: Sequence[Family], seed: int, nulls: int
) -> Judgement:
    """Search again beside an accepted field, which then is one more covariance; return the first result where this finds nothing, or
    where nothing remains without a name.
    """
    if first.rest is None or not first.thought:
        return first
    field = first.field or rival_field(first.problem, first.selection, first.setting, first.stage.sample)
    if field is None or not field.stands:
        return first
    beside = first.problem.with_statement(FIELD, field.columns)
    stage = build_stage(beside, _simple(known), generics, first.stage.noise, seed, nulls, first.stage.screen)
    chosen = search(beside, stage)
    second = judge_terms(chosen, chosen.stage, seed, in_field=True)
    if not second.selection.terms or _loses_name(first, second) or not _told_before(first, second):
        return first
    what = describe_shape(field.unknown, first.problem, first.setting, joint((), first.setting), first.parts)
    return replace(second, mistake=first.mistake, field=None, rest=what)


def _simple(effects_of_kinds: Catalogue) -> Catalogue:
    """Return the catalogue without names of more numbers than FEW, which are as free as a field."""
    kept = []
    for family in (f for f in effects_of_kinds.families if not is_free_curve(f.name)):
        few = tuple(o for o in family.options if o.columns.shape[1] <= FEW)
        kept += [replace(family, options=few)] if few else []
    return replace(effects_of_kinds, families=tuple(kept))


def _told_before(first: Judgement, second: Judgement) -> bool:
    """Is most of what the second search names what the first one named, perhaps as a curve? A field takes the place of what
    a name has too much; what is new beside it is a shadow of what it leaves out, and names of more numbers than the first
    ones had are one of them in parts.
    """
    if _freedom(second.selection.terms) > _freedom(first.thought):
        return False
    white = first.stage.white
    basis = basis_of(first.thought, first.problem.m)
    fit = second.selection.fit
    assert fit is not None
    for i, term in enumerate(second.selection.terms):
        signal = white.apply(term.option.columns @ fit.mean[second.selection.span(i)])
        if float(np.sum((basis.T @ signal) ** 2)) < MOSTLY * float(signal @ signal):
            return False
    return True


def _freedom(terms: Sequence[Term]) -> int:
    """Free numbers of some names, scanned ones among them."""
    return sum(t.option.freedom for t in terms)


def _loses_name(first: Judgement, second: Judgement) -> bool:
    """Is a name gone that was found and wins all its folds? A free curve may be: it is as free as the field."""
    kept = _probable_ids(second)
    selection = first.selection
    gone = [i for i, t in enumerate(selection.terms) if t.family.id in _probable_ids(first) - kept]
    return any(
        wins_everywhere(first.problem, first.parts, selection, i)
        for i in gone
        if not is_free_curve(selection.terms[i].family.name)
    )


def _probable_ids(judgement: Judgement) -> set[str]:
    """Ids of the names that are more probable than not, with what repeats them exactly; none that a field makes superfluous."""
    refused = judgement.field.refused if judgement.field is not None and judgement.field.stands else ()
    pairs = enumerate(zip(judgement.selection.terms, judgement.places))
    return {t.family.id for i, (t, p) in pairs if i not in refused and p.with_aliases >= EVEN_ODDS}


def _gate_terms(problem: Problem, parts: Sequence[Fold], selection: Selection, setting: Setting) -> Selection:
    """Return the terms that predict rows held out: the one that fails worst is refused, the others are refitted and tested again."""
    while failed := gate(problem, parts, selection):
        selection = joint([t for i, t in enumerate(selection.terms) if i != failed[0]], setting)
    return selection


def _standings(selection: Selection, setting: Setting) -> list[Standing]:
    return [standing(selection, setting, i) for i in range(len(selection.terms))]


def _rest(
    problem: Problem,
    stage: Stage,
    selection: Selection,
    setting: Setting,
    parts: Sequence[Fold],
    seed: int,
    field: Field | None,
) -> Unknown | None:
    """Return the residual without a name: a field that beats the names, a shape in the residual, neighbours that agree, a field beside the names
    that is surer than shapes are in null recordings, else a fold that gains less than the names predict.
    """
    if field is not None and field.wins:
        return describe_shape(
            field.unknown, problem, setting, joint(kept_terms(selection, field), setting), parts
        )
    rest = unknown_rest(stage.generic, selection, stage.white, stage.chance, stage.generic_threshold)
    rest = rest or find_modulation(problem, selection, stage.white, stage.generic_threshold)
    rest = rest or departure(problem, selection, stage.white, stage.sample)
    if rest is None and field is not None and field.lead > stage.generic_threshold:
        rest = field.unknown
    rest = describe_shape(rest, problem, setting, selection, parts)
    short = failing_fold(problem, parts, selection, stage.noise, stage.u, seed)
    return of_fold(short) if short and rest is None else rest


DRAWS = 400


def failing_fold(
    problem: Problem, parts: Sequence[Fold], selection: Selection, noise: Audit, u: Array, seed: int
) -> str:
    """Return the fold that falls short most, "" where the shortfall is within the 1 % of simulated recordings."""
    parts = [p for p in parts if any(tells(t, p) for t in selection.terms)]
    if not parts or selection.fit is None:
        return ""
    columns = np.concatenate([t.option.columns for t in selection.terms], axis=1)
    width = np.concatenate([np.full(t.white.shape[1], t.width) for t in selection.terms])
    sample = _simulate(problem, selection, columns, noise, u, seed)
    raw = np.column_stack([problem.residual, sample])
    gains = np.stack([_gains_of_draws(p, columns, width, selection.fit.sigma, raw) for p in parts])
    drawn = gains[:, 1:]
    spread = np.maximum(drawn.std(axis=1), LEAST_SPREAD)[:, None]
    short = (gains - drawn.mean(axis=1)[:, None]) / spread
    short[:, 0] += _forgiven(selection) / spread[:, 0]
    limit = float(np.quantile(short[:, 1:].min(axis=0), FALSE_ALARM))
    worst = int(np.argmin(short[:, 0]))
    return parts[worst].name if short[worst, 0] < limit else ""


def _forgiven(selection: Selection) -> float:
    """Return the nats lost to templates that are never exact, twice: a fold predicts from a part that has the error too."""
    return sum(0.5 * (2 * MISMATCH * selection.delta(i)) ** 2 for i in range(len(selection.terms)))


def _simulate(
    problem: Problem, selection: Selection, columns: Array, noise: Audit, u: Array, seed: int
) -> Array:
    """Simulate recordings (m, DRAWS) of the fitted terms, the noise found and the calibration; the nuisance is projected out later."""
    assert selection.fit is not None
    rng = generator(seed, "shortfall")
    dof = noise.noise.dof
    e = rng.standard_normal((problem.m, DRAWS))
    if np.isfinite(dof):
        e = rng.standard_t(dof, (problem.m, DRAWS)) * np.sqrt((dof - 2) / dof)
    if noise.rho:
        e = chain_noise(e, problem.before, noise.rho)
    calibration = problem.calibration @ rng.standard_normal((problem.calibration.shape[1], DRAWS))
    out = (columns @ selection.fit.mean)[:, None] + calibration + selection.fit.sigma * u[:, None] * e
    return np.asarray(out)


def _gains_of_draws(fold: Fold, columns: Array, width: Array, sigma: float, raw: Array) -> Array:
    """Return the log score (D,) that the terms win in the held-out rows of recordings raw (m, D), fitted on the other rows."""
    x, r = fold.fitted.apply(columns[~fold.test]), fold.fitted.apply(raw[~fold.test])
    posterior = condition(x.T @ x, x.T @ r, width)
    signal = x @ posterior.mean
    limited = signal + np.clip(r - signal, -FAR * sigma, FAR * sigma)
    mean = posterior.covariance @ (x.T @ limited)
    x, r = fold.predicted.apply(columns[fold.test]), fold.predicted.apply(raw[fold.test])
    before, rest = (np.clip(v, -FAR * sigma, FAR * sigma) / sigma for v in (r, r - x @ mean))
    return np.asarray(
        0.5 * (before**2).sum(axis=0) + log_density(rest, x, posterior.half)
    )  # in units of sigma


def of_fold(fold: str) -> Unknown:
    """Return the statement of a failing fold: where the named terms do not hold."""
    word = fold[-1] if fold.startswith("far zone") else fold.replace("later ", "").split()[0]
    text = f"the named terms, fitted on the other rows, do not predict the rows of the fold '{fold}': their shape is not right"
    return Unknown((word,), text, 0.0)


def scatter_excess(selection: Selection, white: Whitener, noise: Audit, null: Array) -> str:
    """Return the finding about a scatter beyond the null's quantile that nothing names; null (m, M) prepared white residuals."""
    if any("times what was stated" not in text for text in noise.findings):
        return ""  # outliers, tails, correlation, speed: the scatter has a name
    usual = np.sqrt((null**2).sum(axis=0) / white.dof)
    sigma = selection.fit.sigma if selection.fit else float(np.sqrt(selection.y @ selection.y / white.dof))
    if sigma <= np.quantile(usual, CHANCE):
        return ""
    return (
        f"the scatter is {sigma / float(np.median(usual)):.2f} times what was stated, beyond what chance gives in"
        " 1 of 1000 recordings, and nothing found explains it: the noise is larger than stated, or there is physics that no"
        " column of the recording shows"
    )
