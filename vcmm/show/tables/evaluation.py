"""Evaluated measured data as tables: measured values, the interval of the true value, the decision."""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from dataclasses import dataclass, replace
from typing import TYPE_CHECKING, Any, cast

from vcmm.answer.evaluation.truth import Additive
from vcmm.part.gps.decision import ACCEPT, UNDECIDED
from vcmm.show.tables.quantities import DEVIATION, LENGTH, SPAN, percent
from vcmm.show.tables.table import Column, ResultTable, csv_text, entry, records
from vcmm.show.tables.uncertainty import (
    DECISION,
    RESULTS,
    decision_text,
    from_nominal,
    p_conform,
    true_value_by_points,
)

if TYPE_CHECKING:
    from vcmm.answer.evaluation.jointly import JointJudgement
    from vcmm.answer.inference.job import EvaluatedCharacteristic, EvaluatedPart


def _of_result(column: Column[Any]) -> Column[EvaluatedCharacteristic]:
    """Return the same column, read from `.result`."""

    def cell(e: EvaluatedCharacteristic) -> Any:
        return column.cell(e.result)

    return replace(column, cell=cell)


def _true_value(e: EvaluatedCharacteristic) -> dict[str, Any] | None:
    """Return the cell `true_value`: by the residuals of the points where every characteristic has some, else as stated."""
    return true_value_by_points(e.result) if e.by_points else TRUE_VALUE.cell(e.result)


TRUE_VALUE = next(c for c in RESULTS if c.key == "true_value")
DOCUMENT: tuple[Column[EvaluatedCharacteristic], ...] = (
    *(entry("true_value", _true_value) if c is TRUE_VALUE else _of_result(c) for c in RESULTS),
    entry("measured_{unit}", lambda e: e.measured),
)

PART_COLUMNS: tuple[Column[EvaluatedCharacteristic], ...] = (
    Column("characteristic", lambda e: e.result.name, csv="characteristic"),
    Column("nominal", lambda e: e.result.nominal, LENGTH),
    Column("measured", lambda e: e.measured, LENGTH),
    Column("deviation", lambda e: e.measured - e.result.nominal, DEVIATION),
    Column("bias", lambda e: e.result.bias, DEVIATION),
    Column("true value from nominal", lambda e: from_nominal(e.result.interval, e.result), SPAN),
    Column("tolerance", lambda e: from_nominal(e.result.tolerance, e.result), SPAN),
    Column("decision", lambda e: decision_text(e.result), DECISION),
    Column("p", lambda e: p_conform(e.result), percent(1)),
)


def _columns(parts: Sequence[EvaluatedPart]) -> tuple[tuple[Column[EvaluatedCharacteristic], ...], str, str]:
    """Return columns, name of the interval, caption: true values are not mentioned where a known bias is left in."""
    evaluated = [e for p in parts for e in p.characteristics]
    note = LEFT_IN * any(_bias_left_in(e) for e in evaluated) + SPREAD * any(
        _spread_alone(e) for e in evaluated
    )
    if not any(_spread_alone(e) for e in evaluated):
        return PART_COLUMNS, "the {:.0%} interval of the true value", CAPTION + note
    heads = {"true value from nominal": "interval from nominal"}
    columns = tuple(replace(c, head=heads.get(str(c.head), c.head)) for c in PART_COLUMNS)
    return columns, "its {:.0%} interval", CAPTION + note


def _bias_left_in(e: EvaluatedCharacteristic) -> bool:
    return e.result.bias_in_U > 0.0


def _spread_alone(e: EvaluatedCharacteristic) -> bool:
    """Return whether the interval of an extreme value is the scatter of the indicated one: no parts can be sampled (on a mesh)."""
    return e.result.extreme and isinstance(e.result.truth, Additive)


SPREAD = (
    " Of a surface of a mesh the interval is the scatter of the indicated value; the true value is unknown."
)
LEFT_IN = " Where a known bias is not corrected (see the notes) the interval holds it too: U + |bias| about the indicated value."
CAPTION = "Departures from nominal. p: probability that the true value is within its limits."


def part_table(part: EvaluatedPart) -> ResultTable[EvaluatedCharacteristic]:
    """Return the table characteristic | nominal | measured | deviation | bias | true value | tolerance | decision | p."""
    first = part.characteristics[0].result
    name = f'part "{part.part}": ' if part.part else ""
    columns, interval, caption = _columns([part])
    title = f"{name}measured, and {interval.format(first.p)}"
    return ResultTable(title, columns, part.characteristics, caption)


@dataclass(frozen=True)
class OfPart:
    """A row of several parts in one table: a characteristic, or the whole part."""

    part: str
    of: Any

    @property
    def unit(self) -> str:
        return str(getattr(self.of, "unit", ""))


def _of_part(column: Column[Any]) -> Column[OfPart]:
    cell = column.cell
    return replace(cast(Any, column), cell=lambda row: cell(row.of))


def batch(parts: Sequence[EvaluatedPart]) -> ResultTable[OfPart]:
    """Return several parts in one table: part | characteristic | measured | deviation | ..."""
    rows = [OfPart(p.part, e) for p in parts for e in p.characteristics]
    of_one, interval, caption = _columns(parts)
    columns = (Column("part", lambda r: r.part), *(_of_part(c) for c in of_one if c.head != "nominal"))
    title = f"{len(parts)} parts: measured, and {interval.format(rows[0].of.result.p)}"
    return ResultTable(title, columns, rows, caption)


def wholes(parts: Sequence[EvaluatedPart]) -> list[str]:
    """Return all tolerances of every part together, in a sentence per decision."""
    judged: dict[str, list[str]] = {}
    for part in parts:
        if part.joint is not None:
            judged.setdefault(part.joint.decision, []).append(part.part)
    return [
        f"all tolerances together: {len(names)} of {len(parts)} parts: {decision} ({', '.join(names)})"
        for decision, names in judged.items()
    ]


def evaluate_json(parts: Sequence[EvaluatedPart]) -> dict[str, Any]:
    """Return the body of the JSON document: as of `uncertainty` for one part, a list of parts for several."""
    trials = parts[0].uncertainty.trials
    if len(parts) == 1 and not parts[0].part:
        return {
            "trials": trials,
            "characteristics": records(DOCUMENT, parts[0].characteristics),
            **joint_json(parts[0].joint),
        }
    listed = [
        {"part": p.part, "characteristics": records(DOCUMENT, p.characteristics), **joint_json(p.joint)}
        for p in parts
    ]
    return {"trials": trials, "parts": listed}


def joint_json(joint: JointJudgement | None) -> dict[str, Any]:
    """Return the key `joint`: null with fewer than two tolerances."""
    if joint is None:
        return {"joint": None}
    is_known = not joint.reason
    return {
        "joint": {
            "characteristics": list(joint.names),
            "p_conform_least": joint.least if is_known else None,
            "p_conform_most": joint.most if is_known else None,
            "p_independent": joint.independent if is_known else None,
            "decision": joint.decision,
            "reason": joint.reason or None,
        }
    }


def joint_words(joint: JointJudgement | None) -> list[str]:
    """Return the part as a whole in one sentence; none with fewer than two tolerances."""
    if joint is None:
        return []
    if joint.reason:
        return [f"all {len(joint.names)} tolerances together: {joint.decision}, {joint.reason}"]
    least, most = f"{joint.least:.1%}", f"{joint.most:.1%}"
    p = least if least == most else f"between {least} and {most}"
    why = " (not every tolerance is decided by itself)" * (
        joint.decision == UNDECIDED and joint.least >= ACCEPT
    )
    return [f"all {len(joint.names)} tolerances together: {joint.decision}, probability {p}{why}"]


def values_csv(parts: Sequence[EvaluatedPart]) -> str:
    """Return one row per part and characteristic."""
    rows = [(p.part, e) for p in parts for e in p.characteristics]
    return csv_text(ResultTable("", FILE, rows))


def _true_end(e: EvaluatedCharacteristic, end: int) -> str:
    """Return an end of the interval of the true value, mm or rad; empty where the interval is of the indicated value."""
    return "" if _spread_alone(e) else f"{e.result.interval[end]:.9f}"


FILE: tuple[Column[Any], ...] = (
    Column(None, lambda r: r[0], csv="part"),
    Column(None, lambda r: r[1].result.name, csv="characteristic"),
    Column(None, lambda r: r[1].unit, csv="unit"),
    Column(None, lambda r: r[1].measured, csv="measured", file=lambda v, u: f"{v:.9f}"),
    Column(None, lambda r: _true_end(r[1], 0), csv="true_low"),
    Column(None, lambda r: _true_end(r[1], 1), csv="true_high"),
    Column(None, lambda r: decision_text(r[1].result) or "", csv="decision"),
    Column(None, lambda r: p_conform(r[1].result), csv="p_conform"),
)


def warnings_of_parts(parts: Sequence[EvaluatedPart]) -> list[str]:
    """Return the warnings common to all parts once; names precede those of some parts only."""
    return told_once([(p.part, p.warnings) for p in parts])


def told_once(of_parts: Sequence[tuple[str, Iterable[str]]]) -> list[str]:
    """Return sentences by part, each one once: with the names of the parts that it is about, unless it is about all."""
    names_of: dict[str, list[str]] = {}
    for name, sentences in of_parts:
        for text in dict.fromkeys(sentences):
            names_of.setdefault(text, []).append(name)
    return [
        text if len(names) == len(of_parts) else "part " + ", ".join(f'"{n}"' for n in names) + f": {text}"
        for text, names in names_of.items()
    ]
