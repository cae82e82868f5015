"""Rounding of the digits of a file: an Input for it, and when roundings are no noise."""

from __future__ import annotations

import math

from vcmm.answer.evaluation.result import CharacteristicResult
from vcmm.core.inputs import Input
from vcmm.core.knowledge import add_knowledge
from vcmm.core.laws import Law, Uniform
from vcmm.core.machine import Machine
from vcmm.physics.structure.digits import Resolution

FINE = 1.000001e-6  # mm: the roundings of a step up to 1 nm (0.3 nm) are left out
OF_STEP = 0.5  # scatter over step from which roundings are noise
COARSE = (
    "the digits of the file ({step:g} mm) are coarser than the scatter of a touch ({scatter:.3g} um): the roundings of points of one "
    "surface are alike, and more points do not average them; export the points with more digits"
)
LEADS = (
    "{name}: the digits of the file (last one {step:g} mm) are the largest line of its budget, {share:.0%} of u squared; export the "
    "points with more digits"
)


def with_digits(machine: Machine, step: float) -> Machine:
    """Return the machine with the rounding to `step` mm of every touch: uniform over half a step to either side."""
    if step <= FINE:
        return machine
    label = f"last digit of the coordinates: {step:g} mm"
    return add_knowledge(
        machine, [Resolution()], [Input(Resolution.name, "", "value", Uniform(step / 2.0), "touch", label)]
    )


def step_of(machine: Machine) -> float:
    """Return the step in mm; 0 where the digits contribute nothing worth a line."""
    laws = [i.law for i in machine.inputs if i.effect == Resolution.name]
    return sum(2.0 * law.half_width for law in laws if isinstance(law, Uniform))


def scatter_of(machine: Machine) -> float:
    """Return the standard deviation of a touch without the digits, mm: of all Inputs that are sampled anew for every touch."""
    laws = [i.law for i in machine.inputs if i.redraw == "touch" and i.effect != Resolution.name]
    return math.sqrt(sum(float(law.u) ** 2 for law in laws if isinstance(law, Law)))


def coarse(machine: Machine) -> str:
    """Return why roundings may not be taken for noise; empty where they may.

    The part of a rounding that repeats from point to point falls as exp(-2 pi^2 s^2 / a^2) with the scatter s over the step a: 0.7 % of
    it at s = a / 2 (B. Widrow, I. Kollar, Quantization Noise, 2008, chapter 5). Below, points of one plane are rounded to one side.
    """
    step, scatter = step_of(machine), scatter_of(machine)
    return COARSE.format(step=step, scatter=1e3 * scatter) if scatter < OF_STEP * step else ""


def leading(c: CharacteristicResult) -> float:
    """Return the share of the digits in u^2 where they are the largest line of the budget; else 0."""
    if not c.budget or not math.isfinite(c.u):
        return 0.0
    largest = max(c.budget, key=lambda line: line.u)
    return largest.share if largest.input.partition(".")[0] == Resolution.name else 0.0


def said_of_digits(c: CharacteristicResult, step: float) -> tuple[str, ...]:
    """Return the warning of a characteristic in which the digits contribute most."""
    share = leading(c)
    return (LEADS.format(name=c.name, step=step, share=share),) if share > 0.0 else ()
