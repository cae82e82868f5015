"""What a placement returns, as frozen values."""

from __future__ import annotations

from dataclasses import dataclass

from vcmm.core.run import Array
from vcmm.evaluation.result import UncertaintyResult
from vcmm.placing.certificate import Certificate
from vcmm.placing.confirm import Confirmation
from vcmm.placing.flat import Map, Region
from vcmm.placing.objective import Uncertain
from vcmm.placing.travels import Hindrance


@dataclass(frozen=True, eq=False)
class At:
    """A pose (6: mm and rad), the value of the objective there, u and U of the characteristics (C,), mm or rad."""

    pose: Array
    value: float
    u: Array
    expanded: Array


@dataclass(frozen=True, eq=False)
class Placed:
    """The outcome. present: None where the present pose cannot be used; `problems` say why.

    before, after: the full evaluation at the present and the best pose (budgets, decisions). median and worst are those
    of the scan, drawn evenly over the fixture.
    """

    objective: Uncertain
    label: str  # the discrete choices of the best pose
    best: At
    present: At | None
    problems: tuple[Hindrance, ...]
    median: At
    worst: At
    minima: tuple[tuple[float, Array], ...]
    evaluations: int
    feasible_share: float
    certificate: Certificate
    map: Map
    region: Region
    confirmation: Confirmation | None
    before: UncertaintyResult | None
    after: UncertaintyResult
    seed: int
    warnings: tuple[str, ...]

    @property
    def gain(self) -> float | None:
        """Share of the present value that the best pose saves."""
        if self.present is None or not self.present.value:
            return None
        return (self.present.value - self.best.value) / self.present.value
