"""One virtual measurement as tables: the characteristics, and every point."""

from __future__ import annotations

from collections.abc import Callable
from dataclasses import dataclass
from functools import partial
from typing import TYPE_CHECKING, Any

from vcmm.show.tables.quantities import DEVIATION, LENGTH, in_file
from vcmm.show.tables.table import Column, ResultTable, csv_text, entry, records

if TYPE_CHECKING:
    from vcmm.answer.evaluation.virtual_measurement import MeasuredValue, Measurement
    from vcmm.core.run import Array

VALUES: tuple[Column[MeasuredValue], ...] = (
    Column("characteristic", lambda v: v.name, key="name"),
    Column("type", lambda v: v.type, key="type"),
    Column("nominal", lambda v: v.nominal, LENGTH, key="nominal_{unit}"),
    Column("value", lambda v: v.value, LENGTH, key="value_{unit}"),
    Column("deviation", lambda v: v.value - v.nominal, DEVIATION),
)


@dataclass(frozen=True, eq=False)
class MeasuredPoint:
    """A point of the part, drawing frame: nominal, measured, normal (3,) mm; error (mm) along the normal."""

    feature: str
    nominal: Array
    measured: Array
    normal: Array
    error: float


def _axes(heading: str, of: Callable[[Any], Array]) -> tuple[Column[Any], ...]:
    """Return three columns of a file, for x, y and z."""
    return tuple(
        Column(None, partial(_component, of, i), csv=heading.format(c), file=in_file(9))
        for i, c in enumerate("xyz")
    )


def _component(of: Callable[[Any], Array], axis: int, row: Any) -> float:
    return float(of(row)[axis])


POINTS: tuple[Column[MeasuredPoint], ...] = (
    Column(None, lambda p: p.feature, key="feature", csv="feature"),
    entry("nominal_mm", lambda p: p.nominal.tolist()),
    entry("measured_mm", lambda p: p.measured.tolist()),
    *_axes("measured_{}_mm", lambda p: p.measured),
    *_axes("nominal_{}_mm", lambda p: p.nominal),
    *_axes("n{}", lambda p: p.normal),
    entry("error_mm", lambda p: p.error),
    Column(None, lambda p: p.error, csv="error_um", file=in_file(6, 1e3)),
)


def values(measurement: Measurement) -> ResultTable[MeasuredValue]:
    return ResultTable("measured once, drawing frame", VALUES, measurement.values)


def points(measurement: Measurement) -> list[MeasuredPoint]:
    m = measurement
    return [
        MeasuredPoint(feature, m.nominal_points[i], m.points[i], m.normals[i], float(m.errors[i]))
        for i, feature in enumerate(m.features)
    ]


def measure_json(measurement: Measurement) -> dict[str, Any]:
    """Return the body of the JSON document: characteristics with value only, and points."""
    return {
        "characteristics": records(VALUES, measurement.values),
        "points": records(POINTS, points(measurement)),
    }


def points_csv(measurement: Measurement) -> str:
    return csv_text(ResultTable("", POINTS, points(measurement)))
