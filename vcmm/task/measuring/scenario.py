"""Scenario: machine, part, plan, pose and environment put together into a measuring task."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from functools import cached_property
from typing import TYPE_CHECKING, Any

import numpy as np

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.inputs import Input
from vcmm.core.knowledge import add_knowledge
from vcmm.core.machine import Machine
from vcmm.core.pose import Pose
from vcmm.core.run import Array
from vcmm.core.views import draw
from vcmm.part.form import Lobes
from vcmm.part.part import Part
from vcmm.task.measuring.fixture import Placement
from vcmm.task.measuring.obstacles import Surroundings
from vcmm.task.measuring.plan import Plan, Touches, touches
from vcmm.task.measuring.qualification import Qualification, qualified_machine
from vcmm.task.measuring.settings import Settings
from vcmm.task.measuring.task import Task

if TYPE_CHECKING:
    from matplotlib.axes import Axes


@dataclass(frozen=True, eq=False)
class Scenario:
    """A measuring job as data. constants: run columns with one value, such as temp_part_C."""

    name: str
    machine: Machine
    part: Part
    plan: Plan
    pose: Pose = field(default_factory=Pose.identity)
    constants: Mapping[str, float] = field(default_factory=dict)
    inputs: tuple[Input, ...] = ()
    forms: Mapping[str, Lobes] = field(default_factory=dict)
    qualifications: Mapping[str, Qualification] = field(default_factory=dict)
    settings: Settings = field(default_factory=Settings)
    places: Mapping[str, Pose] = field(default_factory=dict)  # further poses to compare
    placement: Placement | None = None  # what `place` may move, and what it minimises
    surroundings: Surroundings = field(default_factory=Surroundings)
    record: Mapping[str, str] = field(default_factory=dict)  # who, when, serial numbers: words for the sheet

    def __repr__(self) -> str:
        touched = sum(len(s.points) for s in self.plan.steps)
        names = ", ".join(c.name for c in self.part.characteristics)
        return f"<Scenario {self.name}: {touched} points on {self.machine.name}; {names}>"

    def with_(self, **changes: Any) -> Scenario:
        """Return the same scenario with other fields: `scenario.with_(pose=..., constants=...)`. UsageError for a field that it has not."""
        unknown = [name for name in changes if name not in self.__dataclass_fields__]
        if unknown:
            raise UsageError(
                f'a scenario has no "{unknown[0]}".{choose_from(unknown[0], self.__dataclass_fields__)}'
            )
        return replace(self, **changes)

    def plot(self, ax: Any = None) -> Axes:
        """Plot the touches of the plan with their outward normals, in workpiece axes of the machine."""
        drawn: Axes = draw(self, ax)
        return drawn

    def at(self, pose: Pose) -> Scenario:
        """Return the same job with the part elsewhere in the machine. UsageError for what is no pose."""
        if not isinstance(pose, Pose):
            raise UsageError(
                f"scenario.at(pose) takes a pose, not {type(pose).__name__}; write for example "
                "scenario.at(Pose.from_turns([300, 200, 0], [0, 0, 0])), Pose from vcmm.core.pose, mm and rad"
            )
        return replace(self, pose=pose)

    def informed_machine(self) -> Machine:
        """Return the machine with its styli qualified and every Input of the job. Raises UsageError for a quantity that is stated twice."""
        machine, remaining = qualified_machine(self.machine, self.plan, self.qualifications)
        return add_knowledge(machine, inputs=(*self.inputs, *remaining))

    def task(self) -> Task:
        """Return the plan placed in the machine, with all Inputs; made once, since nothing here changes. Raises ModelLimit for points
        out of reach.
        """
        return self._task

    @cached_property
    def _task(self) -> Task:
        machine = self.informed_machine()
        placed = touches(self.plan, self.pose, machine, self.constants)
        form = _form(self, placed)
        return Task(machine, self.part, self.plan, placed, machine.inputs, form, forms=self.forms)


def _form(scenario: Scenario, placed: Touches) -> Array:
    out = np.zeros(placed.run.n)
    for name, form in scenario.forms.items():
        rows = placed.rows.get(name)
        if rows is not None:
            out[rows] = form.deviation(scenario.part.features[name], placed.points[rows])
    return out
