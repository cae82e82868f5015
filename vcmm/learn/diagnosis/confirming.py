"""Measurements that confirm a name, by the catalogue, in words that fit the machine.

Expected decision between two names by an add-on measurement.
"""

from __future__ import annotations

from collections import defaultdict
from statistics import NormalDist

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.run import Run
from vcmm.learn.diagnosis.constants import SUREST, UNSEEN
from vcmm.learn.diagnosis.select import Term
from vcmm.physics import BY_NAME


def confirming(term: Term, rival: str, run: Run) -> str:
    """Return what confirms the name, or, where the axes of a run cannot do that, what confirms its rival; "" where there is neither."""
    effect = term.option.effect
    words = [
        effect.about.words if effect is not None else None,
        BY_NAME[rival].about.words if rival in BY_NAME else None,
    ]
    sentences = [w.confirm for w in words if w is not None and _is_possible(w.confirm, run)]
    if effect is None or not sentences:
        return ""
    values = defaultdict(str, {k: str(v) for k, v in term.family.where.items()})
    values["where"] = " ".join(term.family.where.values())
    return sentences[0].format_map(values)


def _is_possible(confirm: str, run: Run) -> bool:
    """Return whether the confirmation is possible; a circle takes two linear axes."""
    return "circular test" not in confirm or sum(not is_rotary(a) for a in run.position) > 1


ROWS = 80  # of the recording repeated in an add-on, and draws of what it decides


def log_odds(one: float, other: float) -> float:
    return float(np.log(max(one, UNSEEN) / max(other, UNSEEN)))


def expected_probability(odds: float, more: float) -> float:
    """Return the probability of whichever of two names is right, expected after an add-on that adds `more` of squared distance between them.

    The added ln BF is normal about +more/2 where the first is right and about -more/2 where the other is, with variance `more`
    (Lindley, Ann. Math. Stat. 27 (1956) 986); it is evaluated at ROWS even quantiles.
    """
    z = np.array([NormalDist().inv_cdf((k + 0.5) / ROWS) for k in range(ROWS)])
    added = 0.5 * more + np.sqrt(max(more, 0.0)) * z
    first = 1.0 / (1.0 + np.exp(-odds))
    right = np.mean(1.0 / (1.0 + np.exp(np.clip(-odds - added, -SUREST, SUREST))))
    other = np.mean(1.0 / (1.0 + np.exp(np.clip(odds - added, -SUREST, SUREST))))
    return float(first * right + (1.0 - first) * other)
