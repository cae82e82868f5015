"""The machine tool's side of a cut: motion of the tool by its errors and their uncertainties, row by row of a run.

    moved = actual - commanded of the cutting point, less the same at the place where the work offset was set

Setting the work offset on the same machine subtracts its error there; that holds draw by draw, so that common errors
cancel. Scatter while setting is part of the uncertainty of the offset, not subtracted twice.

Effects that are readings when measuring act on a part that is cut and measured later: a part cut warm or bent comes out
as the measuring machine would have read it, with the sign turned (expansion, clamping); so does the scatter of a pass and
of a tool change, where the sign is of no matter. What is stated for the finished part already (heat of cutting) keeps its
sign: `on_cut_part` of the effect says which. Probes and instruments do not cut.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.effect import Effect, required
from vcmm.core.inputs import Input
from vcmm.core.knowledge import acted_on
from vcmm.core.machine import Machine
from vcmm.core.run import FORCE_COLUMNS, Array, Run
from vcmm.physics.structure.scatter import Scatter
from vcmm.shop.machining.zero_setting import Ints, ProbedRows, ZeroRows
from vcmm.task.response.influence import Influence, Product, influences, products
from vcmm.task.response.trials import Draws, exact_errors

PASS = "pass"  # redraw of the scatter of a cut


def cutting_effects(machine: Machine) -> tuple[Machine, Machine, tuple[str, ...]]:
    """Return (machine whose negative indication error moves the surface, machine whose reading does, ids that do not cut)."""
    moves = [e for e in machine.effects if e.link != "reading" or e.about.on_cut_part == "turned"]
    stated = [e for e in machine.effects if e.about.on_cut_part == "stated"]
    idle = tuple(e.id for e in machine.effects if e not in moves and e not in stated)
    return replace(machine, effects=tuple(moves)), replace(machine, effects=tuple(stated)), idle


def needs_forces(effect: Effect) -> bool:
    """Return whether an effect follows the cutting force."""
    return bool(set(required(effect)) & set(FORCE_COLUMNS))


@dataclass(frozen=True, eq=False)
class ToolSide:
    """run: rows in which points are cut, then rows in which zeros were set, `rows_per_zero` for each of them.

    setting (n, 3): first of those of each row for X, Y, Z, -1 where nothing is subtracted (offset from elsewhere). known_error (n, 3): deviation
    of the nominal motion from the programmed path (corners rounded, nominal lag), mm. turn (n, 3, 3): from commanded X, Y, Z
    to workpiece axes in each row, None while all rotary axes stand at zero. phi (n,): angle of the meridian frame of a lathe
    in which errors are wanted, rad; None: workpiece axes. passes (n, r): departure of each row per draw of the scatter of a
    pass; None: every row has its own. touches: what the program itself probed, rows behind those of setting.
    """

    machine: Machine
    run: Run
    setting: Ints
    known_error: Array
    inputs: tuple[Input, ...]
    turn: Array | None = None
    phi: Array | None = None
    rows_per_zero: int = 1
    passes: Array | None = None
    touches: ProbedRows | None = None

    @property
    def zero(self) -> ZeroRows:
        return ZeroRows(self.setting, self.rows_per_zero, self.turn, self.touches)

    @property
    def parts(self) -> tuple[Machine, Machine]:
        """The effects that move the tool, and those that move the finished part."""
        moves, stated, _ = cutting_effects(self.machine)
        return moves, stated

    def errors(self, exact: bool = False) -> Array:
        """Return moved (n, 3) at the estimates."""
        moves, stated = self.parts
        total = -moves.indication_error(self.run, exact)
        if stated.effects:
            total = total + stated.indication_error(self.run)
        return self.zero.off_errors(self._to_frame(total)) + self.known_error

    def influences(self) -> tuple[Influence, ...]:
        """Return d moved / d input (n, 3, k), setting not yet subtracted, for every Input that acts on the cut."""
        moves, stated = self.parts
        out = []
        for quantity in self.inputs:
            halves = [
                (m, s) for m, s in ((moves, -1.0), (stated, 1.0)) if quantity.is_channel or _acts(m, quantity)
            ]
            acting = [(influences(m, self.run, [quantity])[0], s) for m, s in halves if m.effects]
            if acting:
                total = np.sum([s * f.response for f, s in acting], axis=0)
                framed = np.moveaxis(self._to_frame(np.moveaxis(total, -1, 0)), 0, -1)
                out.append(self._by_pass(replace(acting[0][0], response=framed)))
        return tuple(out)

    def _by_pass(self, influence: Influence) -> Influence:
        """Return the scatter of the machine sampled per pass, not per evaluated point."""
        if self.passes is None or influence.input.redraw != "touch" or influence.input.effect != Scatter.name:
            return influence
        return Influence(
            replace(influence.input, redraw=PASS), influence.response * self.passes[:, None, :], ("",),
            np.zeros(self.run.n, dtype=np.intp),
        )  # fmt: skip

    def _by_row(self, draws: Draws) -> Draws:
        """Return the draws of passes as they act on every row."""
        if self.passes is None or draws.influence.input.redraw != PASS:
            return draws
        rows = tuple(str(i) for i in range(self.run.n))
        each = replace(draws.influence, copies=rows, codes=np.arange(self.run.n))
        departures = draws.departures[:, 0] @ self.passes.T
        return Draws(each, departures[:, :, None], departures[:, :, None])

    def relative(self, influence: Influence) -> Influence:
        """Return the influence less that in the row of setting, where both are one draw."""
        return replace(influence, response=self.zero.off_response(influence.response, influence.codes))

    def products(self, given: Sequence[Influence]) -> tuple[Product, ...]:
        """Return second-order terms (n, 3) of moved, by the products among the `given` influences."""
        moves, stated = self.parts
        out = []
        for machine, sign in ((moves, -1.0), (stated, 1.0)):
            if machine.effects:
                here = [f for f in given if f.input.is_channel or _acts(machine, f.input)]
                number = {id(f): i for i, f in enumerate(given)}
                for p in products(machine, self.run, here):
                    first, second = number[id(here[p.first])], number[id(here[p.second])]
                    response = self._to_frame(sign * p.response)
                    codes = (given[first].codes, given[second].codes)
                    out.append(Product(first, second, self.zero.off_response(response, *codes)))
        return tuple(out)

    def exact(self, drawn: Sequence[Draws]) -> Array:
        """Return moved (m, n, 3) in every trial, transforms multiplied; the Draws carry influences of this run."""
        moves, stated = self.parts
        quiet = [self.zero.quiet(self._by_row(d)) for d in drawn]
        total = -exact_errors(moves, self.run, quiet)
        if stated.effects:
            total = total + exact_errors(stated, self.run, quiet)
        return self.zero.off_errors(self._to_frame(total)) + self.known_error

    def in_workpiece(self, vectors: Array, row: Ints) -> Array:
        """Return vectors (k, 3) of the frame of the contacts in rows (k,), in workpiece axes: `_to_frame` undone."""
        if self.phi is None:
            return vectors
        c, s = np.cos(self.phi[row]), np.sin(self.phi[row])
        x, y, z = vectors.T
        return np.stack([c * x - s * y, s * x + c * y, z], axis=1)

    def _to_frame(self, vectors: Array) -> Array:
        """Return vectors (..., n, 3) of workpiece axes in the frame in which errors are wanted."""
        if self.phi is None:
            return vectors
        c, s = np.cos(self.phi), np.sin(self.phi)
        x, y, z = (vectors[..., i] for i in range(3))
        return np.stack([c * x + s * y, c * y - s * x, z], axis=-1)


def _acts(machine: Machine, quantity: Input) -> bool:
    return any(acted_on(machine, single) for single, _ in quantity.scalars)
