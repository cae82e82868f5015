"""A thermal model as a table: its terms with amounts, lags and their uncertainties."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from typing import TYPE_CHECKING

import numpy as np

from vcmm.core.effect import parameter
from vcmm.core.units import parse_unit
from vcmm.show.report.text import unit_word
from vcmm.show.tables.quantities import fixed
from vcmm.show.tables.table import Column, ResultTable, Writing

if TYPE_CHECKING:
    from vcmm.files.learned.thermal_terms import WrittenTerms
    from vcmm.learn.calibration.thermal import ThermalModel


@dataclass(frozen=True)
class TermRow:
    """One number of an effect in the unit of its file; u None: taken as it is."""

    effect: str
    where: str
    parameter: str
    unit: str
    value: float
    u: float | None


def term_rows(model: ThermalModel, written: WrittenTerms) -> list[TermRow]:
    """Return every amount and lag that is written, with its u; also lags without u."""
    numbers = {(e.id, name): k for e, name, k in written.numbers}
    rows = []
    for effect in written.effects:
        for name in _parameters(effect):
            spec = parameter(effect, name)
            factor = parse_unit(spec.metadata["unit"]).factor
            k = numbers.get((effect.id, name))
            u = None if k is None else float(np.sqrt(model.covariance[k, k])) / factor
            value = float(getattr(effect, spec.name)) / factor
            rows.append(TermRow(effect.name, effect.where, name, spec.metadata["unit"], value, u))
    return rows


def _parameters(effect: object) -> list[str]:
    return [n for n in ("k", "tau", "k_slow", "tau_slow", "alpha", "amplitude") if n in vars(effect)]


TERMS: tuple[Column[TermRow], ...] = (
    Column("effect", lambda row: row.effect, key="effect"),
    Column("where", lambda row: row.where, key="where"),
    Column("number", lambda row: row.parameter, key="parameter"),
    Column("value", lambda row: row.value, fixed(3), key="value"),
    Column("u", lambda row: row.u, fixed(3), key="u"),
    Column("unit", lambda row: row.unit, Writing(lambda unit, _: unit_word(unit), words=True), key="unit"),
)


def terms(rows: Sequence[TermRow]) -> ResultTable[TermRow]:
    """Return the numbers of a thermal model."""
    return ResultTable("What temperatures do", TERMS, rows)
