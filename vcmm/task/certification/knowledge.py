"""Convert a certificate into the effects of a machine file, and Inputs with samples of their joint law."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass

import numpy as np

from vcmm.core.effect import Effect
from vcmm.core.inputs import EVERY, Input
from vcmm.core.laws import MultivariateSamples, Normal
from vcmm.core.machine import Machine
from vcmm.physics.structure.scatter import Scatter
from vcmm.physics.structure.tip import TipRadius
from vcmm.physics.structure.tip_form import TipForm
from vcmm.task.certification.certificate import MachineCertificate
from vcmm.task.certification.each_limit import machines_at_each_limit
from vcmm.task.certification.machines import (
    SEED,
    CertifiedMachines,
    drawn_machines,
    error_tables,
    mirrored_rows,
)


@dataclass(frozen=True, eq=False)
class CertifiedKnowledge:
    """Effects and Inputs of a machine that is known by its certificate only."""

    effects: tuple[Effect, ...]
    inputs: tuple[Input, ...]


def certified_knowledge(
    machine: Machine, certificate: MachineCertificate, seed: int = SEED
) -> CertifiedKnowledge:
    """Return the effects and Inputs for a machine with its axes. UsageError: limits that no machine of the family can keep.

    Inputs are `bound` where only a limit is known: they are the largest errors that the machine may have.
    """
    effects, _ = error_tables(machine)
    return _knowledge(effects, certificate, machines_at_each_limit(machine, certificate, seed))


def passing_machines(
    machine: Machine, certificate: MachineCertificate, seed: int = SEED
) -> CertifiedKnowledge:
    """Return effects and Inputs of machines that pass the test with all their errors together, to predict the test of such a machine."""
    effects, _ = error_tables(machine)
    return _knowledge(effects, certificate, drawn_machines(machine, certificate, seed))


def _knowledge(
    effects: Sequence[Effect], c: MachineCertificate, drawn: CertifiedMachines
) -> CertifiedKnowledge:
    """Return samples as Inputs, about their mean of zero: every machine and its mirror image."""
    evidence = c.words()
    tables = effects[0].name
    inputs = [
        Input(
            tables,
            EVERY,
            "modes",
            MultivariateSamples(mirrored_rows(drawn.modes)),
            "machine",
            evidence,
            bound=True,
        ),
        Input(
            Scatter.name,
            "",
            "value",
            Normal(float(np.sqrt((drawn.scatter**2).mean()))),
            "touch",
            evidence,
            bound=c.findings.R0 is None,
        ),
    ]
    further: list[Effect] = [Scatter()]
    if drawn.form.any():
        further.append(TipForm(coefficients=np.zeros(12)))
        inputs.append(
            Input(
                TipForm.name,
                "",
                "coefficients",
                MultivariateSamples(mirrored_rows(drawn.form)),
                "machine",
                evidence,
                bound=c.findings.R0 is None or c.findings.form is None,
            )
        )
    if drawn.radius.any():
        further.append(TipRadius())
        inputs.append(
            Input(
                TipRadius.name,
                "",
                "dr",
                MultivariateSamples(mirrored_rows(drawn.radius[:, None])),
                "machine",
                evidence,
                bound=True,
            )
        )
    return CertifiedKnowledge((*effects, *further), tuple(inputs))
