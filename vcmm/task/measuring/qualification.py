"""Simulate stylus qualification: 25 touches on a reference sphere, a sphere fit, and its remaining errors.

The fit's error is (centre, radius) = S delta with S the sensitivity of the Gaussian sphere and delta the reading of
each touch. What is systematic (lobing, trigger delay, bending) is qualified away as far as it looks like a radius or
an offset; what scatters remains as covariance, with the calibration of the sphere and its form.
"""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, replace

import numpy as np

from vcmm.core.declaration import SeenByQualification
from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError
from vcmm.core.inputs import Input
from vcmm.core.knowledge import add_knowledge
from vcmm.core.laws import MultivariateNormal
from vcmm.core.machine import Machine
from vcmm.core.run import Array, Run
from vcmm.part.fit import gauss, sensitivity
from vcmm.part.part import Feature
from vcmm.physics.structure.qualification import StylusQualification
from vcmm.physics.structure.scatter import Scatter
from vcmm.task.measuring.plan import Plan, Step, Stylus, probe_columns
from vcmm.task.measuring.strategies import Iso10360, plan_points

REPEATABILITY = "repeatability"  # the cause of touches and of what qualification leaves alike


@dataclass(frozen=True, eq=False)
class Sphere:
    """Touches of a stylus on its reference sphere, and S (4, n): offset and radius that a fit makes of their readings."""

    run: Run
    matrix: Array


@dataclass(frozen=True)
class Qualification:
    """Reference sphere: diameter and its standard uncertainty, form (peak to valley), mm."""

    diameter: float = 25.0
    u_diameter: float = 0.0
    form: float = 0.0


def qualified_machine(
    machine: Machine, plan: Plan, how: Mapping[str, Qualification]
) -> tuple[Machine, tuple[Input, ...]]:
    """Return the machine with every named stylus qualified, and the remaining uncertainty of offsets and radii.

    One Input per stylus and cause (covariance 4 x 4 of offset and radius from the scatter, from the form of the sphere and
    from its diameter), and one for the diameter of every sphere on which several styli were qualified, which they share.
    Form enters as a uniform departure of each touch over the peak-to-valley range.
    Raises UsageError when the scatter has no finite variance.
    """
    spheres = {name: sphere(plan, plan.styli[name], qualified) for name, qualified in how.items()}
    if not how:
        return machine, ()
    effects: list[Effect] = [
        e.after_qualification(spheres) if isinstance(e, SeenByQualification) else e for e in machine.effects
    ]
    groups = _spheres(how)
    together = [",".join(names) for names in groups if len(names) > 1 and how[names[0]].u_diameter > 0]
    ready = replace(machine, effects=tuple(effects))
    shared = {name for names in groups if len(names) > 1 for name in names}
    inputs = [
        i
        for name, qualified in how.items()
        for i in _remaining(StylusQualification.name, machine, name, qualified, spheres[name], name in shared)
    ]
    inputs += [
        _shared_sphere(StylusQualification.name, names, how[names.split(",")[0]]) for names in together
    ]
    qualified = add_knowledge(ready, [StylusQualification(name) for name in (*how, *together)])
    return qualified, tuple(inputs)


def _spheres(how: Mapping[str, Qualification]) -> list[list[str]]:
    """Return the names of the styli that were qualified on one sphere: the same diameter, uncertainty and form."""
    groups: dict[Qualification, list[str]] = {}
    for name, qualified in how.items():
        groups.setdefault(qualified, []).append(name)
    return list(groups.values())


def _remaining(
    left: str, machine: Machine, name: str, how: Qualification, fitted: Sphere, common: bool
) -> list[Input]:
    """Return the uncertainty that remains after qualification, one Input per physical cause."""
    touches = fitted.matrix @ fitted.matrix.T
    diameter = np.zeros((4, 4))
    diameter[3, 3] = 0.0 if common else (how.u_diameter / 2) ** 2
    causes = {
        REPEATABILITY: _scatter_u(machine) ** 2 * touches,
        "sphere form": how.form**2 / 12.0 * touches,
        "sphere diameter": diameter,
    }
    label = "simulated qualification, 25 touches"
    return [
        Input(left, name, "d", MultivariateNormal((c + c.T) / 2), "stylus", label, cause=cause)
        for cause, c in causes.items()
        if c.any()
    ]


def _shared_sphere(left: str, names: str, how: Qualification) -> Input:
    covariance = np.zeros((4, 4))
    covariance[3, 3] = (how.u_diameter / 2) ** 2
    label = "diameter of the reference sphere, common to these styli"
    return Input(left, names, "d", MultivariateNormal(covariance), "machine", label, cause="sphere diameter")


def sphere(plan: Plan, stylus: Stylus, how: Qualification) -> Sphere:
    """Return the 25 touches of one stylus on its sphere, with the pole towards the head. Pole towards the head."""
    points, normals, matrix = _sphere(stylus, how)
    step = Step("reference sphere", stylus.name, points, normals)
    single = Plan((step,), {stylus.name: stylus}, plan.touch)
    names = np.array([stylus.name] * len(points))
    columns = {f"n{c}": normals[:, i] for i, c in enumerate("xyz")} | probe_columns(single, names, normals)
    columns |= {f"speed_{a}_mm_s": -plan.touch.speed * normals[:, i] for i, a in enumerate("XYZ")}
    return Sphere(Run({}, np.zeros((len(points), 3)), columns, {"stylus": names}), matrix)


def _sphere(stylus: Stylus, how: Qualification) -> tuple[Array, Array, Array]:
    """Return points, normals (25, 3) and S (4, 25): centre and radius per reading along the normal, with the pole towards the head. Pole
    towards the head."""
    pole = -stylus.direction
    ball = Feature("reference sphere", "sphere", np.zeros(3), np.zeros(3), np.array([how.diameter / 2]))
    points, normals = plan_points(ball, Iso10360(pole=(float(pole[0]), float(pole[1]), float(pole[2]))))
    s = sensitivity(gauss("sphere", points), points)
    return points, normals, np.einsum("pni,ni->pn", np.concatenate([s.point, s.sizes]), normals)


def _scatter_u(machine: Machine) -> float:
    """Return the standard deviation of one touch from the machine's repeatability."""
    scatter = [i for i in machine.inputs if i.effect == Scatter.name]
    spreads = [(np.max(i.law.u), np.max(i.spread(1)[1])) for i in scatter]
    u = float(np.sqrt(sum((u * factor) ** 2 for u, factor in spreads)))
    if not np.isfinite(u):
        raise UsageError(
            "a stylus cannot be qualified with a scatter of infinite variance (t, nu <= 2); state more repeats"
        )
    return u
