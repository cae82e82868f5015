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
from vcmm.machining.setting import Ints, less_errors, less_response, without_setting
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

    @cached_property
    def at(self) -> Ints:
        """The row of the zero for every touch (n + 1,)."""
        return np.append(np.full(self.n, self.n), -1)

    def errors(self) -> Array:
        return less_errors(self.task.machine.indication_error(self.run), self.at)[: self.n]

    @cached_property
    def _all(self) -> tuple[Influence, ...]:
        return influences(self.task.machine, self.run, self.task.inputs)

    def influences(self) -> tuple[Influence, ...]:
        return tuple(
            replace(
                f, response=less_response(f.response, self.at, f.codes)[: self.n], codes=f.codes[: self.n]
            )
            for f in self._all
        )

    def products(self, found: Sequence[Influence]) -> tuple[Product, ...]:
        out = []
        for p in products(self.task.machine, self.run, self._all):
            codes = (self._all[p.first].codes, self._all[p.second].codes)
            out.append(replace(p, response=less_response(p.response, self.at, *codes)[: self.n]))
        return tuple(out)

    def exact_errors(self, drawn: Sequence[Draws]) -> Array:
        mine = [without_setting(replace(d, influence=f), self.at) for d, f in zip(drawn, self._all)]
        return less_errors(exact_errors(self.task.machine, self.run, mine), self.at)[:, : self.n]

    def machine_of(self, one: Input) -> tuple[Machine, Run]:
        return self.task.machine, self.run
