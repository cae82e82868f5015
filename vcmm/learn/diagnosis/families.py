"""Families of names: one physics in shapes of fewer or more numbers, at one place.

A play, a play that grows along its axis and one with a memory are one thing that wears. Which of them it is may be open where that
it is one of them is certain. So the probability is first that of the family: the sum over its members, which the declaration of
an effect names by `kin`, at the link of the answer and with a motion that holds most of its signal. Where it is SECURE the simplest
member that the rows do not refuse (within STRONG nats of the best, a share of 5 % beside it) is the answer, and the
others that are open are listed.
"""

from __future__ import annotations

from collections.abc import Collection, Mapping, Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.run import Array
from vcmm.learn.diagnosis.constants import MOSTLY, SECURE, STRONG
from vcmm.learn.diagnosis.select import (
    SelectedTerm,
    Selection,
    Setting,
    best_option,
    conditional_evidence,
    refit,
)
from vcmm.physics import BY_NAME


@dataclass(frozen=True)
class Member:
    """A name of a family at its place; family: its number in the dictionary; probability, and free numbers of its best shape."""

    effect: str
    where: Mapping[str, str]
    probability: float
    family: int
    freedom: int


@dataclass(frozen=True)
class Kin:
    """The family of an answer. members: those that are open, the most probable first."""

    name: str
    probability: float
    members: tuple[Member, ...]

    def times(self, share: float) -> Kin:
        """Return the family where only a share of its probability is left to it."""
        members = tuple(replace(m, probability=m.probability * share) for m in self.members)
        return Kin(self.name, self.probability * share, members)


def kin_of(effect: str) -> str:
    """Return 'play' for a backlash; the name itself where it has no family."""
    return (BY_NAME[effect].diagnosis.shared_physics if effect in BY_NAME else "") or effect


def family_of_answer(
    setting: Setting,
    answer: int,
    scores: Array,
    options: Array,
    gap: Array,
    total: float,
    holding: Collection[str],
) -> Kin:
    """Return the family of the answer with the number `answer`.

    scores, options (nats) and gap (share of the signal that an option cannot mimic) given the other answers; total: ln of the
    weight of everything; holding: names that hold the answer and explain no more, which do not count.
    """
    candidates = setting.candidates
    nearest = np.minimum.reduceat(gap, candidates.first)
    name, place = kin_of(candidates.families[answer].name), _link(setting, answer)
    every = [
        j
        for j, f in enumerate(candidates.families)
        if j == answer
        or (
            kin_of(f.name) == name
            and f.name not in holding
            and _link(setting, j) == place
            and nearest[j] ** 2 < MOSTLY
        )
    ]
    probable = {j: float(np.exp(scores[j] - total)) for j in every}
    whole = sum(probable.values())
    kept = [j for j in every if j == answer or probable[j] >= (1.0 - SECURE) * whole]
    members = tuple(
        Member(
            candidates.families[j].name,
            candidates.families[j].where,
            probable[j],
            j,
            candidates.options[best_option(candidates, options, j)].freedom,
        )
        for j in sorted(kept, key=lambda j: -probable[j])
    )
    return Kin(name, min(whole, 1.0), members)


def _link(setting: Setting, family: int) -> str:
    effect = setting.candidates.options[int(setting.candidates.first[family])].effect
    return "" if effect is None else effect.link


def simplest_member(kin: Kin, answer: int) -> int:
    """Return the number of the simplest member that is open where the family is secure; else the answer itself."""
    if kin.probability < SECURE:
        return answer
    best = kin.members[0].probability
    near = [m for m in kin.members if m.probability > best * float(np.exp(-STRONG))]
    mine = next(m.freedom for m in kin.members if m.family == answer)
    fewer = [m for m in near if m.freedom < mine]
    return min(fewer, key=lambda m: (m.freedom, -m.probability)).family if fewer else answer


def use_simplest_members(selection: Selection, kins: Sequence[Kin], setting: Setting) -> Selection:
    """Return the selection with every answer as the simplest member of its family that the rows do not refuse."""
    families = setting.candidates.families
    terms = list(selection.terms)
    taken = {t.family.id for t in terms}
    for i, (term, kin) in enumerate(zip(selection.terms, kins)):
        family = families.index(term.family)
        new = simplest_member(kin, family)
        if new != family and families[new].id not in taken:
            terms[i] = _best_shape(setting, selection, i, new)
            taken.add(families[new].id)
    return selection if terms == list(selection.terms) else refit(terms, setting, rounds=1)


def _best_shape(setting: Setting, selection: Selection, i: int, family: int) -> SelectedTerm:
    """Return the family `family` beside the other terms, in the shape of highest evidence."""
    others = [t for j, t in enumerate(selection.terms) if j != i]
    best = best_option(setting.candidates, conditional_evidence(others, selection, setting), family)
    candidates = setting.candidates
    return SelectedTerm(
        candidates.families[family],
        candidates.options[best],
        candidates.columns(best),
        selection.terms[i].width,
    )


def open_members_text(kin: Kin) -> str:
    """Return 'which shape is open: backlash p 0.17, lost_motion p 0.83'; '' where one member alone is open."""
    if len(kin.members) < 2:
        return ""
    shares = ", ".join(f"{m.effect} p {m.probability:.2f}" for m in kin.members)
    return f"among the names of the catalogue the family {kin.name} has {kin.probability:.3f}; which shape of it is open: {shares}"
