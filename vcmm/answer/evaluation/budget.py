"""Budget lines: the contribution of every Input, in the units of its parameter."""

from __future__ import annotations

from collections.abc import Mapping

import numpy as np

from vcmm.answer.evaluation.montecarlo import Term
from vcmm.answer.evaluation.part_forms import FORM
from vcmm.answer.evaluation.result import BudgetLine
from vcmm.answer.evaluation.world import World
from vcmm.core.effect import parameter, unit_at
from vcmm.core.inputs import EVERY, Input
from vcmm.core.knowledge import targets
from vcmm.core.units import channel_unit, in_unit
from vcmm.part.part import Characteristic, Feature
from vcmm.physics.structure.component import CalibrationModes
from vcmm.physics.structure.scatter import Scatter
from vcmm.task.measuring.qualification import REPEATABILITY
from vcmm.task.response.influence import Influence


def budget_line(
    world: World, influence: Influence, term: Term, u_i: float, u: float, linear: bool
) -> BudgetLine:
    """Return one row; u_i is the contribution, u the whole, mm or rad. Sensitivities exist for scalar Inputs with one draw for all rows."""
    quantity = influence.input
    unit = unit_of(world, quantity)
    scalar = influence.response.shape[2] == 1
    law, factor = quantity.spread(influence.response.shape[2])
    u_input = float(np.ravel(law.u)[0]) * float(abs(factor[0, 0])) if scalar else None
    sensitivity = None
    if linear and term.gain.shape == (1, 1) and factor[0, 0]:
        sensitivity = float(term.gain[0, 0] / factor[0, 0]) * _scale(unit)
    return BudgetLine(
        input=quantity.id, what=words(world, quantity), distribution=quantity.law.name, dof=_dof(world, quantity, law),
        redraw=quantity.redraw, estimate=_in(estimate(world, quantity), unit), u_input=_in(u_input, unit), unit=unit,
        sensitivity=sensitivity, u=u_i, share=(u_i / u) ** 2 if np.isfinite(u) and u > 0 else float("nan"),
        evidence=quantity.evidence, cause=REPEATABILITY if quantity.effect == Scatter.name else quantity.cause,
    )  # fmt: skip


def _dof(world: World, quantity: Input, law: object) -> float:
    """Return the degrees of freedom of a law; of a qualification by touches those of the scatter behind its uncertainty (JCGM 100, G.4)."""
    if quantity.cause == REPEATABILITY:
        scatter = [i.law for i in world.machine_of(quantity)[0].inputs if i.effect == Scatter.name]
        return min(
            (float(getattr(scatter_law, "dof", np.inf)) for scatter_law in scatter), default=float("inf")
        )
    return min(float(getattr(law, "dof", np.inf)), quantity.nu)


def product_line(world: World, first: Influence, second: Influence, u_i: float, u: float) -> BudgetLine:
    """Return the line of a product: the effect of two Inputs together, (d2y/dx1 dx2) u1 u2 (JCGM 100, 5.1.2 and H.1), as an expansion
    coefficient and a temperature have.

    >>> 40.0 * 1e-6 * 0.87  # mm of a length of 40 mm, u(alpha) = 1 um/(m K), u(T) = 0.87 K
    3.48e-05
    """
    a, b = first.input, second.input
    evidence = "; ".join(dict.fromkeys(e for e in (a.evidence, b.evidence) if e))
    return BudgetLine(
        input=f"{a.id} x {b.id}", what=f"{words(world, a)}, times {words(world, b)}", distribution="product of both",
        dof=float("inf"), redraw=a.redraw, estimate=None, u_input=None, unit="", sensitivity=None, u=u_i,
        share=(u_i / u) ** 2 if np.isfinite(u) and u > 0 else float("nan"), evidence=evidence,
    )  # fmt: skip


def form_line(c: Characteristic, features: Mapping[str, Feature], u_i: float, u: float) -> BudgetLine:
    """Return the line of the form that the points do not meet, which varies from part to part of a family of forms.

    A surface of nominal points has none between them: there it is the form of the datums.
    """
    name = ", ".join(n for n in c.of if not features[n].free) or ", ".join(c.features[len(c.of) :])
    return BudgetLine(
        input=f"form[{name}].between points", what=f"form of {name} between the points", distribution="family of forms",
        dof=float("inf"), redraw="part", estimate=None, u_input=None, unit="", sensitivity=None, u=u_i,
        share=(u_i / u) ** 2 if np.isfinite(u) and u > 0 else float("nan"), evidence="default family of forms",
    )  # fmt: skip


def unit_of(world: World, quantity: Input) -> str:
    """Return the unit of the parameter or column, as files write it; degC for temperatures."""
    if quantity.effect == FORM:
        return "um"
    if quantity.members:
        units = {unit_of(world, m) for m in quantity.members}
        return units.pop() if len(units) == 1 else ""
    if quantity.is_channel:
        unit = channel_unit(quantity.parameter)
        return "degC" if unit == "K" else unit
    effect = targets(world.machine_of(quantity)[0], quantity)[0]
    unit = parameter(effect, quantity.parameter).metadata["show"]
    if unit == "mm or rad":
        return "urad" if str(getattr(effect, "component", "EXX"))[1] in "ABC" else "um"
    return unit_at(effect, unit, axis=str(getattr(effect, "axis", "")))


def estimate(world: World, quantity: Input) -> float | None:
    """Return the number in the machine file or the run, canonical unit; None for arrays."""
    if quantity.members or quantity.effect == FORM:
        return None
    if quantity.is_channel:
        return float(np.mean(world.machine_of(quantity)[1].column(quantity.parameter)))
    effect = targets(world.machine_of(quantity)[0], quantity)[0]
    spec = parameter(effect, quantity.parameter)
    return None if spec.metadata["shape"] else float(getattr(effect, spec.name))


def words(world: World, quantity: Input) -> str:
    """Return the name of the Input in plain words: "expansion coefficient of the part", "temperature part"."""
    if quantity.effect == FORM:
        return f"form of {quantity.where}, {quantity.parameter} not known"
    if quantity.widths:  # all numbers of a machine that was followed
        return f"{quantity.cause or 'state of the machine'}, {quantity.evidence}"
    if quantity.members:
        return quantity.evidence if quantity.shares is not None else "known together, correlated"
    if quantity.is_channel:
        name = quantity.parameter.rsplit("_", 1)[0].replace("temp_", "temperature ").replace("_", " ")
        return f"{name}, true minus reading" if name.startswith("temperature") else name
    effect = targets(world.machine_of(quantity)[0], quantity)[0]
    doc = str(parameter(effect, quantity.parameter).metadata["doc"])
    by = f", by the {quantity.cause}" if quantity.cause else ""
    if quantity.effect == CalibrationModes.name:
        return "errors of the machine as its calibration knows them, all together"
    where = "" if quantity.where in ("", EVERY) else f" {quantity.where}"
    return f"{quantity.effect.replace('_', ' ')}{where}: {doc}{by}"


def _scale(unit: str) -> float:
    return 1.0 if unit in ("", "1") else 1.0 / in_unit(1.0, unit)


def _in(value: float | None, unit: str) -> float | None:
    return None if value is None else value / _scale(unit)
