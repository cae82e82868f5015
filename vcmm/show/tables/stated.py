"""Explain U and the interval of a result in words, and how well its ends are known: sentences for pages, sheets and the terminal."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vcmm.answer.evaluation.result import CharacteristicResult

UPPER = "upper"  # as `interval_kind`: the interval begins at 0, which is no limit, and all that it leaves out lies above


def kind_of_interval(c: CharacteristicResult) -> str:
    """Return symmetric or shortest as requested; "upper" for values that cannot be below 0 and may well be 0."""
    return UPPER if c.one_sided and c.interval[0] <= 0.0 else c.interval_kind


def meaning_of_U(results: Iterable[CharacteristicResult]) -> str:
    """Return of which interval U is half, for all kinds of result."""
    every = list(results)
    p = every[0].p
    sentences = []
    if plain := [c for c in every if not (c.half_width or c.true_value or c.bias_in_U)]:
        sentences.append(f"half the {plain[0].interval_kind} coverage interval for p = {p:.0%}")
    if with_bias := [c for c in every if c.bias_in_U]:
        sentences.append(f"{_of(with_bias, every)}, k u + |bias|, the known bias not corrected")
    if added := [c for c in every if c.half_width]:
        sentences.append(
            f"{_of(added, every)}, half of what the machine adds to parts that are off or rough; for the part itself see the interval"
        )
    if read := [c for c in every if c.true_value and not c.half_width]:
        sentences.append(
            f"{_of(read, every)}, half the interval of the true value, in which y need not lie in the middle"
        )
    return f"U: {'; '.join(sentences)}"


def _of(some: list[CharacteristicResult], all_of_them: list[CharacteristicResult]) -> str:
    return f"of {', '.join(c.name for c in some)}" if len(some) < len(all_of_them) else "of all"


WORTH = 0.03  # of the length: an end that is known better is not spoken of


def how_well_known(results: Iterable[CharacteristicResult]) -> list[str]:
    """Return one sentence per interval of which an end is known to no better than WORTH of the length, because it comes from sampled parts."""
    out = []
    for c in results:
        u, ends = (c.true_value.interval_u, c.true_value.interval) if c.true_value else (None, (0.0, 0.0))
        length = ends[1] - ends[0]
        if u is not None and math.isfinite(length) and max(u) > WORTH * length > 0.0:
            scale, unit = (1e3, "um") if c.unit == "mm" else (1e6, "urad")
            low, high = (f"{scale * v:.2g} {unit}" for v in u)
            out.append(
                f"{c.name}: the ends of the interval rest on drawn parts and have standard uncertainties of {low} (lower) and {high} "
                f"(upper), more than {WORTH:.0%} of its length of {scale * length:.3g} {unit}; more trials make them smaller"
            )
    return out
