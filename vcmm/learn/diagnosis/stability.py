"""Is the answer that of every part of the rows? Names are searched again in alternating rows and in the halves in time.

The columns of the catalogue, the noise and the threshold are those of the whole. A part is asked about a name that should stand first in it: what
the name says of its rows, other names projected out, is at least SECURE_DELTA of the noise. A part of the rows holds a part of the evidence, and
what is decided by all rows may be open in it: it speaks against a name only where what it finds instead is worth STRONG nats more in its rows
than all names of the whole; nearer both are rivals, and it is silent. A name that n parts speak about and k of them find is claimed with at
most (k + 1) / (n + 2), the rule of succession (Laplace; Jaynes, Probability Theory (2003), 18.2), unless all find it.
"""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener, whitener, without_span
from vcmm.core.errors import ModelLimit
from vcmm.learn.diagnosis.candidates import Family
from vcmm.learn.diagnosis.checks import Stability
from vcmm.learn.diagnosis.confusion import Standing
from vcmm.learn.diagnosis.constants import FEWEST, NOTHING, SECURE_DELTA, STRONG
from vcmm.learn.diagnosis.evidence import dictionary
from vcmm.learn.diagnosis.families import kin_of
from vcmm.learn.diagnosis.problem import Problem, neighbours_of
from vcmm.learn.diagnosis.refine import Refiner
from vcmm.learn.diagnosis.search import Stage
from vcmm.learn.diagnosis.select import (
    Selection,
    Setting,
    Term,
    basis_of,
    clean_outliers,
    fitted_again,
    net_evidence,
    select,
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
    found: Selection

    @property
    def white(self) -> Whitener:
        return self.setting.white

    @property
    def names(self) -> tuple[Term, ...]:
        return self.found.terms


def stability(problem: Problem, stage: Stage, selection: Selection, places: Sequence[Standing]) -> Stability:
    """Search the names again in parts of the rows. places: of every term its rivals."""
    parts = [p for kind, name, rows in _parts(problem) if (p := _search(problem, stage, kind, name, rows))]
    refuses = {id(p): _refuses(p, selection, places, stage) for p in parts}
    asked, there = [], []
    for i, (term, place) in enumerate(zip(selection.terms, places)):
        of = [(p, _is_found(p, term, place, stage)) for p in parts if _should_show(problem, p, selection, i)]
        spoken = [(p, found) for p, found in of if found or refuses[id(p)]]
        asked.append([p for p, _ in spoken])
        there.append([found for _, found in spoken])
    most = tuple(1.0 if all(t) else (sum(t) + 1) / (len(t) + 2) for t in there)
    text = [
        f"{selection.terms[i].family.id} is not found in {' and '.join(p.name for p, t in zip(asked[i], there[i]) if not t)}, where it"
        " should show"
        for i in range(len(places))
        if not all(there[i])
    ]
    same = {kind: _agree(kind, parts, asked, there) for kind in (HALVES, ALTERNATE)}
    return Stability(same, tuple(text), most)


def _agree(
    kind: str, parts: Sequence[_PartOfRows], asked: Sequence[list[_PartOfRows]], there: Sequence[list[bool]]
) -> bool | None:
    if not any(p.kind == kind for p in parts):
        return None
    own = [t for of, found in zip(asked, there) for p, t in zip(of, found) if p.kind == kind]
    if asked:
        return all(own) if own else None
    return not any(p.names for p in parts if p.kind == kind)


def _parts(problem: Problem) -> Iterator[tuple[str, str, Mask]]:
    """Kind, name and observations (m,) of every part; rows are taken whole."""
    row = problem.recording.row
    order = np.unique(row, return_inverse=True)[1].ravel()
    yield ALTERNATE, "even rows", order % 2 == 1
    yield ALTERNATE, "odd rows", order % 2 == 0
    time = problem.run.columns.get("time_s")
    if time is not None and np.ptp(time[row]) > 0:
        early = time[row] <= np.median(time[row])
        yield HALVES, "the first half", early
        yield HALVES, "the second half", ~early


def _search(problem: Problem, stage: Stage, kind: str, name: str, rows: Mask) -> _PartOfRows | None:
    """Names of one part; None where it has too few rows."""
    if rows.sum() < FEWEST or (~rows).sum() < FEWEST:
        return None
    part = _rows_of(problem, rows)
    rho = stage.noise.rho**2 if kind == ALTERNATE else stage.noise.rho
    try:
        white = whitener(stage.u[rows], part.nuisance, part.calibration, part.before, rho)
    except ModelLimit:
        return None
    found = dictionary([_family_of(f, rows) for f in stage.found.families], white)
    if not found.families:
        return None
    setting = Setting(
        found,
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
    """Is term i large in the rows of a part, beside the other terms?"""
    assert selection.fit is not None
    mean = selection.fit.mean[selection.span(i)]
    signal = part.white.apply(selection.terms[i].option.columns[part.rows] @ mean)
    others = [
        replace(t, white=part.white.apply(t.option.columns[part.rows]))
        for j, t in enumerate(selection.terms)
        if j != i
    ]
    rest = without_span(signal, basis_of(others, len(signal)))
    return float(np.linalg.norm(rest)) >= SECURE_DELTA * selection.fit.sigma


def _refuses(part: _PartOfRows, selection: Selection, places: Sequence[Standing], stage: Stage) -> bool:
    """Is what a part finds worth STRONG nats more in its rows than all names of the whole: at their sizes, or at those that suit the part?

    At given sizes nothing is free and nothing is paid: dof / 2 ln(rows alone / rows less the names), sums of squares.
    """
    if all(_is_found(part, t, p, stage) for t, p in zip(selection.terms, places)):
        return False
    own, y = replace(part.setting, start=part.found.y), part.found.y
    terms = [_term_of(t, part) for t in selection.terms]
    ours = fitted_again(terms, own)
    assert selection.fit is not None
    left = y - np.concatenate([t.white for t in terms], axis=1) @ selection.fit.mean
    at_sizes = 0.5 * part.setting.found.dof * float(np.log((y @ y) / max(float(left @ left), NOTHING)))
    free = net_evidence(replace(ours, y=y), own)
    return net_evidence(part.found, own) - min(free, at_sizes) >= STRONG


def _term_of(term: Term, part: _PartOfRows) -> Term:
    option = replace(term.option, columns=term.option.columns[part.rows])
    return replace(term, option=option, white=part.white.apply(option.columns))


def _is_found(part: _PartOfRows, term: Term, place: Standing, stage: Stage) -> bool:
    """Is the term, one of its family at its link, what repeats it exactly, or one that it cannot be told from among the names of a part?"""
    exact = {stage.found.families[k].id for k in place.exact}
    return any(
        same_physics(t, term) or t.family.name in place.names or t.family.id in exact for t in part.names
    )


def same_physics(a: Term, b: Term) -> bool:
    """One family of names at one link of the machine."""
    if a.family.id == b.family.id:
        return True
    one, other = a.option.effect, b.option.effect
    links = one is not None and other is not None and one.link == other.link
    return links and kin_of(a.family.name) == kin_of(b.family.name)
