"""The world of a cut part: errors of the machine tool are departures of the surface, found again by the measurement.

    indicated - true of a touch = that of the measuring machine + (surface with errors - surface without) n

The surface without errors (cusps, rounded corners) is the form of the task. Everything behind the touches (fits,
characteristics, Monte Carlo, budget) is that of measuring.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vcmm.influence import Influence, Product
from vcmm.inputs import Input
from vcmm.machine import Machine
from vcmm.machining.contacts import Contacts, Ints
from vcmm.machining.toolside import ToolSide
from vcmm.run import Array, Run
from vcmm.trials import Draws
from vcmm.world import Measuring


@dataclass(frozen=True, eq=False)
class Cutting:
    """A task measured on a part that was cut with errors.

    measuring: the measuring machine's own world, whose Inputs are apart from those of the machine tool.
    """

    measuring: Measuring
    tool: ToolSide
    contacts: Contacts

    @cached_property
    def _level(self) -> Array:
        """Surface without errors (P,): the form of the task, so no error."""
        return self.contacts.surface(np.zeros((self.tool.run.n, 3)))

    @cached_property
    def _moved(self) -> Array:
        return self.tool.errors()

    @cached_property
    def _on_rows(self) -> tuple[Influence, ...]:
        """Influences on the rows of the cut, setting not yet subtracted."""
        return self.tool.influences()

    def errors(self) -> Array:
        return self.measuring.errors() + self._outward(self.contacts.surface(self._moved) - self._level)

    def _outward(self, height: Array) -> Array:
        """Heights (..., P) as vectors along the normals of the touches, workpiece axes of the measuring machine."""
        return np.asarray(height[..., None] * self.measuring.task.touches.run.normal)

    def influences(self) -> tuple[Influence, ...]:
        row, gain = self.contacts.deepest(self._moved)
        cut = tuple(self._at_touches(self.tool.relative(f), row, gain) for f in self._on_rows)
        return (*cut, *self.measuring.influences())

    def _at_touches(self, one: Influence, row: Ints, gain: Array) -> Influence:
        height = np.einsum("pi,pik->pk", gain, one.response[row])
        response = height[:, None, :] * self.measuring.task.touches.run.normal[:, :, None]
        return replace(one, response=response, codes=one.codes[row])

    def products(self, found: Sequence[Influence]) -> tuple[Product, ...]:
        row, gain = self.contacts.deepest(self._moved)
        n, count = self.measuring.task.touches.run.normal, len(self._on_rows)
        out = [
            Product(p.first, p.second, np.einsum("pi,pi->p", gain, p.response[row])[:, None] * n)
            for p in self.tool.products(self._on_rows)
        ]
        for p in self.measuring.products(found[count:]):
            out.append(Product(p.first + count, p.second + count, p.response))
        return tuple(out)

    def exact_errors(self, drawn: Sequence[Draws]) -> Array:
        count = len(self._on_rows)
        mine = [replace(d, influence=f) for d, f in zip(drawn[:count], self._on_rows)]
        height = self.contacts.surface(self.tool.exact(mine)) - self._level
        return np.asarray(self._outward(height) + self.measuring.exact_errors(list(drawn[count:])))

    def machine_of(self, one: Input) -> tuple[Machine, Run]:
        if any(one is f.input for f in self._on_rows):
            return self.tool.machine, self.tool.run
        return self.measuring.machine_of(one)
