"""Check that every part of the rows gives the same answer: names are searched again in alternating rows and in the halves in time.

The columns of the catalogue, the noise and the threshold are those of the whole. A part is tested for a name that should rank first in
it: the signal of the name in its rows, other names projected out, is at least SECURE_DELTA of the noise. A part of the rows holds a part of the evidence, and
what is decided by all rows may be open in it: it contradicts a name only where its own findings are worth STRONG nats more in its rows
than all names of the whole; nearer both are rivals, and the part does not count. A name that n parts test and k of them find is claimed with at
most (k + 1) / (n + 2), the rule of succession (Laplace; Jaynes, Probability Theory (2003), 18.2), unless all find it.

A second opinion: forward selection by the extended Bayesian information criterion, over the same columns and rows.

    EBIC = n ln(RSS) + k (ln n + 2 ln P)      k columns of P chosen, gamma = 1 (Chen & Chen, Biometrika 95 (2008) 759)

The second opinion is the better of the forward selection and of our names, since the steps of a forward selection may miss the best set; where the criterion
prefers our names it agrees. Of columns that lower it equally it takes the first, and has the names of all. It uses no priors, no folds and no rows held out,
and names something in many recordings that hold nothing; its value is that its errors
differ. With d the EBIC of our names less that of its own, exp(-d / 2) are its odds for ours; a name of ours that it
does not have is claimed with the mean of both probabilities, and with even odds at least: two opinions that disagree decide nothing.

The criterion counts free columns. A calibration that is stale as a whole has none: it is a covariance, wider than stated, over as many columns
as there are numbers in the tables. So EBIC is not used for it, and its share is subtracted before the others are judged.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener, whitener, without_span
from vcmm.core.errors import ModelLimit
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import Family
from vcmm.learn.diagnosis.constants import (
    EVEN_ODDS,
    FEWEST,
    LEAST_FRACTION,
    MOST_TERMS,
    SAME_SHARE,
    SECURE_DELTA,
    STRONG,
    SUREST,
    UNSEEN,
)
from vcmm.learn.diagnosis.evidence import Dictionary, dictionary, orthonormal, scorer
from vcmm.learn.diagnosis.families import kin_of
from vcmm.learn.diagnosis.mistakes import is_stale
from vcmm.learn.diagnosis.problem import Problem, neighbours_of
from vcmm.learn.diagnosis.refine import Refiner
from vcmm.learn.diagnosis.result_parts import SecondOpinion, Stability
from vcmm.learn.diagnosis.rivals import Standing, ranks
from vcmm.learn.diagnosis.search import Stage
from vcmm.learn.diagnosis.select import (
    SelectedTerm,
    Selection,
    Setting,
    clean_outliers,
    net_evidence,
    refit,
    select,
    terms_basis,
    white_columns,
)
from vcmm.task.response.folds import Mask
from vcmm.task.response.observe import Observer

ALTERNATE, HALVES = "alternate_rows", "halves"


@dataclass(frozen=True, eq=False)
class _PartOfRows:
    kind: str
    name: str
    rows: Mask
    setting: Setting
    selection: Selection

    @property
    def white(self) -> Whitener:
        return self.setting.white

    @property
    def names(self) -> tuple[SelectedTerm, ...]:
        return self.selection.terms


def stability(
    problem: Problem, stage: Stage, selection: Selection, standings: Sequence[Standing]
) -> Stability:
    """Search the names again in parts of the rows. places: of every term its rivals."""
    parts = [
        p
        for kind, name, rows in _parts_of_rows(problem)
        if (p := _search_part(problem, stage, kind, name, rows))
    ]
    refuses = {id(p): _refuses(p, selection, standings, stage) for p in parts}
    tested_parts, presence = [], []
    for i, (term, standing) in enumerate(zip(selection.terms, standings)):
        of = [
            (p, _is_found(p, term, standing, stage)) for p in parts if _should_show(problem, p, selection, i)
        ]
        decisive = [(p, is_there) for p, is_there in of if is_there or refuses[id(p)]]
        tested_parts.append([p for p, _ in decisive])
        presence.append([is_there for _, is_there in decisive])
    most = tuple(1.0 if all(t) else (sum(t) + 1) / (len(t) + 2) for t in presence)
    text = [
        f"{selection.terms[i].family.id} is not found in {' and '.join(p.name for p, t in zip(tested_parts[i], presence[i]) if not t)}, where it"
        " should show"
        for i in range(len(standings))
        if not all(presence[i])
    ]
    same = {kind: _parts_agree(kind, parts, tested_parts, presence) for kind in (HALVES, ALTERNATE)}
    return Stability(same, tuple(text), most)


def _parts_agree(
    kind: str,
    parts: Sequence[_PartOfRows],
    part_lists: Sequence[list[_PartOfRows]],
    there: Sequence[list[bool]],
) -> bool | None:
    if not any(p.kind == kind for p in parts):
        return None
    answers = [t for of, presence in zip(part_lists, there) for p, t in zip(of, presence) if p.kind == kind]
    if part_lists:
        return all(answers) if answers else None
    return not any(p.names for p in parts if p.kind == kind)


def _parts_of_rows(problem: Problem) -> Iterator[tuple[str, str, Mask]]:
    """Yield kind, name and observations (m,) of every part; rows are taken whole."""
    row = problem.recording.row
    order = np.unique(row, return_inverse=True)[1].ravel()
    yield ALTERNATE, "even rows", order % 2 == 1
    yield ALTERNATE, "odd rows", order % 2 == 0
    time = problem.run.columns.get("time_s")
    if time is not None and np.ptp(time[row]) > 0:
        early = time[row] <= np.median(time[row])
        yield HALVES, "the first half", early
        yield HALVES, "the second half", ~early


def _search_part(problem: Problem, stage: Stage, kind: str, name: str, rows: Mask) -> _PartOfRows | None:
    """Return the names of one part; None where it has too few rows."""
    if rows.sum() < FEWEST or (~rows).sum() < FEWEST:
        return None
    part = _rows_of(problem, rows)
    rho = stage.noise.rho**2 if kind == ALTERNATE else stage.noise.rho
    try:
        white = whitener(stage.u[rows], part.nuisance, part.calibration, part.before, rho)
    except ModelLimit:
        return None
    candidates = dictionary([_family_of(f, rows) for f in stage.candidates.families], white)
    if not candidates.families:
        return None
    setting = Setting(
        candidates,
        white,
        white.apply(part.residual),
        stage.noise.noise.clip,
        stage.threshold,
        Refiner(part, white),
    )
    return _PartOfRows(kind, name, rows, setting, select(clean_outliers(setting)))


def _rows_of(problem: Problem, rows: Mask) -> Problem:
    recording = problem.recording.take(rows)
    stated = tuple((name, columns[rows]) for name, columns in problem.stated)
    return replace(
        problem,
        recording=recording,
        residual=problem.residual[rows],
        u=problem.u[rows],
        nuisance=problem.nuisance[rows],
        calibration=problem.calibration[rows],
        before=neighbours_of(recording),
        observer=Observer(recording, problem.machine),
        stated=stated,
    )


def _family_of(family: Family, rows: Mask) -> Family:
    return replace(family, options=tuple(replace(o, columns=o.columns[rows]) for o in family.options))


def _should_show(problem: Problem, part: _PartOfRows, selection: Selection, i: int) -> bool:
    """Return whether term i is large in the rows of a part, beside the other terms."""
    assert selection.fit is not None
    mean = selection.fit.mean[selection.span(i)]
    signal = part.white.apply(selection.terms[i].option.columns[part.rows] @ mean)
    others = [
        replace(t, white=part.white.apply(t.option.columns[part.rows]))
        for j, t in enumerate(selection.terms)
        if j != i
    ]
    rest = without_span(signal, terms_basis(others, len(signal)))
    return float(np.linalg.norm(rest)) >= SECURE_DELTA * selection.fit.sigma


def _refuses(part: _PartOfRows, selection: Selection, standings: Sequence[Standing], stage: Stage) -> bool:
    """Return whether the findings of a part are worth STRONG nats more in its rows than all names of the whole: at their sizes, or at
    those that suit the part.

    At given sizes nothing is free and nothing is paid: dof / 2 ln(rows alone / rows less the names), sums of squares.
    """
    if all(_is_found(part, t, p, stage) for t, p in zip(selection.terms, standings)):
        return False
    setting, y = replace(part.setting, start=part.selection.y), part.selection.y
    terms = [_term_in_part(t, part) for t in selection.terms]
    ours = refit(terms, setting)
    assert selection.fit is not None
    left = y - np.concatenate([t.white for t in terms], axis=1) @ selection.fit.mean
    at_sizes = (
        0.5 * part.setting.candidates.dof * float(np.log((y @ y) / max(float(left @ left), LEAST_FRACTION)))
    )
    free = net_evidence(replace(ours, y=y), setting)
    return net_evidence(part.selection, setting) - min(free, at_sizes) >= STRONG


def _term_in_part(term: SelectedTerm, part: _PartOfRows) -> SelectedTerm:
    option = replace(term.option, columns=term.option.columns[part.rows])
    return replace(term, option=option, white=part.white.apply(option.columns))


def _is_found(part: _PartOfRows, term: SelectedTerm, standing: Standing, stage: Stage) -> bool:
    """Return whether the term, one of its family at its link, a term that repeats it exactly, or one that it cannot be told from is among
    the names of a part."""
    exact = {stage.candidates.families[k].id for k in standing.exact}
    return any(
        is_same_physics(t, term) or t.family.name in standing.names or t.family.id in exact
        for t in part.names
    )


def is_same_physics(a: SelectedTerm, b: SelectedTerm) -> bool:
    """Return whether both are one family of names at one link of the machine."""
    if a.family.id == b.family.id:
        return True
    first, other = a.option.effect, b.option.effect
    links = first is not None and other is not None and first.link == other.link
    return links and kin_of(a.family.name) == kin_of(b.family.name)


def second_opinion(
    candidates: Dictionary, selection: Selection, standings: Sequence[Standing], dof: int
) -> SecondOpinion:
    """Return the choice of EBIC from a dictionary for the rows of a selection."""
    of_mean = [not _is_covariance(t) for t in selection.terms]
    mean_terms = tuple(t for t, yes in zip(selection.terms, of_mean) if yes)
    y = selection.y - sum(
        (selection.signal(i) for i, yes in enumerate(of_mean) if not yes), np.zeros(len(selection.y))
    )
    theirs, alike = _forward_selection(candidates, y, dof)
    lead = _ebic(mean_terms, candidates, y, dof) - _ebic(theirs, candidates, y, dof)
    theirs, alike = (mean_terms, ()) if lead <= 0.0 else (theirs, alike)
    span = terms_basis(theirs, len(y))
    is_same = [_energy_share(span, selection.signal(i)) >= SAME_SHARE for i in range(len(of_mean))]
    lacks = tuple(
        yes
        and not (
            holds
            or any(is_same_physics(t, mine) or t.family.name in standing.names for t in (*theirs, *alike))
        )
        for yes, mine, standing, holds in zip(of_mean, selection.terms, standings, is_same)
    )
    agrees = not any(lacks) and len(theirs) <= len(mean_terms)
    share = float(1.0 / (1.0 + np.exp(min(max(lead, 0.0) / 2.0, SUREST))))
    return SecondOpinion(tuple(t.family.id for t in theirs), agrees, share, lacks)


def _is_covariance(term: SelectedTerm) -> bool:
    return is_stale(term.family.name, term.family.where.get("component"))


def _energy_share(basis: Array, signal: Array) -> float:
    """Return the share of the energy of a signal in the span of a basis."""
    return float(np.sum((basis.T @ signal) ** 2)) / max(float(signal @ signal), LEAST_FRACTION)


def lower_claim(probability: float, for_ours: float) -> float:
    """Return the claim of a name that the second opinion does not have."""
    return max(0.5 * (probability + for_ours), min(probability, EVEN_ODDS))


def _forward_selection(
    candidates: Dictionary, y: Array, dof: int
) -> tuple[tuple[SelectedTerm, ...], tuple[SelectedTerm, ...]]:
    """Add what lowers EBIC most, until nothing does; and what lowered it as much, up to rounding."""
    chosen: tuple[SelectedTerm, ...] = ()
    alike: tuple[SelectedTerm, ...] = ()
    price = _price(candidates, dof)
    number = np.repeat(
        np.arange(len(candidates.families)), np.diff(np.append(candidates.first, len(candidates.options)))
    )
    while len(chosen) < MOST_TERMS:
        given = scorer(candidates, white_columns(chosen))
        rest = y - given.basis @ (given.basis.T @ y)
        left = max(float(rest @ rest), LEAST_FRACTION)
        gain = given.explained_energy(rest)
        change = dof * np.log(np.maximum(1.0 - gain / left, LEAST_FRACTION)) + price * ranks(given)
        taken = {t.family.id for t in chosen}
        taken |= {f.id for f in candidates.families if is_stale(f.name, f.where.get("component"))}
        change = np.where([candidates.families[k].id in taken for k in number], np.inf, change)
        if not change.min() < 0.0:
            break
        first, *others = (
            SelectedTerm(candidates.families[number[k]], candidates.options[k], candidates.columns(int(k)))
            for k in np.flatnonzero(change <= change.min() + dof * UNSEEN)
        )
        chosen, alike = (*chosen, first), (*alike, *others)
    return chosen, alike


def _price(candidates: Dictionary, dof: int) -> float:
    return float(np.log(dof) + 2.0 * np.log(max(candidates.white.shape[1], 1)))


def _ebic(terms: Sequence[SelectedTerm], candidates: Dictionary, y: Array, dof: int) -> float:
    basis = orthonormal(np.concatenate([y[:, None][:, :0], *(t.white for t in terms)], axis=1))
    rest = y - basis @ (basis.T @ y)
    return (
        dof * float(np.log(max(float(rest @ rest), LEAST_FRACTION)))
        + _price(candidates, dof) * basis.shape[1]
    )
