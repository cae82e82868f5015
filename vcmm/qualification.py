"""Simulated stylus qualification: 25 touches on a reference sphere, a sphere fit, and what it leaves wrong.

The fit's error is (centre, radius) = S delta with S the sensitivity of the Gaussian sphere and delta the reading of
each touch. What is systematic (lobing, trigger delay, bending) is qualified away as far as it looks like a radius or
an offset; what scatters remains as covariance, with the calibration of the sphere and its form.
"""

from __future__ import annotations

from dataclasses import dataclass

import numpy as np

from vcmm.effects.probe import ProbeLobing, StylusBending, TriggerDelay
from vcmm.effects.qualification import StylusQualification
from vcmm.errors import UsageError
from vcmm.fit import gauss, sensitivity
from vcmm.inputs import Input
from vcmm.laws import MultivariateNormal
from vcmm.machine import Machine
from vcmm.part import Feature
from vcmm.plan import Plan, Step, Stylus, probe_columns
from vcmm.run import Array, Run
from vcmm.strategies import Iso10360, plan_points


@dataclass(frozen=True)
class Qualification:
    """Reference sphere: diameter and its standard uncertainty, form (peak to valley), mm."""

    diameter: float = 25.0
    u_diameter: float = 0.0
    form: float = 0.0


def qualify(
    machine: Machine, plan: Plan, stylus: Stylus, how: Qualification
) -> tuple[StylusQualification, Input]:
    """The effect (systematic part) and the Input (covariance 4 x 4 of offset and radius, one draw per stylus).

    Form enters as a uniform departure of each touch over the peak-to-valley range.
    Raises UsageError when the scatter has no finite variance.
    """
    points, normals, matrix = _sphere(stylus, how)
    systematic = -matrix @ _reading(machine, plan, stylus, points, normals)
    spread = _scatter_u(machine) ** 2 + how.form**2 / 12.0
    covariance = spread * matrix @ matrix.T
    covariance[3, 3] += (how.u_diameter / 2) ** 2
    law = MultivariateNormal((covariance + covariance.T) / 2)
    known = Input(
        "stylus_qualification", stylus.name, "d", law, "stylus", "simulated qualification, 25 touches"
    )
    return StylusQualification(stylus.name, systematic), known


def _sphere(stylus: Stylus, how: Qualification) -> tuple[Array, Array, Array]:
    """Points, normals (25, 3) and S (4, 25): centre and radius per reading along the normal. Pole towards the head."""
    pole = -stylus.direction
    ball = Feature("reference sphere", "sphere", np.zeros(3), np.zeros(3), np.array([how.diameter / 2]))
    points, normals = plan_points(ball, Iso10360(pole=(float(pole[0]), float(pole[1]), float(pole[2]))))
    s = sensitivity(gauss("sphere", points), points)
    return points, normals, np.einsum("pni,ni->pn", np.concatenate([s.point, s.sizes]), normals)


def _reading(machine: Machine, plan: Plan, stylus: Stylus, points: Array, normals: Array) -> Array:
    """(25,) mm: what lobing, bending and delay of this stylus add along the normal."""
    step = Step("reference sphere", stylus.name, points, normals)
    single = Plan((step,), {stylus.name: stylus}, plan.touch)
    names = np.array([stylus.name] * len(points))
    columns = {f"n{c}": normals[:, i] for i, c in enumerate("xyz")} | probe_columns(single, names, normals)
    columns |= {f"speed_{a}_mm_s": -plan.touch.speed * normals[:, i] for i, a in enumerate("XYZ")}
    run = Run({}, np.zeros((len(points), 3)), columns, {"stylus": names})
    total = np.zeros(len(points))
    for effect in machine.effects:
        if isinstance(effect, ProbeLobing | TriggerDelay | StylusBending):
            total += (effect.error_motion(run)[:, :3] * normals).sum(axis=1)
    return total


def _scatter_u(machine: Machine) -> float:
    """Standard deviation of one touch from the machine's repeatability."""
    found = [i for i in machine.inputs if i.effect == "scatter"]
    u = float(np.sqrt(sum(float(np.max(i.law.u)) ** 2 for i in found)))
    if not np.isfinite(u):
        raise UsageError(
            "a stylus cannot be qualified with a scatter of infinite variance (t, nu <= 2); state more repeats"
        )
    return u
