"""Machines that just pass the test of their certificate: count how often an interval from the certificate holds the true value.

Each sampled machine has its own geometry, tip and scatter, and its test finds the limit with all of them together. Each
count is of one machine measuring the part, not of a mixture of machines: geometry, tip and scatter belong together.

    "at the limit"            geometry, tip and scatter together use all of the limit
    "geometry alone at it"    the same machines, their geometry made larger until it uses all of the limit by itself
"""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace

import numpy as np

from vcmm.answer.evaluation.exact import draw_inputs, linear_quantities
from vcmm.answer.evaluation.indication import at_indication
from vcmm.answer.evaluation.linear import LinearModel
from vcmm.answer.evaluation.result import CharacteristicResult, UncertaintyResult
from vcmm.core.machine import Machine
from vcmm.core.run import Array
from vcmm.physics.structure.component import CalibrationModes
from vcmm.physics.structure.scatter import Scatter
from vcmm.physics.structure.tip import TipRadius
from vcmm.physics.structure.tip_form import TipForm
from vcmm.task.certification.certificate import MachineCertificate
from vcmm.task.certification.machines import CertifiedMachines, drawn_machines, geometry_at_limit
from vcmm.task.response.trials import Draws

TOGETHER, GEOMETRY = "at the limit", "geometry alone at it"
BLOCK = 500
ANEW = 7  # added to the seed: draws that the interval was not made of


@dataclass(frozen=True)
class CoveredMachines:
    """Share of machines whose measurement lies so that the interval about it holds the true value; least, over machines: worst tenth."""

    characteristic: str
    kind: str
    machines: int
    share: float


def covered_at_limit(
    machine: Machine, certificate: MachineCertificate, result: UncertaintyResult
) -> tuple[CoveredMachines, ...]:
    """Return the counts for sizes, distances and angles. machine: with its axes; the prior "limit" is used instead of that of the certificate."""
    limit = replace(certificate, prior="limit")
    bare = replace(machine, effects=(), inputs=())
    together = drawn_machines(bare, limit)
    kinds = [(TOGETHER, together)]
    if certificate.E0 is not None:
        kinds.append((GEOMETRY, geometry_at_limit(bare, limit, together)))
    smooth = [i for i, c in enumerate(result.characteristics) if not c.extreme]
    out = []
    for kind, machines in kinds:
        errors = _errors(result.model, machines, result.seed + ANEW)
        out += [_count_machines(result.characteristics[i], kind, errors[:, i]) for i in smooth]
    return tuple(out)


def _count_machines(c: CharacteristicResult, kind: str, errors: Array) -> CoveredMachines:
    """Count the errors (m,), indicated - true, of one measurement by every machine, about the estimates."""
    low, high = (end - c.indicated for end in at_indication(c, c.indicated, "probability 95 %").interval)
    truth = -c.bias - errors  # of a part that is indicated at c.indicated + errors
    is_covered = (low <= truth) & (truth <= high)
    return CoveredMachines(c.name, kind, len(errors), float(is_covered.mean()))


def _errors(model: LinearModel, machines: CertifiedMachines, seed: int) -> Array:
    """Return the departures (m, C) of the indications of every machine (and its mirror image), each with one draw of all other inputs."""
    departures = []
    both = machines.mirror
    for at in range(0, len(both.scatter), BLOCK):
        rows = slice(at, min(at + BLOCK, len(both.scatter)))
        drawn = draw_inputs(model, seed, at, rows.stop - rows.start)
        machine_draws = [_input_draws(draws, both, rows) for draws in drawn]
        departures.append(model.values(linear_quantities(model, machine_draws)) - model.at_estimates)
    return np.concatenate(departures)


def _input_draws(draws: Draws, machines: CertifiedMachines, rows: slice) -> Draws:
    """Return the draws of one Input; those of the certificate come from the machines themselves."""
    effect = draws.influence.input.effect
    if effect == Scatter.name:
        law = draws.influence.input.law
        factor = machines.scatter[rows] / float(np.ravel(law.u)[0])
        return Draws(draws.influence, draws.raw, draws.departures * factor[:, None, None])
    for kind, values in (
        (CalibrationModes, machines.modes),
        (TipForm, machines.form),
        (TipRadius, machines.radius[:, None]),
    ):
        if effect == kind.name:
            return Draws(
                draws.influence, draws.raw, np.broadcast_to(values[rows][:, None, :], draws.departures.shape)
            )
    return draws


def smallest(machines: Sequence[CoveredMachines]) -> float:
    """Return the smallest share among machines at the limit."""
    return min((f.share for f in machines if f.kind == TOGETHER), default=1.0)
