"""Measurements for second routes: repeats of a calibrated part, repeats in several positions, standards.

calibrated.csv  characteristic, value_mm, U_um, k: what its certificate says; from_part_um: u of form and roughness from part to part
repeats.csv     characteristic, value_mm: one row per repeat of the calibrated part; temp_part_C: its temperature
positions.csv   position, characteristic, value_mm: one row per repeat of the part itself
standards.csv   standard (length, centres, ring, sphere), name, calibrated_mm, U_um, k, reading_mm: one row per reading
values.csv      characteristic, value_mm: the part itself, once (as for `evaluate`)

Values may be deviation_um or value_deg as in values.csv. Angles have U_deg.
"""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from unicodedata import normalize

import numpy as np

from vcmm.answer.inference.given_points import GivenValue
from vcmm.answer.inference.job import absolute_values
from vcmm.answer.routes.calibrated_part import CalibratedValue
from vcmm.answer.routes.job import RouteData
from vcmm.answer.routes.positions import STANDARDS, StandardReadings
from vcmm.core.errors import DataError, UsageError, choose_from
from vcmm.core.units import UNITS
from vcmm.files.own.measured_data import (
    ANGLES,
    LENGTHS,
    ValueColumn,
    check_columns,
    read_measured_values,
    value_column,
    value_in,
)
from vcmm.files.sheets import Sheet, instead, read_csv
from vcmm.task.measuring.scenario import Scenario

TEMPERATURE = "temp_part_C"
MISSING_WORDS = frozenset(
    {"nan", "na", "n/a", "null", "none", "inf", "-inf"}
)  # what spreadsheets and pandas write for no value
LEAST_K, MOST_K = 1.0, 5.0
LEAST_U = 1e-9  # mm or rad: 1 pm, a hundredth of an atom


def read_route_data(
    scenario: Scenario,
    *,
    calibrated: Path | None = None,
    repeats: Path | None = None,
    positions: Path | None = None,
    standards: Path | None = None,
    values: Path | None = None,
) -> RouteData:
    """Read all files of a comparison of routes. DataError with file and line; UsageError for one half of a pair."""
    if (calibrated is None) != (repeats is None):
        raise UsageError(
            "the route by a calibrated part takes --calibrated calibrated.csv (its certificate) and --repeats repeats.csv (what you "
            "measured of it); one of the two is missing"
        )
    if standards is not None and positions is None:
        raise UsageError(
            "--standards belong to --positions: the route by several positions takes their errors off"
        )
    repeated = _repeats(scenario, repeats) if repeats else ({}, {})
    calibrations = _calibrations(scenario, calibrated) if calibrated else {}
    if repeats and calibrated:
        _check_pairs(repeats, calibrated, set(repeated[0]), set(calibrations))
    readings: dict[str, float] = {}
    for part in read_measured_values(values) if values else ():
        for v in part:
            if v.name in readings:
                raise DataError(f'{v.where}: several parts have "{v.name}"; compare the routes for one part')
            readings |= absolute_values(scenario, [v])
    return RouteData(
        readings=readings, calibrations=calibrations, repeats=repeated[0], temperatures=repeated[1],
        positions=_positions(scenario, positions) if positions else {},
        standards=_standards(standards) if standards else (),
    )  # fmt: skip


def _check_pairs(repeats: Path, calibrated: Path, measured: set[str], calibrated_names: set[str]) -> None:
    problems = [
        f'{repeats}: no repeats of "{n}", which {calibrated} has calibrated'
        for n in sorted(calibrated_names - measured)
    ]
    problems += [
        f'{calibrated}: no calibrated value of "{n}", which {repeats} has measured'
        for n in sorted(measured - calibrated_names)
    ]
    if problems:
        raise DataError(problems)


def _rows(path: Path, needed: Sequence[str], allowed: Sequence[str]) -> tuple[Sheet, list[GivenValue]]:
    """Return the sheet and the value of every row."""
    sheet = read_csv(path)
    columns = [c for c in (value_column(name) for name in sheet.header) if c is not None]
    check_columns(
        sheet, ["characteristic", *needed], ["characteristic", *needed, *allowed, *(c.name for c in columns)],
        ["characteristic", "value_mm", "deviation_um", "value_deg", *needed, *allowed],
    )  # fmt: skip
    if not columns:
        raise DataError(
            f"{path}:{sheet.header_line}: there is no column of values; add value_mm (deviation_um, value_deg)"
        )
    names = sheet.words("characteristic")
    return sheet, [_given_value(sheet, i, name, columns) for i, name in enumerate(names)]


def _given_value(sheet: Sheet, i: int, name: str, columns: Sequence[ValueColumn]) -> GivenValue:
    filled = [c for c in columns if sheet.rows[i][sheet.header.index(c.name)]]
    if len(filled) != 1:
        raise DataError(f'{sheet.at(i)}: "{name}" has {len(filled)} values; expected one number in its row')
    try:
        return value_in(sheet, i, name, "", filled[0])
    except ValueError:
        cell = sheet.rows[i][sheet.header.index(filled[0].name)]
        raise DataError(
            f'{sheet.at(i)}: "{cell}" in column {filled[0].name} is not a finite number{instead(cell, filled[0].name)}'
        ) from None


def _collect_values(scenario: Scenario, given: Sequence[GivenValue]) -> list[tuple[str, float]]:
    """Return (characteristic, mm or rad) of every row; the error names all implausible values at once."""
    out: list[tuple[str, float]] = []
    problems: list[str] = []
    for v in given:
        try:
            out.append((v.name, absolute_values(scenario, [v])[v.name]))
        except DataError as error:
            problems += error.problems
    if problems:
        raise DataError(problems)
    return out


def _repeats(scenario: Scenario, path: Path) -> tuple[dict[str, np.ndarray], dict[str, float]]:
    sheet, given = _rows(path, (), (TEMPERATURE,))
    rows = _collect_values(scenario, given)
    names = list(dict.fromkeys(n for n, _ in rows))
    repeats = {name: np.array([v for n, v in rows if n == name]) for name in names}
    single = [n for n, v in repeats.items() if len(v) < 2]
    if single:
        raise DataError(
            f'{path}: "{single[0]}" was measured once; the scatter of the procedure is seen from 2 repeats on, ISO 15530-3 asks for 20'
        )
    if TEMPERATURE not in sheet.header:
        return repeats, {}
    warm = sheet.numbers(TEMPERATURE)
    return repeats, {n: float(np.mean([t for t, (m, _) in zip(warm, rows) if m == n])) for n in names}


def _calibrations(scenario: Scenario, path: Path) -> dict[str, CalibratedValue]:
    head = read_csv(path).header
    widths = [h for h in head if h.partition("_")[0] == "U" and h.partition("_")[2] in (*LENGTHS, *ANGLES)]
    more = [h for h in head if h.startswith("from_part_") and h[10:] in (*LENGTHS, *ANGLES)]
    if len(widths) != 1:
        raise DataError(
            f"{path}:1: the certificate states U: expected one column U_um (U_mm, U_deg), beside the column k of its coverage factor"
        )
    sheet, given = _rows(path, (*widths, "k"), more)
    rows = _collect_values(scenario, given)
    u = _standard_u(sheet, widths[0])
    from_part = sheet.numbers(more[0]) * UNITS[more[0][10:]][0] if more else np.zeros(len(rows))
    twice = [i for i, (n, _) in enumerate(rows) if n in [m for m, _ in rows[:i]]]
    if twice:
        raise DataError(f'{sheet.at(twice[0])}: "{rows[twice[0]][0]}" is calibrated twice; keep one row')
    return {n: CalibratedValue(v, float(u[i]), float(from_part[i])) for i, (n, v) in enumerate(rows)}


def _standard_u(sheet: Sheet, column: str) -> np.ndarray:
    """Return U / k of every row, mm or rad."""
    expanded, k = sheet.numbers(column) * UNITS[column.partition("_")[2]][0], sheet.numbers("k")
    problems = [
        f"{sheet.at(i)}: k = {k[i]:g} is no coverage factor; certificates have 2 (1 for a standard uncertainty)"
        for i in map(int, np.flatnonzero((k < LEAST_K) | (k > MOST_K)))
    ]
    problems += [
        f"{sheet.at(i)}: {column} = {sheet.words(column)[i]}; an uncertainty is above zero"
        for i in map(int, np.flatnonzero(expanded <= 0))
    ]
    problems += [
        f"{sheet.at(i)}: {column} = {sheet.words(column)[i]} is smaller than anything that can be measured; check its unit"
        for i in map(int, np.flatnonzero((expanded > 0) & (expanded < LEAST_U)))
    ]
    if problems:
        raise DataError(problems)
    return np.asarray(expanded / k)


def is_unclear_label(label: str) -> bool:
    """Return whether a label is how programs write a missing value, or changes where lookalike characters become plain ones (NFKC)."""
    return label.casefold() in MISSING_WORDS or normalize("NFKC", label) != label


def _positions(scenario: Scenario, path: Path) -> dict[str, dict[str, np.ndarray]]:
    sheet, given = _rows(path, ("position",), ())
    rows = _collect_values(scenario, given)
    places = sheet.words("position")
    unclear = [i for i, p in enumerate(places) if is_unclear_label(p)]
    if unclear:
        raise DataError(
            [
                f'{sheet.at(i)}: "{places[i]}" does not name a position: a missing value, or characters that only look like others; '
                "write its number or name"
                for i in unclear
            ]
        )
    out: dict[str, dict[str, np.ndarray]] = {}
    for name in dict.fromkeys(n for n, _ in rows):
        at = [i for i, (n, _) in enumerate(rows) if n == name]
        out[name] = {
            p: np.array([rows[i][1] for i in at if places[i] == p])
            for p in dict.fromkeys(places[i] for i in at)
        }
        if len(out[name]) < 2:
            raise DataError(
                f'{path}: "{name}" was measured in one position; errors that stay with the position are seen from 2 on, 4 are usual'
            )
    return out


def _standards(path: Path) -> list[StandardReadings]:
    sheet = read_csv(path)
    needed = ("standard", "calibrated_mm", "U_um", "k", "reading_mm")
    check_columns(sheet, needed, ("name", *needed))
    u, size, read = _standard_u(sheet, "U_um"), sheet.numbers("calibrated_mm"), sheet.numbers("reading_mm")
    kinds = sheet.words("standard")
    problems = [
        f'{sheet.at(i)}: standard "{k}".{choose_from(k, STANDARDS)}'
        for i, k in enumerate(kinds)
        if k not in STANDARDS
    ]
    problems += [
        f"{sheet.at(i)}: read {read[i]:g} mm of {size[i]:g} mm: more than a hundredth off; check the columns"
        for i in range(len(kinds)) if not abs(read[i] - size[i]) <= 0.01 * size[i]
    ]  # fmt: skip
    if problems:
        raise DataError(problems)
    named = sheet.words("name") if "name" in sheet.header else kinds
    groups = list(dict.fromkeys(zip(kinds, named, size.tolist(), u.tolist())))
    return [
        StandardReadings(
            g[0],
            g[2],
            g[3],
            np.array([read[i] for i in range(len(kinds)) if (kinds[i], named[i], size[i], u[i]) == g]),
        )
        for g in groups
    ]
