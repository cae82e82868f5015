"""Power of a recording: the amplitude of every effect at which it would be seen, and the invisible effects."""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.answer.evaluation.gaussian import SCALES
from vcmm.core.run import Array
from vcmm.learn.diagnosis.candidates import Family, unseen_places
from vcmm.learn.diagnosis.constants import NOTHING, SECURE_DELTA, UNSEEN
from vcmm.learn.diagnosis.evidence import Dictionary

LARGEST = SCALES[-1]


@dataclass(frozen=True)
class Detectable:
    """effect at its best place; amplitude: rms over the recording, mm or rad; typical: the same in typical amplitudes."""

    effect: str
    where: dict[str, str]
    amplitude: float
    typical: float


def power(found: Dictionary, sigma: float) -> tuple[tuple[Detectable, ...], tuple[str, ...]]:
    """Return the smallest visible amplitude of every effect name; names and places that even LARGEST typical amplitudes do not show.

    sigma: noise in units of u. Of several shapes the median one counts (of equal ones the order of the list decides, not rounding), of several
    parameters the best seen.
    """
    best: dict[str, Detectable] = {}
    small: list[Family] = []
    large: list[Family] = []
    for i, family in enumerate(found.families):
        sizes = np.array([_largest(found.columns(o)) for o in found.of_family(i)])
        order = np.argsort(np.round(sizes / max(UNSEEN * sizes.max(), NOTHING)), kind="stable")
        middle = int(found.first[i]) + int(order[len(sizes) // 2])
        typical = SECURE_DELTA * sigma / max(_largest(found.columns(middle)), NOTHING)
        rms = typical * float(np.sqrt(np.mean(found.options[middle].columns ** 2, axis=0)).max())
        (small if typical > LARGEST else large).append(family)
        if family.name not in best or rms < best[family.name].amplitude:
            best[family.name] = Detectable(family.name, dict(family.where), rms, typical)
    shown = tuple(d for d in best.values() if d.typical <= LARGEST)
    hidden = tuple(d.effect for d in best.values() if d.typical > LARGEST)
    places = unseen_places([f for f in small if f.name not in hidden], large)
    return tuple(sorted(shown, key=lambda d: d.effect)), (*hidden, *places)


def _largest(x: Array) -> float:
    return float(np.sqrt((x**2).sum(axis=0).max()))
