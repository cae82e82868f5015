"""The audit of intervals as a table."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, cast

from vcmm.show.tables.quantities import SIZE, percent
from vcmm.show.tables.table import COUNT, WORDS, Column, ResultTable, entry, records

if TYPE_CHECKING:
    from vcmm.answer.inference.audit import AuditResult


def verdict(a: AuditResult) -> str:
    """Return the verdict: inside its band, outside it by no more than such a count errs, outside, or not claimed."""
    if not a.claimed:
        return "not claimed"
    if a.outside:
        return "outside"
    return "inside" if a.p_value == 1.0 else "within counting error"


def _in_words(a: AuditResult) -> str:
    """Return the verdict, with the probability of the exact binomial test where the count lies outside."""
    return verdict(a) if a.p_value == 1.0 or not a.claimed else f"{verdict(a)} (p = {a.p_value:.2g})"


AUDIT: tuple[Column[AuditResult], ...] = (
    Column("characteristic", lambda a: a.name, key="name", csv="characteristic"),
    Column("parts drawn from", lambda a: a.kind, WORDS, key="kind", csv="kind"),
    Column("target", lambda a: a.target, percent(0), key="target", csv="target"),
    Column("attained", lambda a: a.attained, percent(1), key="attained", csv="attained"),
    entry("attained_interval95", lambda a: list(a.interval95)),
    Column("parts", lambda a: a.parts, COUNT, key="parts", csv="parts"),
    Column("mean width", lambda a: a.width, SIZE, key="mean_width_{unit}"),
    Column("theoretical best", lambda a: a.oracle, SIZE, key="oracle_width_{unit}"),
    entry("oracle_attained", lambda a: a.oracle_held),
    entry("claimed", lambda a: a.claimed),
    entry("why_not_claimed", lambda a: a.why or None),
    Column("band", lambda a: f"{a.least:.2f} to {a.most:.2f}", WORDS),
    entry("band", lambda a: [a.least, a.most]),
    Column("verdict", _in_words, WORDS),
    Column(None, verdict, WORDS, key="verdict", csv="verdict"),
    Column(None, lambda a: a.p_value, key="p_value", csv="p_value"),
)


def audit_table(rows: Sequence[AuditResult]) -> ResultTable[AuditResult]:
    caption = (
        "Share of drawn parts whose true value lies in their interval; form is given in units of the machine's noise. Verdicts: "
        "exact binomial test against the nearer end of the band; outside below 2.5 %. The theoretical best knows the family of forms of every part "
        "and how their sizes are spread."
    )
    return ResultTable("coverage, counted", AUDIT, rows, caption)


def missing_claims(rows: Sequence[AuditResult]) -> list[str]:
    """Return a sentence per characteristic that claims nothing."""
    return list(dict.fromkeys(f"{a.name} is not claimed: {a.why}" for a in rows if a.why))


def audit_json(rows: Sequence[AuditResult]) -> dict[str, Any]:
    """Return the body of the JSON document."""
    return {"audit": records(AUDIT, rows)}


@dataclass(frozen=True)
class OfTask:
    """A row of the audit of one of several tasks."""

    file: str
    audit: AuditResult

    @property
    def unit(self) -> str:
        return self.audit.unit


def _of_task(column: Column[AuditResult]) -> Column[OfTask]:
    cell = column.cell
    return replace(cast(Any, column), cell=lambda row: cell(row.audit))


TASKS: tuple[Column[OfTask], ...] = (
    Column("task", lambda r: r.file, csv="task"),
    *(_of_task(c) for c in AUDIT),
)


def tasks_table(rows: Sequence[OfTask]) -> ResultTable[OfTask]:
    plain = audit_table([])
    return ResultTable(plain.title, TASKS, rows, plain.caption)


def tasks_json(
    rows: Sequence[OfTask], files: Sequence[str], refused: Mapping[str, str]
) -> list[dict[str, Any]]:
    """Return, per task, its audit, or why there is none."""
    return [
        {
            "file": f,
            "problem": refused.get(f),
            "audit": records(AUDIT, [r.audit for r in rows if r.file == f]),
        }
        for f in files
    ]
