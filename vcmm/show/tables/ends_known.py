"""Uncertainty of the ends of an interval, where that matters."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import TYPE_CHECKING

if TYPE_CHECKING:
    from vcmm.answer.evaluation.result import CharacteristicResult

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
