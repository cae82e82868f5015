"""Value of a certificate for a part: U under every prior, U with every further fact, and coverage of machines at the limit."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass, field, replace
from pathlib import Path
from typing import Any

from vcmm.answer.evaluation.at_limit import CoveredMachines, covered_at_limit
from vcmm.answer.evaluation.one_line import first_few
from vcmm.answer.evaluation.result import UncertaintyResult
from vcmm.answer.evaluation.uncertainty import evaluate
from vcmm.core.blocks import Progress
from vcmm.core.errors import UsageError
from vcmm.core.readable import Readable, Reading
from vcmm.files.own.certificate import certificate_table
from vcmm.files.own.machine import load_machine_of
from vcmm.files.own.scenario import load_scenario
from vcmm.learn.calibration.acceptance import Figure, predict_figures
from vcmm.task.certification.certificate import PRIORS, MachineCertificate
from vcmm.task.certification.findings import Findings
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.settings import Settings

# exact trials of each evaluation: the machines are the same, and `uncertainty` checks with more
CHECK_TRIALS = 20
FIRST = ("E0_MPE", "iso230_2")  # one of these is needed
FACTS = (
    "P_Form_Sph_1x25",
    "P_Size_Sph_1x25",
    "R0_MPL",
    "E150_MPE",
    "iso230_2",
    "measured",
)  # in this order they are added


@dataclass(frozen=True)
class CertifiedU:
    """U of one characteristic, mm or rad, under one prior or with the facts known so far."""

    facts: str
    characteristic: str
    unit: str
    expanded: float


@dataclass(frozen=True)
class CertificateWorth(Readable):
    """by_prior, by_fact: U; coverage: machines at the limit; figures: of the test, of machines sampled as stated.
    warnings: errors left in the counted intervals, such as a known bias.
    """

    stated: str
    by_prior: tuple[CertifiedU, ...]
    by_fact: tuple[CertifiedU, ...]
    coverage: tuple[CoveredMachines, ...]
    figures: tuple[Figure, ...]
    seed: int
    warnings: tuple[str, ...] = ()
    reading: Reading | None = field(default=None, repr=False)

    def __repr__(self) -> str:
        names = first_few(dict.fromkeys(u.characteristic for u in self.by_prior))
        return f"<CertificateWorth of {self.stated}: {names}>"


def certificate_worth(
    path: Path, *, trials: int | None = None, seed: int | None = None, progress: Progress | None = None
) -> CertificateWorth:
    """Compute the value of the certificate of a scenario whose machine states one and no errors of its own. UsageError for another scenario."""
    report = progress or (lambda text, share: None)
    table = certificate_table(path)
    scenario, certificate = load_scenario(path), _drawn_from(path)
    machine = load_machine_of(path)  # without the part's effects
    changes: dict[str, Any] = {k: v for k, v in (("trials", trials), ("seed", seed)) if v is not None}
    settings = scenario.settings.with_changes(certify=CHECK_TRIALS, **changes)
    steps = _facts(table)
    whole = len(PRIORS) + len(steps) + 1
    by_prior, by_fact = [], []
    for i, prior in enumerate(PRIORS):
        report(f"prior {prior}", i / whole)
        by_prior += _certified_rows(prior, path, {**table, "prior": prior}, settings)
    for i, (label, part) in enumerate(steps):
        report(label, (len(PRIORS) + i) / whole)
        by_fact += _certified_rows(label, path, part, settings)
    report("machines at the limit", (whole - 1) / whole)
    limits = {k: v for k, v in table.items() if k != "measured"}
    at_limit = load_scenario(path, certificate={**limits, "prior": "limit"})
    result = _uncertainty(at_limit, settings)
    covered = covered_at_limit(at_limit.machine, replace(certificate, findings=Findings()), result)
    figures = [
        f for test in ("10360-2", "230-2") if certificate.limits(test)
        for f in predict_figures(machine, test, certificate.limits(test), settings.seed, 400)
        if f.limit_um is not None and not (certificate.E0 and f.name.startswith("R "))  # R of an axis holds no probe
    ]  # fmt: skip
    return CertificateWorth(
        certificate.words(), tuple(by_prior), tuple(by_fact),
        coverage=covered, figures=tuple(figures), seed=settings.seed, warnings=result.warnings,
    )  # fmt: skip


def _drawn_from(path: Path) -> MachineCertificate:
    from vcmm.files.own.certificate import certificate_from
    from vcmm.files.own.machine_tables import CertificateTable

    certificate = certificate_from(CertificateTable(**certificate_table(path)))
    drawn = {i.evidence for i in load_scenario(path).machine.inputs}
    if certificate.words() not in drawn:
        raise UsageError(
            "the machine states errors of its own beside its certificate, and they count; vcmm check says how often such a machine keeps it"
        )
    return certificate


def _facts(table: Mapping[str, Any]) -> list[tuple[str, dict[str, Any]]]:
    """Return (words, certificate) from the first limit on, one more fact each."""
    first = next(k for k in FIRST if table.get(k))
    stated = {k: v for k, v in table.items() if k in (first, "prior")}
    steps = [(first, dict(stated))]
    for fact in FACTS:
        if table.get(fact) and fact not in stated:
            stated[fact] = table[fact]
            steps.append((f"+ {fact}", dict(stated)))
    return steps


def _certified_rows(label: str, path: Path, table: dict[str, Any], settings: Settings) -> list[CertifiedU]:
    result = _uncertainty(load_scenario(path, certificate=table), settings)
    return [CertifiedU(label, c.name, c.unit, c.expanded) for c in result.characteristics]


def _uncertainty(scenario: Scenario, settings: Settings) -> UncertaintyResult:
    return evaluate(scenario.task(), settings)
