"""A measured part against its prediction as tables: characteristics side by side, and covariates of the difference."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

from vcmm.shop.machining.significance import LEAST_P
from vcmm.show.tables.quantities import DEVIATION, LENGTH, SIZE, fixed
from vcmm.show.tables.table import NUMBER_TEXT, Column, ResultTable, entry, records

if TYPE_CHECKING:
    from vcmm.shop.machining.measured_part import BesidePrediction, MeasuredCut
    from vcmm.shop.machining.mismatch import MismatchEntry

PREDICTION_COLUMNS: tuple[Column[BesidePrediction], ...] = (
    Column("characteristic", lambda r: r.name, key="name"),
    Column("nominal", lambda r: r.nominal, LENGTH),
    Column("measured", lambda r: r.measured - r.nominal, DEVIATION),
    Column("predicted", lambda r: r.prediction - r.nominal, DEVIATION),
    Column("u of the difference", lambda r: r.u, SIZE, key="u_difference_{unit}"),
    Column("E_n", lambda r: r.e_n, fixed(2), key="E_n"),
    entry("measured_{unit}", lambda r: r.measured),
    entry("predicted_{unit}", lambda r: r.prediction),
)
MISMATCH: tuple[Column[MismatchEntry], ...] = (
    Column("feature", lambda m: m.feature, key="feature"),
    Column("line", lambda m: m.line, NUMBER_TEXT, key="line"),
    Column("goes with", lambda m: m.covariate, key="covariate"),
    Column("p", lambda m: f"{m.p:.1g}" if m.p > 0 else f"< {LEAST_P:.0g}", NUMBER_TEXT),
    entry("p", lambda m: m.p),
    entry("rms_um", lambda m: m.rms * 1e3),
    Column("what", lambda m: m.text, key="text"),
)


def prediction_table(cut: MeasuredCut) -> ResultTable[BesidePrediction]:
    return ResultTable("measured against predicted, from nominal", PREDICTION_COLUMNS, list(cut.comparisons))


def mismatch(cut: MeasuredCut) -> ResultTable[MismatchEntry]:
    return ResultTable("where the part departs from its prediction", MISMATCH, cut.mismatch)


def measured_json(cut: MeasuredCut) -> dict[str, Any]:
    """Return keys of the document: measured, mismatch, scatter_um."""
    return {
        "measured": records(PREDICTION_COLUMNS, list(cut.comparisons)),
        "mismatch": records(MISMATCH, list(cut.mismatch)),
        "scatter_um": cut.scatter * 1e3,
    }
