"""Measure: one virtual measurement, with errors at their estimates or sampled once from the Inputs."""

from __future__ import annotations

from dataclasses import dataclass, field

import numpy as np

from vcmm.answer.evaluation.one_line import first_few, of_name, value_text
from vcmm.answer.evaluation.world import World
from vcmm.core.readable import Readable, Reading
from vcmm.core.run import Array
from vcmm.part.gps import characteristics as gps
from vcmm.part.gps.criteria import notes
from vcmm.task.measuring.task import Task, check_densities, evaluate_all, fit_features, measured_points


@dataclass(frozen=True)
class MeasuredValue:
    """One characteristic: value and nominal in mm or rad."""

    name: str
    type: str
    unit: str
    nominal: float
    value: float


@dataclass(frozen=True, eq=False)
class Measurement(Readable):
    """values of the characteristics; points (n, 3) measured, drawing frame; errors (n,) along the normal, mm."""

    values: tuple[MeasuredValue, ...]
    points: Array
    normals: Array
    nominal_points: Array
    errors: Array
    features: tuple[str, ...]
    warnings: tuple[str, ...] = ()
    reading: Reading | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        values = first_few(f"{v.name} {value_text(v.value, v.unit)}" for v in self.values)
        return f"<Measurement of {len(self.points)} points: {values}>"

    def __getitem__(self, name: str) -> MeasuredValue:
        """Return the value of this name. KeyError: none has it."""
        return of_name(self.values, name)


def measure_task(
    task: Task, seed: int | None = None, world: World | None = None, remarks: tuple[str, ...] = ()
) -> Measurement:
    """Measure once with the exact engine. seed=None: every error at its estimate; else one draw of all Inputs.

    world: where the part is cut too; None: the measuring machine alone. remarks: notes that go with the result.
    """
    check_densities(task)
    run = task.touches.run
    if seed is None or not task.inputs:
        errors = task.machine.indication_error(run, exact=True) if world is None else world.errors()
    else:
        from vcmm.answer.evaluation.exact import draw_inputs
        from vcmm.answer.evaluation.linear import build

        model = build(task, world)
        errors = model.world.exact_errors(draw_inputs(model, seed, 0, 1))[0]
    points = measured_points(task, errors)
    fitted = fit_features(task, points)
    indicated = evaluate_all(task, fitted)
    nominal = [gps.nominal(c, task.part.features) for c in task.part.characteristics]
    values = tuple(
        MeasuredValue(c.name, c.type, gps.unit(c), float(n), float(v))
        for c, n, v in zip(task.part.characteristics, nominal, indicated)
    )
    along = ((points - task.touches.points) * task.touches.normals).sum(axis=1)
    names = tuple(str(f) for f in run.labels["feature"])
    warnings = (*remarks, *notes(task.part.characteristics, fitted))
    return Measurement(
        values, points, normals=task.touches.normals, nominal_points=task.touches.points,
        errors=np.asarray(along), features=names, warnings=warnings,
    )  # fmt: skip
