"""Machines from perfect to their limit: scale the errors of sampled machines by shares of an upper bound.

Of an Input that is `bound` (a limit of a certificate) only the largest value is known. A reading of such a machine
may come from any machine allowed: no correction is applied for errors that were not shown, and no error is
excluded that a machine at its limit may have added or hidden. The machines sampled at the limit are therefore taken with shares
of their own errors (geometry, tip) and of their scatter, one by one and together: those that add most (both), that hide most (the
tip without scatter), that have no effect, and half way.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import replace

import numpy as np

from vcmm.answer.evaluation.linear import LinearModel
from vcmm.core.run import Array
from vcmm.task.response.influence import Influence

Share = tuple[float, float]  # of the machine's own errors, and of its scatter
FULL: Share = (1.0, 1.0)


def possible_shares(influences: Sequence[Influence]) -> tuple[Share, ...]:
    """Return the shares from the least to the limit, which is the last; the limit alone where no Input is only bounded."""
    systematic, scatter = (any(_is_of(f, number) for f in influences) for number in (1, 2))
    if systematic and scatter:
        return ((0.0, 0.0), (0.5, 0.5), (0.0, 1.0), (1.0, 0.0), FULL)
    if systematic:
        return ((0.0, 1.0), (0.5, 1.0), FULL)
    return ((1.0, 0.0), (1.0, 0.5), FULL) if scatter else (FULL,)


def split(model: LinearModel) -> tuple[LinearModel, LinearModel, LinearModel]:
    """Split the model into known inputs, bounded errors of the machine itself, and bounded scatter.

    Products of two Inputs belong to the known part: a bound has none (`vcmm.task.response.influence.products` has those of
    scalar Inputs that meet in one effect, and neither sampled tables nor scatter do).
    """
    stated, systematic, scatter = (
        [i for i, f in enumerate(model.influences) if _group(f) == number] for number in range(3)
    )
    place = {i: k for k, i in enumerate(stated)}
    products = tuple(replace(p, first=place[p.first], second=place[p.second]) for p in model.products)
    of_known = replace(model, influences=tuple(model.influences[i] for i in stated), products=products)
    return of_known, _only(model, systematic), _only(model, scatter)


def at_share(parts: Sequence[Array], share: Share) -> Array:
    """Return the displacements (count, n) of the touches from those of `split`."""
    stated, systematic, scatter = parts
    return np.asarray(stated + share[0] * systematic + share[1] * scatter)


def doubtful(probabilities: Sequence[float]) -> float:
    """Return, of the probabilities under all machines allowed, the one nearest to one half: it accepts, or rejects, only where all of them do."""
    return float(np.clip(0.5, min(probabilities), max(probabilities)))


def _only(model: LinearModel, numbers: Sequence[int]) -> LinearModel:
    return replace(model, influences=tuple(model.influences[i] for i in numbers), products=())


def _group(f: Influence) -> int:
    return 0 if not f.input.bound else 2 if f.input.redraw == "touch" else 1


def _is_of(f: Influence, number: int) -> bool:
    return _group(f) == number and bool(np.abs(f.response).max(initial=0.0) > 0)
