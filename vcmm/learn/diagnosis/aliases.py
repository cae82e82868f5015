"""Shapes that the rows do not resolve are no candidates, but they may still be what was found.

Pre-travel over the seats of a probe is a sum of waves (a triangle is no cosine), and a wave with k lobes probed in 2 k
directions or fewer has the numbers of another one (Shannon; see periods): from four directions six lobes and two lobes
are the same readings, and four lobes are a wrong radius. No evidence can speak for such a shape, for it has no numbers of
its own; but its name stands among the rivals of an answer whose signal it, or the sum of such shapes, repeats with no
more columns than the answer has.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.answer.evaluation.gaussian import Whitener
from vcmm.core.declaration import reported_name
from vcmm.learn.diagnosis.candidates import Family, Option, applies, make_option
from vcmm.learn.diagnosis.confusion import Standing, rank_of, ranks, separability
from vcmm.learn.diagnosis.constants import MISMATCH, NOTHING, RESOLUTION_DELTA
from vcmm.learn.diagnosis.evidence import Dictionary, dictionary, scorer
from vcmm.learn.diagnosis.instances import instances, lacking_columns, where_of
from vcmm.learn.diagnosis.problem import Problem
from vcmm.learn.diagnosis.scans import refused_changes
from vcmm.learn.diagnosis.select import Selection
from vcmm.physics import ALL


def unresolved_shapes(problem: Problem, white: Whitener) -> Dictionary:
    """What the refused shapes of the catalogue would show on this recording, where they show anything."""
    out = []
    for kind in ALL:
        changes = refused_changes(kind, problem.run)
        if not changes or not applies(kind, problem):
            continue
        for effect in instances(kind, problem):
            if lacking_columns(effect, problem.run):
                continue
            made = [make_option(replace(effect, **c), problem) for c in changes]
            options = [o for o in made if o is not None]
            if options:
                out.append(Family(reported_name(kind), where_of(effect), (*options, *_sum(options))))
    return dictionary(out, white)


def _sum(options: Sequence[Option]) -> list[Option]:
    """All shapes together as one option."""
    if len(options) < 2:
        return []
    columns = np.concatenate([o.columns for o in options], axis=1)
    unit = np.concatenate([o.unit for o in options])
    return [Option(None, columns, unit, tuple(label for o in options for label in o.labels), 0.0)]


def with_aliases(place: Standing, selection: Selection, i: int, hidden: Dictionary) -> Standing:
    """The standing with the names of refused shapes that repeat the signal of term i within this noise."""
    if not hidden.families:
        return place
    others = [t.white for j, t in enumerate(selection.terms) if j != i]
    given = scorer(hidden, np.concatenate(others, axis=1) if others else None)
    gap = separability(given, selection.signal(i))
    mine = rank_of(selection.terms[i].white, given.basis)
    nearest = np.minimum.reduceat(np.where(ranks(given) <= mine, gap, np.inf), hidden.first)
    near = nearest < max(RESOLUTION_DELTA / max(selection.delta(i), NOTHING), MISMATCH)
    known = {selection.terms[i].family.name, *place.names}
    names = dict.fromkeys(f.name for f, close in zip(hidden.families, near) if close)
    return replace(place, names=(*place.names, *(n for n in names if n not in known)))
