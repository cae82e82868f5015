"""Probing on the machine tool itself: readings count from the work zeros that were set on the same machine.

A feature is read from the work offset under which it was cut.

The machine's errors at the zero are in the zero as well, so they are subtracted from every reading, draw by draw. A wrong offset
shifts cut and reading equally: its draw is that of the cut, and its error shows in neither.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from functools import cached_property

import numpy as np

from vcmm.answer.evaluation.true_values import Errorless
from vcmm.core.inputs import Input
from vcmm.core.machine import Machine
from vcmm.core.run import OFFSET_LABEL, Array, Run
from vcmm.shop.machining.zero_setting import ZeroRows, join_runs, setting_rows
from vcmm.task.measuring.task import Task
from vcmm.task.response.influence import Influence, Product, influences, products
from vcmm.task.response.trials import Draws, exact_errors


@dataclass(frozen=True, eq=False)
class NoMeasuringWorld(Errorless):
    """The world of a task without measurement: its touches are the places of evaluation, without errors."""

    predicts: bool = False


@dataclass(frozen=True, eq=False)
class ProbedHere:
    """The world of a measuring task whose readings are relative to `zeros`: work offset -> (3,), workpiece axes.

    The label `work_offset` of the touches says which of them each counts from.
    """

    task: Task
    zeros: Mapping[str, Array]
    predicts: bool = False

    @cached_property
    def run(self) -> Run:
        """The touches, then the zeros in order of `zeros`, touched with the stylus of the first touch."""
        touches = self.task.touches.run
        touches = touches.with_columns({"setting": np.zeros(touches.n)})
        first = np.zeros(len(self.zeros), dtype=np.intp)
        at = np.array(list(self.zeros.values()))
        rows = setting_rows(touches, first, touches.offset[first], at, self.task.touches.pose)
        labels = {"stylus": touches.labels["stylus"][first], OFFSET_LABEL: np.array(list(self.zeros))}
        rows = replace(rows, labels={**rows.labels, **labels})
        rows = rows.with_columns(
            {name: touches.columns[name][first] for name in ("stylus_length_mm", "nx", "ny", "nz")}
        )
        return self.task.machine.prepare(join_runs(touches, rows))

    @property
    def n(self) -> int:
        return self.task.touches.run.n

    @cached_property
    def zero(self) -> ZeroRows:
        """The row of the zero for every touch, none for the zeros themselves (n + k,)."""
        number = {name: self.n + k for k, name in enumerate(self.zeros)}
        touches = [number[str(name)] for name in self.task.touches.run.labels[OFFSET_LABEL]]
        rows = np.array(touches + [-1] * len(number), dtype=np.intp)
        return ZeroRows(np.repeat(rows[:, None], 3, axis=1))

    def errors(self) -> Array:
        return self.zero.off_errors(self.task.machine.indication_error(self.run))[: self.n]

    @cached_property
    def _all(self) -> tuple[Influence, ...]:
        return influences(self.task.machine, self.run, self.task.inputs)

    def influences(self) -> tuple[Influence, ...]:
        return tuple(
            replace(
                f, response=self.zero.off_response(f.response, f.codes)[: self.n], codes=f.codes[: self.n]
            )
            for f in self._all
        )

    def products(self, influences: Sequence[Influence]) -> tuple[Product, ...]:
        out = []
        for p in products(self.task.machine, self.run, self._all):
            codes = (self._all[p.first].codes, self._all[p.second].codes)
            out.append(replace(p, response=self.zero.off_response(p.response, *codes)[: self.n]))
        return tuple(out)

    def exact_errors(self, drawn: Sequence[Draws]) -> Array:
        mine = [self.zero.quiet(replace(d, influence=f)) for d, f in zip(drawn, self._all)]
        return self.zero.off_errors(exact_errors(self.task.machine, self.run, mine))[:, : self.n]

    def machine_of(self, quantity: Input) -> tuple[Machine, Run]:
        return self.task.machine, self.run
