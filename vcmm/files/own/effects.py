"""Read [[effects]] tables: built from the declarations of the effect classes, so a new effect needs no code here."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import Field, fields
from typing import Any

import numpy as np

from vcmm.core.axes import axis_of, is_rotary
from vcmm.core.effect import (
    GRIDS,
    LENGTH,
    LETTERS,
    POINTS,
    POSITIONS,
    TEXT,
    Effect,
    kind_of_key,
    parameter_fields,
    place_fields,
    unit_at,
)
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.run import Array
from vcmm.core.units import dimension_of, quantity, shorten, vector
from vcmm.files.problems import Key, TableProblems, misspelt
from vcmm.physics import find
from vcmm.physics.structure.component import CalibrationModes

KeyProblems = list[tuple[Key, str]]  # (key, what is wrong with it)


@contextmanager
def noting(problems: KeyProblems, key: str) -> Iterator[None]:
    try:
        yield
    except TableProblems as error:
        problems.extend(error.found)
    except UsageError as error:
        problems.append((key, str(error)))


def build_effect(table: dict[str, Any]) -> Effect:
    """Convert one [[effects]] table to an Effect. Raises TableProblems naming every wrong key, unit or word."""
    problems: KeyProblems = []
    kind = kind_of(table, problems)
    if kind is None:
        raise TableProblems(problems)
    if issubclass(kind, CalibrationModes):
        raise TableProblems([("effect", f"{kind.name} is made by {CalibrationModes.made_by}; use that")])
    values: dict[str, Any] = {}
    for key, value in table.items():
        if key != "effect":
            with noting(problems, key):
                values[kind.about.aliases.get(key, key)] = _value(kind, key, value, table)
    for place in place_fields(kind):
        if place.name not in table and not may_be_left_out(place):
            problems.append(
                (
                    "",
                    f'effect {kind.name} needs {place.name}; write for example {place.name} = "{place.default}"',
                )
            )
    if not problems:
        with noting(problems, _place_key(kind, table)):
            return kind(**values)
    raise TableProblems(problems)


def may_be_left_out(place: Field[Any]) -> bool:
    """Return whether a place has a meaning when it is not stated: all styli, or a default that the name leaves out."""
    return place.default == "" or bool(place.metadata.get("quiet"))


def kind_of(table: dict[str, Any], problems: KeyProblems) -> type[Effect] | None:
    if "effect" not in table:
        near = misspelt("effect", table) or ' Write for example effect = "backlash"'
        problems.append(("", f'the key "effect" is missing.{near}'))
        return None
    with noting(problems, "effect"):
        return find(str(table["effect"]))
    return None


def _place_key(kind: type[Effect], table: dict[str, Any]) -> str:
    """Return the key that a complaint of the class itself is most likely about."""
    return next((f.name for f in place_fields(kind) if f.name in table), "")


def _value(kind: type[Effect], key: str, value: Any, table: dict[str, Any]) -> Any:
    parameters = {f.name: f for f in parameter_fields(kind)}
    other = {f.name: f for f in fields(kind) if f.name not in parameters and not f.metadata.get("internal")}
    name = kind.about.aliases.get(key, key)
    if name in parameters:
        return _parameter_value(kind, parameters[name], key, value, table)
    if key not in other:
        allowed = [*(n for n in other if n not in parameters), *kind.about.aliases, *parameters]
        raise UsageError(f'unknown key "{key}" of effect {kind.name}.{choose_from(key, allowed)}')
    default = other[key].default
    if other[key].metadata.get("place") and isinstance(default, int):
        return _whole(key, value, default)
    if other[key].metadata.get("place"):
        return _text(key, value, str(default))
    return _further(other[key], value, table)


def _text(key: str, value: Any, example: str) -> str:
    if not isinstance(value, str):
        raise UsageError(
            f'{key} = {shorten(value)} must be a text in quotes; write for example {key} = "{example or shorten(value)}"'
        )
    return value


def _whole(key: str, value: Any, example: int) -> int:
    least = min(example, 1)  # a harmonic of 0 is a constant where the effect has one
    if not isinstance(value, int) or isinstance(value, bool) or value < least:
        raise UsageError(
            f"{key} = {shorten(value)} must be a whole number, {least} or more; write for example {key} = {example}"
        )
    return value


def _parameter_value(
    kind: type[Effect], spec: Field[Any], key: str, value: Any, table: dict[str, Any]
) -> Any:
    component = str(table.get("component", ""))
    check_matters(spec, component, key)
    unit = unit_at(kind, spec.metadata["unit"], component, str(table.get("axis", "")))
    dimension = dimension_of(unit)
    if not spec.metadata["shape"]:
        return quantity(value, dimension, key, f"0.5 {unit}")
    rows = value if isinstance(value, list) and value and all(isinstance(r, str) for r in value) else [value]
    example = "0.1 0.2 0.3" if unit == "1" else f"0.1 0.2 0.3 {unit}"
    numbers = [vector(row, dimension, key, example) for row in rows]
    if spec.metadata["shape"] != "(nodes, 3)":
        return np.concatenate(numbers)
    bad = next((i for i, row in enumerate(numbers) if len(row) != 3), None)
    if bad is not None:
        raise UsageError(
            f'{key}: row {bad + 1} must have three numbers and a unit, as in "0.1 0.2 0.3 {unit}"'
        )
    return np.array(numbers)


def check_matters(spec: Field[Any], component: str, key: str) -> None:
    """Raise UsageError for a parameter that this component does not use: a tilt has no offset."""
    only = spec.metadata["only"]
    if only and axis_of(component) and component[0] not in only:
        allowed = ", ".join(f"{letter}{component[1:]}" for letter in only)
        raise UsageError(f'{key} does nothing for component = "{component}"; it goes with {allowed}')


def _further(spec: Field[Any], value: Any, table: dict[str, Any]) -> Any:
    """Convert keys that are neither place nor parameter by their type: positions carry units, words and counts do not change."""
    key, kind = spec.name, kind_of_key(spec)
    if kind == POSITIONS:
        return _axis_positions(value, axis_of(str(table.get("component", ""))) or str(table.get("axis")), key)
    if key == "process":
        return value  # judged by the effect itself, with its nodes
    if kind == POINTS:
        return _points(key, value)
    if kind == GRIDS:
        return _grids(key, value, table.get("arguments", ["X"]))
    if kind == LETTERS:
        if not isinstance(value, list):
            raise UsageError(
                f'{key} = {shorten(value)} must be a list of axis letters, as in arguments = ["X"]'
            )
        return tuple(_text(key, v, "X") for v in value)
    if kind == LENGTH:
        return quantity(value, "length", key, "150 mm")
    if kind == TEXT:
        return _text(key, value, str(spec.default))
    return _whole(key, value, int(spec.default))  # type: ignore[arg-type]


def _points(key: str, value: Any) -> Array:
    if not isinstance(value, list) or not value:
        raise UsageError(
            f'{key} must be a list of points; write for example {key} = ["0 0 0 mm", "100 0 0 mm"]'
        )
    rows = [vector(row, "length", key, "0 0 20 mm") for row in value]
    bad = next((i for i, row in enumerate(rows) if len(row) != 3), None)
    if bad is not None:
        raise UsageError(
            f'{key}: row {bad + 1} "{value[bad]}" must have three numbers and a unit, as in "0 0 20 mm"'
        )
    return np.array(rows)


def _grids(key: str, value: Any, letters: Any) -> tuple[Array, ...]:
    if not isinstance(value, list) or not isinstance(letters, list) or len(value) != len(letters):
        raise UsageError(
            f'{key} = {shorten(value)} must have one list of positions per argument, as in grids = ["0 100 200 mm"]'
        )
    return tuple(_axis_positions(v, str(a), key) for v, a in zip(value, letters))


def _axis_positions(value: Any, axis: str, key: str) -> Array:
    if is_rotary(axis):
        return np.array(vector(value, "angle", key, "0 90 180 deg"))
    return np.array(vector(value, "length", key, "0 100 200 mm"))
