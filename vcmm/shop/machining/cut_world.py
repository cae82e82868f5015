"""The world of a cut part: errors of the machine tool are departures of the surface, which the measurement shows.

    indicated - true of a touch = that of the measuring machine + (surface with errors - surface without) n

The surface without errors (cusps, rounded corners) is the form of the task. Everything behind the touches (fits,
characteristics, Monte Carlo, budget) is that of measuring. Where the part is probed on the machine that cut it, an error
with one draw per machine has the same draw in both, and the probing does not see errors that it repeats.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vcmm.answer.evaluation.world import Measuring
from vcmm.core.errors import UsageError
from vcmm.core.inputs import Input
from vcmm.core.machine import Machine
from vcmm.core.run import FORCE_COLUMNS, Array, Run
from vcmm.shop.cutting.contactmap import Contacts, Ints
from vcmm.shop.machining.probing import NoMeasuringWorld, ProbedHere
from vcmm.shop.machining.tool_errors import ToolSide
from vcmm.task.response.influence import Influence, Product
from vcmm.task.response.trials import Draws

LEAST_BEND = 1e-9  # mm/N: 1 nm under 1000 N, a hundredth of the stiffest mill


@dataclass(frozen=True, eq=False)
class Cutting:
    """A task measured on a part that was cut with errors.

    measuring: the measuring machine's own world. An Input of both with one id is one quantity (the same machine).
    """

    measuring: Measuring | ProbedHere | NoMeasuringWorld
    tool: ToolSide
    contacts: Contacts
    predicts: bool = True

    @cached_property
    def level(self) -> Array:
        """Surface without errors of the machine (P,): the form of the task, so no error."""
        return self.contacts.surface(self.tool.known_error)

    @cached_property
    def tool_errors(self) -> Array:
        """Errors of the tool at the estimates (rows, 3)."""
        return self.tool.errors()

    @cached_property
    def _cut(self) -> tuple[Influence, ...]:
        """Influences on the rows of the cut, setting not yet subtracted."""
        return self.tool.influences()

    @cached_property
    def _probing(self) -> tuple[Influence, ...]:
        return self.measuring.influences()

    @cached_property
    def _place(self) -> list[int]:
        """Number of each influence of the measuring machine among all."""
        ids = [f.input.id for f in self._cut]
        out, following = [], len(ids)
        for influence in self._probing:
            shared = influence.input.id in ids
            out.append(ids.index(influence.input.id) if shared else following)
            following += not shared
        return out

    def of_part(self) -> Cutting:
        """Return the part itself, for any measuring machine."""
        return replace(self, measuring=NoMeasuringWorld(self.measuring.task))

    def errors(self) -> Array:
        return self.measuring.errors() + self._outward(self.contacts.surface(self.tool_errors) - self.level)

    def _outward(self, height: Array) -> Array:
        """Return the heights (..., P) as vectors along the normals of the touches, workpiece axes of the measuring machine."""
        return np.asarray(height[..., None] * self.measuring.task.touches.run.normal)

    def makers(self) -> tuple[Ints, Array]:
        """Return the row (P,) and gain (P, 3) of the pass that makes each point.

        Of two passes along the same line that leave the same height (into a slot and out of it) the one makes a wall towards which the force bends
        the tool: every mill gives way, and only away from the force. `LEAST_BEND` is too little to matter where heights differ.
        """
        if not all(name in self.tool.run.columns for name in FORCE_COLUMNS):
            return self.contacts.deepest(self.tool_errors)
        return self.contacts.deepest(self.tool_errors + LEAST_BEND * self.tool.run.vector(*FORCE_COLUMNS))

    def influences(self) -> tuple[Influence, ...]:
        row, gain = self.makers()
        out = [self._at_touches(self.tool.relative(f), row, gain) for f in self._cut]
        for number, influence in zip(self._place, self._probing):
            if number < len(self._cut):
                out[number] = _together(out[number], influence)
            else:
                out.append(influence)
        return tuple(out)

    def _at_touches(self, influence: Influence, row: Ints, gain: Array) -> Influence:
        height = np.einsum("pi,pik->pk", gain, influence.response[row])
        response = height[:, None, :] * self.measuring.task.touches.run.normal[:, :, None]
        return replace(influence, response=response, codes=influence.codes[row])

    def products(self, influences: Sequence[Influence]) -> tuple[Product, ...]:
        row, gain = self.makers()
        n = self.measuring.task.touches.run.normal
        out = [
            Product(p.first, p.second, np.einsum("pi,pi->p", gain, p.response[row])[:, None] * n)
            for p in self.tool.products(self._cut)
        ]
        for p in self.measuring.products(self._probing):
            out.append(Product(self._place[p.first], self._place[p.second], p.response))
        return tuple(out)

    def exact_errors(self, drawn: Sequence[Draws]) -> Array:
        mine = [replace(d, influence=f) for d, f in zip(drawn, self._cut)]
        theirs = [_drawn_for(drawn[i], f) for i, f in zip(self._place, self._probing)]
        height = self.contacts.surface(self.tool.exact(mine)) - self.level
        return np.asarray(self._outward(height) + self.measuring.exact_errors(theirs))

    def machine_of(self, quantity: Input) -> tuple[Machine, Run]:
        if any(quantity is i for f in self._cut for i in (f.input, *f.input.members)):
            return self.tool.machine, self.tool.run
        return self.measuring.machine_of(quantity)


def _together(cut: Influence, probing: Influence) -> Influence:
    """Return one draw that acts on both: the machine is the same. Raises UsageError where a touch and its cut have two draws."""
    label = [np.array(influence.copies)[influence.codes] for influence in (cut, probing)]
    other = np.flatnonzero(label[0] != label[1])
    if len(other):
        what, first = cut.input.redraw, int(other[0])
        raise UsageError(
            f"{cut.input.id} varies per {what}, but a point is cut under {label[0][first]} and probed under "
            f"{label[1][first]}, so that one error would be two; cut each feature under one {what}, or inspect on another machine"
        )
    return replace(cut, response=cut.response + probing.response)


def _drawn_for(drawn: Draws, probing: Influence) -> Draws:
    """Return the draws with the copies that the probing knows: fewer than the cut has, where not all offsets are probed."""
    copies = drawn.influence.copies
    if copies == probing.copies:
        return replace(drawn, influence=probing)
    pick = [copies.index(copy) for copy in probing.copies]
    return Draws(probing, drawn.raw[:, pick], drawn.departures[:, pick])
