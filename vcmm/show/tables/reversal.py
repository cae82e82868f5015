"""Reversals as a table."""

from __future__ import annotations

from collections.abc import Sequence
from typing import TYPE_CHECKING

from vcmm.learn.calibration.spindle import ANGLE
from vcmm.show.tables.quantities import DASH, fixed
from vcmm.show.tables.table import Column, ResultTable, listing

if TYPE_CHECKING:
    from vcmm.learn.calibration.acceptance import Figure
    from vcmm.learn.calibration.reversal import ReversalResult


def reversals(results: Sequence[ReversalResult]) -> ResultTable[Sequence[str]]:
    """Return every error that was separated, with its u and the artefact beside it."""
    rows = []
    for result in results:
        for row in result.rows():
            size = f"{row['value']:+.4g}" if "value" in row else f"{row['low']:+.4g} to {row['high']:+.4g}"
            unit, u = row["unit"], float(str(row["u"]))
            rows.append(
                (result.file.name, result.file.kind, str(row["error"]), f"{size} {unit}", f"{u:.2g} {unit}")
            )
    return listing(
        "errors separated from the artefact", ("recording", "test", "error", "from ... to", "u"), rows
    )


def _nm(value: float | None, unit: str) -> str:
    """Return a figure given in um, as nm, or in urad with three digits."""
    if value is None:
        return DASH
    return f"{value:.3g} µrad" if unit else f"{value * 1e3:.3g} nm"


def _unit(row: Figure) -> str:
    return "urad" if row.name.endswith(ANGLE) else ""


SPINDLE: tuple[Column[Figure], ...] = (
    Column("figure", lambda row: row.name.removesuffix(ANGLE)),
    Column("value", lambda row: _nm(row.value_um, _unit(row))),
    Column("u", lambda row: _nm(row.u_um, _unit(row))),
    Column("limit", lambda row: _nm(row.limit_um, _unit(row))),
    Column("probability to pass", lambda row: row.p_pass, fixed(3)),
)


def spindle_figures(figures: Sequence[Figure]) -> ResultTable[Figure]:
    """Return ISO 230-7 values of a turning axis, nm and urad."""
    return ResultTable("ISO 230-7", SPINDLE, figures)
