"""What else speaks of the names before they are claimed: parts of the rows, and a second opinion."""

from __future__ import annotations

from dataclasses import replace

from vcmm.learn.diagnosis.checks import CrossChecks
from vcmm.learn.diagnosis.confusion import Standing, lowered
from vcmm.learn.diagnosis.constants import EVEN_ODDS, NOTHING, UNSEEN
from vcmm.learn.diagnosis.judgement import Judgement
from vcmm.learn.diagnosis.second_opinion import lowered_claim, second_opinion
from vcmm.learn.diagnosis.stability import stability


def cross_check(one: Judgement) -> tuple[Judgement, CrossChecks]:
    """The judgement with the probability that parts of the rows and a second opinion leave to its names."""
    stable = stability(one.problem, one.stage, one.selection, one.places)
    opinion = second_opinion(one.stage.found, one.selection, one.places, one.stage.white.dof)
    places = [
        _lower(place, most, opinion.for_ours if lacks else None)
        for place, most, lacks in zip(one.places, stable.most, opinion.lacks)
    ]
    return replace(one, places=places), CrossChecks(stable, opinion)


def unstable_names(one: Judgement, checks: CrossChecks) -> set[str]:
    """Ids of the terms that more parts of the rows lack than have."""
    return {t.family.id for t, most in zip(one.selection.terms, checks.stable.most) if most < EVEN_ODDS}


def steadier(
    first: tuple[Judgement, CrossChecks], second: tuple[Judgement, CrossChecks]
) -> tuple[Judgement, CrossChecks]:
    """The answer without the names that parts of the rows lack, where none of its own is so; what changed stays told."""
    one, checks = second
    if not one.selection.terms or min(checks.stable.most) < EVEN_ODDS:
        return first
    stable = first[1].stable
    return one, replace(checks, stable=replace(checks.stable, same=stable.same, text=stable.text))


def _lower(place: Standing, most: float, for_ours: float | None) -> Standing:
    """most: of the name with its family, that the parts allow; for_ours: that of a second opinion that lacks the name, which leaves
    even odds to a name that had them.
    """
    own = max(place.probability, place.with_aliases)
    claim = max(own, place.kin.probability if place.kin else 0.0)
    share = 1.0
    if for_ours is not None and claim > 0.0:
        share = max(lowered_claim(claim, for_ours) / claim, min(EVEN_ODDS / max(own, NOTHING), 1.0))
    share = min(share, most / max(claim, most))
    return place if share >= 1.0 else lowered(place, share * (1.0 + UNSEEN))
