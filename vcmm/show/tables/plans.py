"""A chosen measuring plan as a table: U of every characteristic against measuring time."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING

from vcmm.part.gps.characteristics import unit
from vcmm.show.tables.quantities import deviation_text, fixed, small
from vcmm.show.tables.table import Column, ResultTable, Writing

if TYPE_CHECKING:
    from vcmm.answer.placing.planning import PlanPoint, PlanResult
    from vcmm.task.measuring.scenario import Scenario


@dataclass(frozen=True)
class CurvePoint:
    """A plan of the curve; word: "present", "chosen" or nothing."""

    word: str
    plan: PlanPoint


def curve(
    scenario: Scenario, result: PlanResult, plans: Sequence[PlanPoint] | None = None
) -> ResultTable[CurvePoint]:
    """Return the present plan, then those of the curve (or `plans`); the chosen one is marked."""
    units = {c.name: unit(c) for c in scenario.part.characteristics}
    shown = (result.present, *(result.pareto if plans is None else plans))
    rows = [
        CurvePoint("present" if p is result.present else "chosen" if p is result.choice else "", p)
        for p in shown
    ]
    columns: list[Column[CurvePoint]] = [
        Column("", lambda row: row.word),
        Column("minutes", lambda row: row.plan.minutes, fixed(2)),
        Column("points", lambda row: ", ".join(f"{f} {n}" for f, n in row.plan.per_feature.items())),
    ]
    columns += [
        Column(f"U {n}", partial(_plan_uncertainty, n), _of_unit(units[n])) for n in result.choice.expanded
    ]
    caption = f"styli: {', '.join(f'{f} {s}' for f, s in result.styli.items())}"
    on_page = f"U in µm (angles µrad), {caption}."
    return ResultTable("U against measuring time, form of the part included", columns, rows, caption, on_page)


def _plan_uncertainty(name: str, row: CurvePoint) -> float:
    return row.plan.expanded[name]


def _of_unit(unit: str) -> Writing:
    """Return a column of its own unit: its characteristic is a length or an angle in every row."""
    return Writing(
        lambda value, _: deviation_text(value, unit, signed=False), lambda value, _: small(value, unit)
    )
