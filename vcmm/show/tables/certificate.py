"""Value of a certificate, as tables."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vcmm.show.tables.calibration import FIGURES
from vcmm.show.tables.quantities import SIZE, percent
from vcmm.show.tables.table import COUNT, WORDS, Column, ResultTable, records

if TYPE_CHECKING:
    from vcmm.answer.evaluation.at_limit import CoveredMachines
    from vcmm.files.learned.certificate_comparison import CertificateWorth, CertifiedU
    from vcmm.learn.calibration.acceptance import Figure

U_KNOWN: tuple[Column[CertifiedU], ...] = (
    Column("known", lambda r: r.facts, WORDS, key="known", csv="known"),
    Column("characteristic", lambda r: r.characteristic, WORDS, key="characteristic", csv="characteristic"),
    Column("U", lambda r: r.expanded, SIZE, key="U_{unit}", csv="U_{unit}", page_head="U / {small}"),
)

COVERAGE_COLUMNS: tuple[Column[CoveredMachines], ...] = (
    Column("characteristic", lambda r: r.characteristic, WORDS, key="characteristic", csv="characteristic"),
    Column("machines", lambda r: r.kind, WORDS, key="machines", csv="machines"),
    Column("counted", lambda r: r.machines, COUNT, key="counted", csv="counted"),
    Column("covered", lambda r: r.share, percent(1), key="covered", csv="covered"),
)


def worth_tables(w: CertificateWorth) -> tuple[ResultTable[Any], ...]:
    """Return U by prior, U by fact, coverage of machines at the limit, figures of the test."""
    u = "half the 95 % interval"
    figures: ResultTable[Figure] = ResultTable(
        "a machine drawn so takes the test once more", FIGURES, w.figures,
        "p: how often it passes. A machine at its limit passes about every other time.",
    )  # fmt: skip
    return (
        ResultTable("U under every prior over machines", U_KNOWN, w.by_prior, f"U: {u}."),
        ResultTable("U with every further fact", U_KNOWN, w.by_fact, "Prior as stated in the file."),
        ResultTable(
            "machines at the limit, counted", COVERAGE_COLUMNS, w.coverage,
            "Share of machines whose measurement lies so that the interval of prior limit about it holds the true value.",
        ),
        figures,
    )  # fmt: skip


def worth_json(w: CertificateWorth) -> dict[str, Any]:
    """Return the body of the JSON document."""
    return {
        "stated": w.stated, "by_prior": records(U_KNOWN, w.by_prior), "by_fact": records(U_KNOWN, w.by_fact),
        "at_limit": records(COVERAGE_COLUMNS, w.coverage), "figures": records(FIGURES, w.figures),
    }  # fmt: skip
