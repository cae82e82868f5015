"""Find the names that a selected answer cannot be told from: rivals within 3 nats, and those that mimic it within this noise.

separability s = share of the answer's signal (as length) that the rival cannot mimic, others projected out; a gap of
3 nats needs delta s of 2.45 (delta^2 s^2 / 2 = 3). A name that needs no more columns than the answer and comes that
near is a near alias: it is named whatever its prior is. A name that comes near only because it has more columns holds
the answer as a special case: any of its other motions would have been as likely, so it pays for them in evidence, and
within 3 nats (a posterior of 5 % beside the answer's) it is a rival, beyond it the answer is "contained in" it.
Names that hold the answer whatever is recorded (see generalises) are no rivals while the answer explains as much.
"""

from __future__ import annotations

from dataclasses import dataclass, replace

import numpy as np
import numpy.typing as npt

from vcmm.answer.evaluation.gaussian import thin_svd, without_span
from vcmm.core.run import Array
from vcmm.learn.diagnosis.constants import (
    ALIAS,
    EXACT,
    LEAST_FRACTION,
    MISMATCH,
    RESOLUTION_DELTA,
    STRONG,
    UNSEEN,
)
from vcmm.learn.diagnosis.evidence import IMPOSSIBLE, Scorer, orthonormal, scorer
from vcmm.learn.diagnosis.families import Kin, family_of_answer
from vcmm.learn.diagnosis.mistakes import generalises
from vcmm.learn.diagnosis.select import SelectedTerm, Selection, Setting


@dataclass(frozen=True, eq=False)
class Standing:
    """One answer among its rivals. evidence: nats against nothing; names: rivals; probability of the name."""

    evidence: float
    probability: float
    names: tuple[str, ...]
    families: tuple[int, ...]  # best family of each rival name
    contained_in: tuple[str, ...] = ()  # freer names that mimic the answer and are improbable beside it
    rival_probability: float = 0.0  # of the rivals together
    elsewhere: tuple[
        tuple[int, float], ...
    ] = ()  # families of the same name at other places that explain as much, with their probabilities
    alias_probability: float = 0.0  # probability of the name at its place and of all that repeats it exactly
    exact: tuple[int, ...] = ()  # families that repeat it exactly, the most probable first
    twins: tuple[int, ...] = ()  # those of the same name, at other places
    shares: tuple[float, ...] = ()  # their probabilities
    kin: Kin | None = None  # its family
    exact_shares: tuple[float, ...] = ()  # probabilities of `exact`


def scale_standing(standing: Standing, share: float) -> Standing:
    """Return the standing where only a share of its probability is left to the name and to what it cannot be told from."""
    return replace(
        standing,
        probability=standing.probability * share,
        alias_probability=standing.alias_probability * share,
        rival_probability=standing.rival_probability * share,
        shares=tuple(p * share for p in standing.shares),
        exact_shares=tuple(p * share for p in standing.exact_shares),
        elsewhere=tuple((j, p * share) for j, p in standing.elsewhere),
        kin=standing.kin.times(share) if standing.kin else None,
    )


def compare_with_rivals(selection: Selection, setting: Setting, i: int) -> Standing:
    """Compare term i with every family, given the other terms; physics that has no name is weighed with all names at once (see field)."""
    others = [t.white for j, t in enumerate(selection.terms) if j != i]
    given = scorer(setting.candidates, np.concatenate(others, axis=1) if others else None)
    options = given.options(selection.y[:, None])
    scores = given.families(options)[:, 0]
    family = setting.candidates.families.index(selection.terms[i].family)
    scores[_families_of_other_terms(setting, selection, i)] = -np.inf
    gap = separability(given, selection.signal(i))
    best, larger, freer = _rivals(selection, setting, i, scores, gap, family, ranks(given))
    names, families = tuple(best), tuple(best.values())
    alias = _exact_aliases(setting, gap, ranks(given), selection.terms[i], given.basis)
    exact = tuple(int(j) for j in np.argsort(-scores, kind="stable") if alias[j] and j != family)
    same = [j for j in exact if _name(setting, j) == _name(setting, family)]
    again = [j for j in same if _is_same_place(setting, j, family)]
    twins = tuple(j for j in same if j not in again)
    total = _total_weight(setting, scores, larger)
    probable = np.exp(scores - total)
    of_name = [
        j for j, f in enumerate(setting.candidates.families) if f.name in {_name(setting, family), *names}
    ]
    mine = float(probable[[family, *again]].sum())
    alias[family] = True
    return Standing(
        float(scores[family]), mine, names, families, freer,
        float(probable[of_name].sum() - mine), _elsewhere(setting, scores, family, probable),
        min(float(probable[alias].sum()), 1.0), exact, twins,  # names that hold the answer do not count in the total
        tuple(float(probable[j]) for j in twins),
        family_of_answer(setting, family, scores, options[:, 0], gap, total, larger),
        tuple(float(probable[j]) for j in exact),
    )  # fmt: skip


def _families_of_other_terms(setting: Setting, selection: Selection, i: int) -> list[int]:
    """Return the families of the other terms, which the search does not name a second time: at another scanned value they are no rival of term i."""
    others = {t.family.id for j, t in enumerate(selection.terms) if j != i} - {selection.terms[i].family.id}
    return [j for j, f in enumerate(setting.candidates.families) if f.id in others]


def _is_same_place(setting: Setting, first: int, second: int) -> bool:
    """Return whether one place is stated in another order. A bend in proportion to X and Y is one in proportion to Y and X."""
    a, b = (sorted(setting.candidates.families[k].where.values()) for k in (first, second))
    return a == b


def _name(setting: Setting, family: int) -> str:
    return setting.candidates.families[family].name


def _exact_aliases(
    setting: Setting, gap: Array, rank: Array, term: SelectedTerm, basis: Array
) -> npt.NDArray[np.bool_]:
    """Return the families (families,) that hold the signal exactly with no more columns than the term has here."""
    mine = rank_of(term.white, basis)
    nearest = np.minimum.reduceat(np.where(rank <= mine, gap, np.inf), setting.candidates.first)
    return np.asarray(nearest < EXACT)


def _elsewhere(
    setting: Setting, scores: Array, family: int, probable: Array
) -> tuple[tuple[int, float], ...]:
    """Return the families of the same name at other places (another sensor, another axis) within STRONG of the answer, the most probable first."""
    families = setting.candidates.families
    order = np.argsort(-scores, kind="stable")
    near = [
        int(j)
        for j in order
        if families[j].name == families[family].name and scores[j] > scores[family] - STRONG
    ]
    return tuple((j, float(probable[j])) for j in near if j != family)


def separability(given: Scorer, signal: Array) -> Array:
    """Return s (options,) of a white signal (m,) against every option."""
    rest = signal - given.basis @ (given.basis.T @ signal)
    share = given.explained_energy(rest) / max(float(rest @ rest), LEAST_FRACTION)
    return np.sqrt(np.clip(1.0 - share, 0.0, 1.0))


def ranks(given: Scorer) -> Array:
    """Return the number of columns (options,) of each option that this recording shows."""
    return np.asarray(np.add.reduceat(given.is_seen.astype(float), given.blocks.start))


def rank_of(columns: Array, basis: Array) -> int:
    """Return the same of white columns (m, k) outside a basis."""
    size = thin_svd(without_span(columns, basis))[1]
    return int(np.sum(size**2 > UNSEEN * float(np.sum(columns**2))))


def _rivals(
    selection: Selection, setting: Setting, i: int, scores: Array, gap: Array, index: int, rank: Array
) -> tuple[dict[str, int], set[str], tuple[str, ...]]:
    """Return rivals with their best families, names that always hold this answer, and freer names that hold it here."""
    candidates, term = setting.candidates, selection.terms[i]
    others = [t.white for j, t in enumerate(selection.terms) if j != i]
    mine = rank_of(term.white, orthonormal(np.concatenate([term.white[:, :0], *others], axis=1)))
    nearest = np.minimum.reduceat(gap, candidates.first)  # best mimic of each family
    alias = np.minimum.reduceat(
        np.where(rank <= mine, gap, np.inf), candidates.first
    )  # and with no more columns
    unresolved = max(RESOLUTION_DELTA / max(selection.delta(i), LEAST_FRACTION), MISMATCH)
    best: dict[str, int] = {}
    holding: set[str] = set()
    freer: dict[str, None] = {}
    for j in np.argsort(-scores, kind="stable"):
        family = candidates.families[j]
        if family.name == term.family.name or family.name in best or scores[j] < 0.5 * IMPOSSIBLE:
            continue
        if generalises(family.name, term.family.name):
            members = candidates.of_family(int(j))
            mimic = members[int(np.argmin(gap[members.start : members.stop]))]
            larger = candidates.options[mimic].freedom > term.option.freedom
            if larger and nearest[j] < ALIAS and scores[j] <= scores[index]:
                holding.add(family.name)  # the simpler one is kept
                continue
        if scores[j] > scores[index] - STRONG or alias[j] < unresolved:
            best[family.name] = int(j)
        elif nearest[j] < unresolved:
            freer[family.name] = None
    return best, holding - set(best), tuple(n for n in freer if n not in best)


def _total_weight(setting: Setting, scores: Array, larger: set[str]) -> float:
    """Return ln of the weight of all names and of the hypothesis that nothing is missing, which weighs as much as all names together.

    Names that hold the answer as a special case do not count against it.
    """
    names = [f.name for f in setting.candidates.families]
    kept = np.array([s for s, name in zip(scores, names) if name not in larger])
    return float(np.logaddexp.reduce(np.append(kept, np.log(len(set(names))))))
