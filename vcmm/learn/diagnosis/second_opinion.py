"""A second opinion: forward selection by the extended Bayesian information criterion, over the same columns and rows.

    EBIC = n ln(RSS) + k (ln n + 2 ln P)      k columns of P chosen, gamma = 1 (Chen & Chen, Biometrika 95 (2008) 759)

Chosen is the better of what forward selection finds and of our names: its steps go astray, and where the criterion itself prefers our names it
agrees. Of columns that lower it alike it takes the first, and has the names of all. It knows no priors, no folds and no rows held out, and names something in many recordings that hold nothing; what it is good for is that it
goes wrong otherwise. With d the EBIC of our names less that of its own, exp(-d / 2) are its odds for ours; a name of ours that it
does not have is claimed with the mean of both probabilities, and with even odds at least: two opinions that disagree decide nothing.

The criterion counts free columns. A calibration that is stale as a whole has none: it is a covariance, wider than stated, over as many columns
as there are numbers in the tables. So EBIC is not asked of it, and what it takes up is taken off before the others are judged.
"""

from __future__ import annotations

from collections.abc import Sequence

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.diagnosis.checks import SecondOpinion
from vcmm.learn.diagnosis.confusion import Standing, ranks
from vcmm.learn.diagnosis.constants import EVEN_ODDS, MOST_TERMS, NOTHING, SAME, SUREST, UNSEEN
from vcmm.learn.diagnosis.evidence import Dictionary, orthonormal, scorer
from vcmm.learn.diagnosis.select import Selection, Term, basis_of
from vcmm.learn.diagnosis.special_cases import is_stale
from vcmm.learn.diagnosis.stability import same_physics


def second_opinion(
    found: Dictionary, selection: Selection, places: Sequence[Standing], dof: int
) -> SecondOpinion:
    """What EBIC chooses from a dictionary for the rows of a selection."""
    asked = [not _is_covariance(t) for t in selection.terms]
    own = tuple(t for t, yes in zip(selection.terms, asked) if yes)
    y = selection.y - sum(
        (selection.signal(i) for i, yes in enumerate(asked) if not yes), np.zeros(len(selection.y))
    )
    theirs, alike = _forward(found, y, dof)
    lead = _ebic(own, found, y, dof) - _ebic(theirs, found, y, dof)
    theirs, alike = (own, ()) if lead <= 0.0 else (theirs, alike)
    span = basis_of(theirs, len(y))
    held = [_share(span, selection.signal(i)) >= SAME for i in range(len(asked))]
    lacks = tuple(
        yes
        and not (
            holds or any(same_physics(t, mine) or t.family.name in place.names for t in (*theirs, *alike))
        )
        for yes, mine, place, holds in zip(asked, selection.terms, places, held)
    )
    agrees = not any(lacks) and len(theirs) <= len(own)
    share = float(1.0 / (1.0 + np.exp(min(max(lead, 0.0) / 2.0, SUREST))))
    return SecondOpinion(tuple(t.family.id for t in theirs), agrees, share, lacks)


def _is_covariance(term: Term) -> bool:
    return is_stale(term.family.name, term.family.where.get("component"))


def _share(basis: Array, signal: Array) -> float:
    """Of the energy of a signal, what lies in the span of a basis."""
    return float(np.sum((basis.T @ signal) ** 2)) / max(float(signal @ signal), NOTHING)


def lowered_claim(probability: float, for_ours: float) -> float:
    """Of a name that the second opinion does not have."""
    return max(0.5 * (probability + for_ours), min(probability, EVEN_ODDS))


def _forward(found: Dictionary, y: Array, dof: int) -> tuple[tuple[Term, ...], tuple[Term, ...]]:
    """Add what lowers EBIC most, until nothing does; and what lowered it as much, up to rounding."""
    chosen: tuple[Term, ...] = ()
    alike: tuple[Term, ...] = ()
    price = _price(found, dof)
    number = np.repeat(np.arange(len(found.families)), np.diff(np.append(found.first, len(found.options))))
    while len(chosen) < MOST_TERMS:
        given = scorer(found, np.concatenate([t.white for t in chosen], axis=1) if chosen else None)
        rest = y - given.basis @ (given.basis.T @ y)
        left = max(float(rest @ rest), NOTHING)
        whole = np.repeat(given.size, np.diff(np.append(given.rotated.start, len(given.rotated.size))))
        firm = given.rotated.size > UNSEEN * whole
        b2 = (given.rotated.column.T @ rest) ** 2
        gain = np.add.reduceat(np.where(firm, b2 / np.where(firm, given.rotated.size, 1.0), 0.0), given.rotated.start)  # fmt: skip
        change = dof * np.log(np.maximum(1.0 - gain / left, NOTHING)) + price * ranks(given)
        taken = {t.family.id for t in chosen}
        taken |= {f.id for f in found.families if is_stale(f.name, f.where.get("component"))}
        change = np.where([found.families[k].id in taken for k in number], np.inf, change)
        if not change.min() < 0.0:
            break
        first, *others = (
            Term(found.families[number[k]], found.options[k], found.columns(int(k)))
            for k in np.flatnonzero(change <= change.min() + dof * UNSEEN)
        )
        chosen, alike = (*chosen, first), (*alike, *others)
    return chosen, alike


def _price(found: Dictionary, dof: int) -> float:
    return float(np.log(dof) + 2.0 * np.log(max(found.white.shape[1], 1)))


def _ebic(terms: Sequence[Term], found: Dictionary, y: Array, dof: int) -> float:
    basis = orthonormal(np.concatenate([y[:, None][:, :0], *(t.white for t in terms)], axis=1))
    rest = y - basis @ (basis.T @ y)
    return dof * float(np.log(max(float(rest @ rest), NOTHING))) + _price(found, dof) * basis.shape[1]
