"""Is the answer that of every part of the rows? Names are searched again in alternating rows and in the halves in time.

The columns of the catalogue, the noise and the threshold are those of the whole. A part is asked about a name that should stand first in it: what
the name says of its rows, other names projected out, is at least SECURE_DELTA of the noise. A name that n parts were asked about and k of them
find is claimed with at most (k + 1) / (n + 2), the rule of succession (Laplace; Jaynes, Probability Theory (2003), 18.2), unless all find it.
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
from vcmm.learn.diagnosis.constants import FEWEST, SECURE_DELTA
from vcmm.learn.diagnosis.evidence import dictionary
from vcmm.learn.diagnosis.families import kin_of
from vcmm.learn.diagnosis.problem import Problem, neighbours_of
from vcmm.learn.diagnosis.refine import Refiner
from vcmm.learn.diagnosis.search import Stage
from vcmm.learn.diagnosis.select import Selection, Setting, Term, basis_of, clean_outliers, select
from vcmm.task.response.folds import Mask
from vcmm.task.response.observe import Observer

ALTERNATE, HALVES = "alternate_rows", "halves"


@dataclass(frozen=True, eq=False)
class _Part:
    kind: str
    name: str
    rows: Mask
    white: Whitener
    names: tuple[Term, ...]


def stability(problem: Problem, stage: Stage, selection: Selection, places: Sequence[Standing]) -> Stability:
    """Search the names again in parts of the rows. places: of every term its rivals."""
    parts = [p for kind, name, rows in _parts(problem) if (p := _search(problem, stage, kind, name, rows))]
    asked = [[p for p in parts if _should_show(problem, p, selection, i)] for i in range(len(places))]
    there = [
        [_is_found(p, selection.terms[i], place) for p in of]
        for i, (of, place) in enumerate(zip(asked, places))
    ]
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
    kind: str, parts: Sequence[_Part], asked: Sequence[list[_Part]], there: Sequence[list[bool]]
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


def _search(problem: Problem, stage: Stage, kind: str, name: str, rows: Mask) -> _Part | None:
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
    return _Part(kind, name, rows, white, select(clean_outliers(setting)).terms)


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


def _should_show(problem: Problem, part: _Part, selection: Selection, i: int) -> bool:
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


def _is_found(part: _Part, term: Term, place: Standing) -> bool:
    """Is the term, one of its family at its link, or one that it cannot be told from among the names of a part?"""
    return any(same_physics(t, term) or t.family.name in place.names for t in part.names)


def same_physics(a: Term, b: Term) -> bool:
    """One family of names at one link of the machine."""
    if a.family.id == b.family.id:
        return True
    one, other = a.option.effect, b.option.effect
    links = one is not None and other is not None and one.link == other.link
    return links and kin_of(a.family.name) == kin_of(b.family.name)
