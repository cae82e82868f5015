"""World: the source of the errors of a task, and their propagation to each touch.

Measuring knows one machine that touches the part. Cutting knows the machine that made the part as well: its errors are
departures of the surface, and they reach the touches along their normals. What comes after (fits, characteristics,
Monte Carlo, budget) sees no difference.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import Protocol

import numpy as np

from vcmm.answer.evaluation.part_forms import FORM, form_influences
from vcmm.core.inputs import Input
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.task.measuring.task import Task
from vcmm.task.response.influence import Influence, Product, influences, products
from vcmm.task.response.trials import Draws, exact_errors


class World(Protocol):
    """Errors are indicated - true of every touch (n, 3), workpiece axes, mm.

    predicts: the trials are future results (a part still to be cut), so their spread is the answer itself; without it
    a true value is inferred from an indication, which the spread of an extreme value does not tell.
    """

    @property
    def predicts(self) -> bool: ...

    def errors(self) -> Array:
        """Return the errors at the estimates, first order (n, 3)."""
        ...

    def influences(self) -> tuple[Influence, ...]:
        """Return the effect of every Input on every touch."""
        ...

    def products(self, influences: Sequence[Influence]) -> tuple[Product, ...]:
        """Return second-order terms of Inputs that act together."""
        ...

    def exact_errors(self, drawn: Sequence[Draws]) -> Array:
        """Return the errors in every trial (m, n, 3), transforms multiplied."""
        ...

    def machine_of(self, quantity: Input) -> tuple[Machine, Run]:
        """Return the machine and the run on which an Input acts, for the words of the budget."""
        ...


@dataclass(frozen=True, eq=False)
class Measuring:
    """The world of a measuring task: one machine, one run of touches."""

    task: Task
    predicts: bool = False

    def errors(self) -> Array:
        return self.task.machine.indication_error(self.task.touches.run)

    def influences(self) -> tuple[Influence, ...]:
        of_machine = influences(self.task.machine, self.task.touches.run, self.task.inputs)
        return (*of_machine, *form_influences(self.task))

    def products(self, influences: Sequence[Influence]) -> tuple[Product, ...]:
        return products(self.task.machine, self.task.touches.run, influences)

    def exact_errors(self, drawn: Sequence[Draws]) -> Array:
        of_part = [d for d in drawn if d.influence.input.effect == FORM]
        errors = exact_errors(
            self.task.machine, self.task.touches.run, [d for d in drawn if d not in of_part]
        )
        return np.asarray(sum((d.moves() for d in of_part), errors))

    def machine_of(self, quantity: Input) -> tuple[Machine, Run]:
        return self.task.machine, self.task.touches.run
