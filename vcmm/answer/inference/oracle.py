"""Compare the length of intervals with that of an oracle which knows the family of forms of the part.

The oracle knows the family, how the sizes of its forms are spread and the noise of the machine. Of the parts of that family it
takes those that indicated as much (and whose residuals are as large, where the belts use them too) and gives the range of the
central p of their true values: the conditional law of the true value given what was seen, by nearest neighbours. The belts know
none of it: they hold for every size of form and for either family, and are longer.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.answer.evaluation.belts import Reading, parts_with_element, sorted_by_roughness
from vcmm.answer.evaluation.pairs import Pairs
from vcmm.core.run import Array
from vcmm.part.gps import characteristics as gps
from vcmm.part.part import Characteristic

ALIKE, SHARE = 300, 0.1  # parts that indicated as much: so many, and at most this share of all
NO_ERROR = 1e-12  # mm or rad


@dataclass(frozen=True)
class IntervalLengths:
    """Mean lengths over sampled parts (mm or rad) and coverages: of the belts of all families, of the belts of the part's own family, of
    the oracle.
    """

    belts: float
    own: float
    oracle: float
    belts_held: float
    own_held: float
    oracle_held: float

    @property
    def ratio(self) -> float:
        """Length of the interval over that of the oracle."""
        return self.belts / self.oracle if self.oracle > 0 else float("nan")


def lengths(
    c: Characteristic, k: int, inverse: Reading, families: Sequence[Pairs], drawn: Sequence[Pairs], p: float
) -> IntervalLengths:
    """Return the lengths. c: characteristic in column k; families: parts per family from which belts and oracle are made; drawn: others, to count."""
    widths = []
    for family, mine, fresh in zip(inverse.families, families, drawn):
        true, indicated, rest = parts_with_element(k, fresh)
        kinds = [
            reading.interval(p, indicated, rest)
            if reading
            else oracle(c, parts_with_element(k, mine), (indicated, rest), p)
            for reading in (inverse, family, None)
        ]
        widths.append(
            [(high - low).mean() for low, high in kinds]
            + [((low <= true + NO_ERROR) & (true <= high + NO_ERROR)).mean() for low, high in kinds]
        )
    return IntervalLengths(*(float(x) for x in np.mean(widths, axis=0)))


def oracle(
    c: Characteristic, family: tuple[Array, Array, Array], asked_part: tuple[Array, Array], p: float
) -> tuple[Array, Array]:
    """Ends (m,), (m,) of the interval. family: true, indicated, residuals (n,) of parts of the family; asked_part: indicated, residuals (m,)."""
    from scipy.spatial import KDTree

    true, indicated, rest = family
    rough = sorted_by_roughness(c)
    unit, own_unit = (np.maximum(r, NO_ERROR) if rough else np.ones(len(r)) for r in (rest, asked_part[1]))
    count = int(min(ALIKE, max(SHARE * len(true), 1)))
    alike = (
        KDTree(_place(c, indicated, rest)).query(_place(c, *asked_part), count)[1].reshape(len(own_unit), -1)
    )
    low, high = (
        np.quantile(((true - indicated) / unit)[alike], [(1 - p) / 2, (1 + p) / 2], axis=1) * own_unit
        + asked_part[0]
    )
    if gps.is_one_sided(c):
        low, high = np.maximum(low, 0.0), np.maximum(high, 0.0)
    return low, high


def _place(c: Characteristic, indicated: Array, rest: Array) -> Array:
    """Return the coordinates (n, d) in which similar parts are near: the indicated value where it shows the size of the form, residuals
    where they are used."""
    columns = [indicated] if gps.is_one_sided(c) else []
    columns += [rest] if sorted_by_roughness(c) else []
    return np.log(np.maximum(np.stack(columns, axis=1), NO_ERROR))
