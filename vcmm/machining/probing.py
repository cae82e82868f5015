"""Probing on the machine tool itself: readings count from the work zero that was set on the same machine.

What the machine errs by at the zero is in the zero as well, so it is taken off every reading, draw by draw. The offset that
was set wrongly shifts cut and reading alike: its draw is that of the cut, and its error is found in neither.
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vcmm.influence import Influence, Product, influences, products
from vcmm.inputs import Input
from vcmm.machine import Machine
from vcmm.machining.rows import joined, setting_rows
from vcmm.run import Array, Run
from vcmm.task import Task
from vcmm.trials import Draws, exact_errors


@dataclass(frozen=True, eq=False)
class ProbedHere:
    """The world of a measuring task whose readings are relative to `zero` (3,), workpiece axes; offset: name of the zero."""

    task: Task
    zero: Array
    offset: str
    predicts: bool = False

    @cached_property
    def run(self) -> Run:
        """The touches, then the zero, touched with the stylus of the first of them."""
        touches = self.task.touches.run
        touches = replace(touches, labels={**touches.labels, "setup": np.full(touches.n, self.offset)})
        touches = touches.with_columns({"setting": np.zeros(touches.n)})
        rows = setting_rows(
            touches, np.array([0]), touches.offset[:1], self.zero[None], self.task.touches.pose
        )
        rows = replace(rows, labels={**rows.labels, "stylus": touches.labels["stylus"][:1]})
        rows = rows.with_columns(
            {name: touches.columns[name][:1] for name in ("stylus_length_mm", "nx", "ny", "nz")}
        )
        return self.task.machine.prepare(joined(touches, rows))

    @property
    def n(self) -> int:
        return self.task.touches.run.n

    def errors(self) -> Array:
        found = self.task.machine.indication_error(self.run)
        return np.asarray(found[: self.n] - found[self.n])

    @cached_property
    def _all(self) -> tuple[Influence, ...]:
        return influences(self.task.machine, self.run, self.task.inputs)

    def influences(self) -> tuple[Influence, ...]:
        return tuple(
            replace(f, response=self._less(f.response, f.codes), codes=f.codes[: self.n]) for f in self._all
        )

    def _less(self, response: Array, *codes: np.typing.NDArray[np.intp]) -> Array:
        """response of the touches less that at the zero, where all draws are the same there."""
        same = np.all([c[: self.n] == c[self.n] for c in codes], axis=0)
        shape = (-1,) + (1,) * (response.ndim - 1)
        return np.asarray(response[: self.n] - np.where(same.reshape(shape), response[self.n], 0.0))

    def products(self, found: Sequence[Influence]) -> tuple[Product, ...]:
        return tuple(
            replace(p, response=self._less(p.response, self._all[p.first].codes, self._all[p.second].codes))
            for p in products(self.task.machine, self.run, self._all)
        )

    def exact_errors(self, drawn: Sequence[Draws]) -> Array:
        mine = [self._quiet(replace(d, influence=f)) for d, f in zip(drawn, self._all)]
        found = exact_errors(self.task.machine, self.run, mine)
        return np.asarray(found[:, : self.n] - found[:, self.n :])

    def _quiet(self, one: Draws) -> Draws:
        """What only the zero has (its own scatter) counts as nothing: it belongs to the uncertainty of the offset."""
        used = np.isin(np.arange(one.departures.shape[1]), one.influence.codes[: self.n])
        return replace(one, departures=one.departures * used[None, :, None])

    def machine_of(self, one: Input) -> tuple[Machine, Run]:
        return self.task.machine, self.run
