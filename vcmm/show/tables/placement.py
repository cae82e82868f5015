"""A placement as tables: poses compared, reasons, certainty; of a measured part, of a cut part, and of the choice of a machine and of a plan."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any, Literal

from vcmm.answer.placing.words import UNITS, amount, changes, goal_text, poses, region_text
from vcmm.part.gps.characteristics import unit
from vcmm.show.tables.quantities import (
    DEVIATION,
    LEAST_SMALL,
    SHARE,
    departure_on_page,
    deviation_text,
    fixed,
    percent,
)
from vcmm.show.tables.table import Column, ResultTable, Writing, entry, listing
from vcmm.show.tables.uncertainty import p_conform

if TYPE_CHECKING:
    from vcmm.answer.evaluation.result import CharacteristicResult
    from vcmm.answer.placing.planning import PlanPoint, PlanResult
    from vcmm.answer.placing.result import PlacementResult
    from vcmm.core.run import Array
    from vcmm.shop.machining.placement import PlacedCut
    from vcmm.task.measuring.scenario import Scenario

VALUE = Writing(lambda text, unit: text)  # the objective in the words of its unit


@dataclass(frozen=True, eq=False)
class ComparedPose:
    """A pose (6: mm, rad), the objective there, and its change as a share of the present value (None: no such)."""

    name: str
    pose: Array
    value: float
    against: float | None


def _four_digits(value: float, unit: str) -> str:
    from vcmm.show.report.text import number

    return number(value, 4)


NAME: Column[ComparedPose] = Column("pose", lambda p: p.name)
SHIFT: Column[ComparedPose] = Column("shift mm", lambda p: poses(p.pose)[0], page_head="shift x y z / mm")
TURN: Column[ComparedPose] = Column("turn deg", lambda p: poses(p.pose)[1], page_head="turn x y z / °")


def _value(writing: Writing) -> Column[ComparedPose]:
    return Column("objective", lambda p: p.value, writing)


def _against(decimals: int, on: Literal["both", "terminal"] = "both") -> Column[ComparedPose]:
    return Column("against present", lambda p: p.against, percent(decimals, signed=True), on=on)


def compared_poses(placed: PlacementResult) -> ResultTable[ComparedPose]:
    """Return one row per pose: best of those tried, convenient, present, median, worst."""
    flat = placed.region
    tried = [("found", placed.best.pose, placed.best.value)]
    if flat.convenient is not None:
        tried.append(("convenient", flat.convenient, flat.convenient_value))
    if placed.present is not None:
        tried.append(("present", placed.present.pose, placed.present.value))
    tried += [(f"{n} of the scan", at.pose, at.value) for n, at in (("median", placed.median), ("worst", placed.worst))]  # fmt: skip
    present = placed.present.value if placed.present is not None else 0.0
    rows = [ComparedPose(n, six, v, v / present - 1 if present else None) for n, six, v in tried]  # fmt: skip
    title = f"objective: {goal_text(placed.objective.goal)}; the smaller the better"
    caption = "Median and worst: of even draws over the fixture. Convenient: rounded, and within 2 % of the pose found."
    in_its_unit = Writing(lambda value, unit: amount(value, placed))
    columns = [NAME, SHIFT, TURN, _value(in_its_unit)]
    if placed.confirmation is None:  # else the gain is the confirmed one, and is stated once, above
        columns.append(_against(2))
    return ResultTable(title, columns, rows, page_caption=caption)


@dataclass(frozen=True)
class InfluenceChange:
    """Contribution of one influence to u at two poses, in the words of its unit; change: share of the present u²."""

    characteristic: str
    influence: str
    present: str
    best: str
    change: float


WHY: tuple[Column[InfluenceChange], ...] = (
    Column("characteristic", lambda i: i.characteristic),
    Column("influence", lambda i: i.influence),
    Column("present", lambda i: i.present, VALUE),
    Column("best", lambda i: i.best, VALUE),
    Column("change of u²", lambda i: i.change, percent(1, signed=True)),
)


def why(placed: PlacementResult, most: int = 4) -> ResultTable[InfluenceChange]:
    """Return the contributions at the present and the best pose, the largest changes of each characteristic first."""
    rows = []
    for name, kind, lines, total in changes(placed):
        word, scale = UNITS[kind]
        for k, (what, before, after) in enumerate(lines[:most]):
            here, there = (
                f"{0.0 if u * scale < LEAST_SMALL else u * scale:.3g} {word}" for u in (before, after)
            )
            moved = (after**2 - before**2) / total if total else 0.0
            rows.append(InfluenceChange(name if k == 0 else "", what, here, there, moved))
    title = "why: contributions u_i, present and best pose (up to four largest changes each)"
    return ResultTable(title, WHY, rows)


OTHER_DRAWS = (
    "by other draws with all laws; the table of poses holds what the search saw (U = k u, few draws)"
)


def how_sure(placed: PlacementResult) -> ResultTable[Any]:
    """Return the certificate and flatness, and the gain out of sample where it was confirmed."""
    rows = [["certificate", placed.certificate.text], ["flatness", region_text(placed)]]
    sure = placed.confirmation
    if sure is not None:
        verdict = "confirmed" if sure.is_confirmed else "not confirmed"
        rows.insert(
            0,
            [
                "the gain above",
                f"{verdict} by {sure.trials:,} paired trials that the search never saw, {OTHER_DRAWS}",
            ],
        )
    return listing("how sure, how flat", ["", ""], rows, words=(0, 1))


def compared_cut_poses(placed: PlacedCut) -> ResultTable[ComparedPose]:
    """Return the best pose, the present one, median and worst of the scan."""
    named = (("found", placed.best), ("present", placed.present), ("median of the scan", placed.median), ("worst of the scan", placed.worst))  # fmt: skip
    present = placed.present.value
    rows = [
        ComparedPose(name, at.pose, at.value, at.value / present - 1 if present else None)
        for name, at in named
    ]
    title = "objective: weighted deviations of the cut part as shares of half their tolerance; the smaller the better"
    caption = "Objective: weighted |deviation| as a share of half the tolerance; the smaller the better."
    bare = Writing(lambda value, unit: f"{value:.4g}", _four_digits)
    columns = [NAME, SHIFT, _value(bare), _against(1, on="terminal")]
    return ResultTable(title, columns, rows, page_caption=caption)


@dataclass(frozen=True)
class Gain:
    """Deviations (mm, rad) and probabilities to conform of a characteristic at the present and the best pose."""

    name: str
    unit: str
    present: float
    best: float
    p_present: float | None
    p_best: float | None


GAINS: tuple[Column[Gain], ...] = (
    Column("characteristic", lambda g: g.name, key="name"),
    Column("present", lambda g: g.present, DEVIATION),
    Column("found", lambda g: g.best, DEVIATION),
    Column("p present", lambda g: g.p_present, SHARE, key="p_present", on="terminal"),
    Column("p found", lambda g: g.p_best, SHARE, key="p_best", on="terminal"),
)


def gains(placed: PlacedCut) -> ResultTable[Gain]:
    """Return the gain of each characteristic."""
    before: Sequence[CharacteristicResult] = placed.before.characteristics
    rows = [
        Gain(c.name, unit(c), float(here), float(there), p_conform(b), p_conform(a))
        for c, here, there, b, a in zip(
            placed.characteristics,
            placed.present.deviations,
            placed.best.deviations,
            before,
            placed.after.characteristics,
        )
    ]
    caption = "Deviation by the known errors, µm (angles µrad)."
    title = "deviation by the known errors, and probability to conform"
    return ResultTable(title, GAINS, rows, page_caption=caption)


@dataclass(frozen=True)
class RankedMachine:
    """A machine among those to choose from; first: value on the best one; value None: it cannot take the part."""

    file: str
    name: str
    pose: str
    amount: str
    value: float | None
    first: float


RANKING: tuple[Column[RankedMachine], ...] = (
    Column("machine", lambda r: r.name),
    entry("machine", lambda r: r.file),
    entry("name", lambda r: r.name),
    Column("file", lambda r: r.file),
    Column("pose", lambda r: r.pose),
    Column("objective", lambda r: r.amount, VALUE),
    Column(
        "against the first",
        lambda r: None if r.value is None else r.value / r.first - 1,
        percent(1, signed=True),
    ),
    entry("value", lambda r: r.value),
)


def ranking(order: Sequence[str], results: Mapping[str, Mapping[str, Any]]) -> ResultTable[RankedMachine]:
    """Return the machines in their order, then those that cannot take the part. results: per file name, value, pose and amount."""
    first = results[order[0]]["value"]
    rows = []
    for m in order:
        pose, amount = results[m]["words"]
        rows.append(RankedMachine(m, results[m]["name"], pose, amount, results[m]["value"], first))
    for m, row in results.items():
        if m not in order:
            rows.append(RankedMachine(m, row["name"], "cannot take the part", "–", None, first))
    return ResultTable("machines, the part at the best pose found on each", RANKING, rows)


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
        lambda value, _: deviation_text(value, unit, signed=False),
        lambda value, _: departure_on_page(value, unit),
    )
