"""Results for other systems: taken from the displayed JSON document, not computed again."""

from __future__ import annotations

import math
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from typing import Any

from vcmm.core.errors import UsageError

SHIFT = 0.05  # of U: drawn ends scatter by some per cent; a normal law shifted by 5 % of U loses 0.1 % of its 95 % (2 Phi(1.96) - Phi(1.862) - Phi(2.058))


@dataclass(frozen=True)
class HandedValue:
    """One characteristic in mm or rad (`unit`): measured value, its bias, u, U and k, the tolerance, the decision.

    interval: of the true value, with probability p; None where its coverage is not demonstrated (`why` says so) or an end of it is
    not known. `about` says whether it is measured +- U: not where a known bias is taken off, nor for most extreme values.
    """

    name: str
    type: str
    unit: str
    nominal: float
    measured: float
    bias: float
    u: float | None
    U: float | None
    k: float | None
    p: float
    interval: tuple[float, float] | None
    tolerance: tuple[float, float] | None
    decision: str
    why: str = ""

    @property
    def about(self) -> bool:
        """Whether the interval of the true value is measured +- U except for the scatter of its simulated ends (SHIFT)."""
        if self.interval is None or self.U is None:
            return False
        ends = (self.measured - self.U, self.measured + self.U)
        return max(abs(a - b) for a, b in zip(self.interval, ends)) <= SHIFT * self.U

    def places(self, scale: float = 1.0) -> int | None:
        """Return the decimals of two significant digits of U, or of half the interval, times `scale` (JCGM 100, 7.2.6; EA-4/02, 6.3);
        None: not known."""
        half = self.U if self.about else self.interval and (self.interval[1] - self.interval[0]) / 2
        if half is None or not math.isfinite(half) or half <= 0:
            return None
        return max(0, 1 - math.floor(math.log10(half * scale * (1 + 1e-12))))


def handed_over(document: Mapping[str, Any]) -> dict[str, list[HandedValue]]:
    """Return the values of every part (one nameless part where the document has none) of a document of `evaluate` or `uncertainty`.

    Raises UsageError for another document.
    """
    if document.get("schema") != "vcmm.uncertainty/1":
        raise UsageError("only documents of vcmm evaluate and vcmm uncertainty are handed to other systems")
    parts = document.get("parts") or [{"part": "", "characteristics": document["characteristics"]}]
    return {p["part"]: [_value(c) for c in p["characteristics"]] for p in parts}


def _value(c: Mapping[str, Any]) -> HandedValue:
    unit = "mm" if "nominal_mm" in c else "rad"

    def value_of(key: str) -> Any:
        return c.get(f"{key}_{unit}")

    measured = value_of("measured")
    shown = bool(c.get("coverage_shown", True))
    return HandedValue(
        name=c["name"], type=c["type"], unit=unit, nominal=value_of("nominal"),
        measured=value_of("value") if measured is None else measured, bias=value_of("bias") or 0.0, u=value_of("u"), U=value_of("U"),
        k=c.get("k"), p=c["p"], interval=_pair(value_of("interval")) if shown else None, tolerance=_pair(value_of("tolerance")),
        decision=c.get("decision") or "", why="" if shown else str(c.get("why_not_shown") or "coverage is not demonstrated"),
    )  # fmt: skip


def _pair(value: Sequence[float] | None) -> tuple[float, float] | None:
    return None if value is None or None in value else (float(value[0]), float(value[1]))
