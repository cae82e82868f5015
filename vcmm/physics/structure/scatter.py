"""Scatter: the errors that differ from touch to touch, and from one head re-indexing to the next.

The crisp value is zero; an Input with redraw = "touch" (or "event") gives the law.
"""

from __future__ import annotations

from dataclasses import dataclass
from typing import Any

import numpy as np

from vcmm.core.declaration import UM, About, ForDiagnosis, Trade, Typical, Words
from vcmm.core.effect import Effect, along, param
from vcmm.core.run import Array, Run


@dataclass(frozen=True, eq=False)
class Scatter(Effect):
    """A departure of one reading along n; the machine file's [repeatability] gives its law."""

    name = "scatter"
    about = About(
        cites="ISO 10360-2 repeatability range R0; JCGM 100:2008, 4.2 (type A)",
        trade=Trade(
            "repeatability of single points",
            "more points on the feature, or the mean of repeated measurements",
        ),
        is_random=True,
        on_cut_part="turned",
    )
    per = "machine"
    needs = ("nx", "ny", "nz")
    diagnosis = ForDiagnosis(
        is_named=False,
    )
    value: float = param(
        0.0,
        "um",
        "departure of the reading along n",
        typical=Typical(0.7 * UM, "repeatability of a CMM touch: 0.3-1 um"),
    )

    @property
    def link(self) -> str:
        return "reading"

    def error_motion(self, run: Run) -> Array:
        return along(run, run.normal, np.full(run.n, self.value))


@dataclass(frozen=True, eq=False)
class Reindexing(Effect):
    """A random 3-vector of the tip per event (head re-indexing, stylus change), machine axes."""

    name = "reindexing"
    about = About(
        cites="ISO 10360-5: multiple-stylus tests, L_Dia.5x25 (articulating head)",
        trade=Trade("re-indexing of the probe head", "index less often, or qualify after every indexing"),
        words=Words(
            seen="every re-seating shifts the tip ({sd})",
            causes="probe head, rack or pallet does not repeat",
            confirm="re-seat ten times and touch one sphere each time",
        ),
        is_random=True,
        on_cut_part="turned",
    )
    per = "event"
    diagnosis = ForDiagnosis(
        size_name="sd",
    )
    d: Any = param(
        lambda: np.zeros(3),
        "um",
        "shift of the tip",
        shape="(3,)",
        typical=Typical(0.5 * UM, "indexing heads and racks: 0.3-1 um"),
    )

    @property
    def link(self) -> str:
        return "tip"

    def error_motion(self, run: Run) -> Array:
        out = np.zeros((run.n, 6))
        out[:, :3] = np.asarray(self.d, dtype=float)
        return out
