"""[[effects]] and [[inputs]] tables: built from what the effect classes declare, so a new effect needs no code here."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import MISSING, fields
from typing import Any

import numpy as np

from vcmm.effect import Effect, parameter_fields, place_fields
from vcmm.effects import find
from vcmm.errors import UsageError, choose_from, did_you_mean
from vcmm.inputs import EVERY, Input
from vcmm.laws import (
    Arcsine,
    Law,
    MultivariateNormal,
    Normal,
    Samples,
    StudentT,
    Trapezoidal,
    Triangular,
    Uniform,
)
from vcmm.run import Array
from vcmm.units import channel_unit, dimension_of, parse_unit, quantity, vector

LAWS = ("normal", "t", "uniform", "triangular", "trapezoidal", "arcsine", "samples", "multivariate")
BOUNDED = {"uniform": Uniform, "triangular": Triangular, "arcsine": Arcsine}
INPUT_KEYS = (
    "effect", "channel", "parameter", "law", "u", "scale", "dof", "half_width", "top", "values", "covariance",
    "redraw", "evidence",
)  # fmt: skip


def build_effect(table: dict[str, Any], known: type[Effect] | None = None) -> Effect:
    """One [[effects]] table to an Effect. Raises UsageError naming key, unit or closest word."""
    kind = known or find(str(table.get("effect", "")))
    places = {f.name for f in place_fields(kind)}
    parameters = {f.name: f for f in parameter_fields(kind)}
    other = {f.name: f for f in fields(kind)} | {}
    values: dict[str, Any] = {}
    for key, value in table.items():
        name = kind.aliases.get(key, key)
        if key == "effect":
            continue
        if name in parameters:
            values[name] = _parameter_value(kind, name, value, table)
        elif key in places:
            values[key] = str(value)
        elif key in other:
            values[key] = _plain(kind, key, value)
        else:
            allowed = [
                *places,
                *parameters,
                *kind.aliases,
                *(k for k in other if k not in parameters and k not in places),
            ]
            raise UsageError(f'unknown key "{key}" of effect {kind.name}.{choose_from(key, allowed)}')
    missing = [f.name for f in place_fields(kind) if f.name not in values and f.name != "stylus"]
    if missing:
        example = next(f for f in fields(kind) if f.name == missing[0])
        default = "" if example.default is MISSING else example.default
        raise UsageError(
            f'effect {kind.name} needs {missing[0]}; write for example {missing[0]} = "{default}"'
        )
    return kind(**values)


def _parameter_value(kind: type[Effect], name: str, value: Any, table: dict[str, Any]) -> Any:
    spec = next(f for f in parameter_fields(kind) if f.name == name)
    unit = unit_of(spec.metadata["unit"], str(table.get("component", "")))
    if not spec.metadata["shape"]:
        return quantity(value, dimension_of(unit), name)
    rows = value if isinstance(value, list) else [value]
    if rows and all(isinstance(r, str) and len(r.split()) > 2 for r in rows):
        return np.array([vector(r, dimension_of(unit), name) for r in rows])
    return np.array(vector(value, dimension_of(unit), name))


def unit_of(unit: str, component: str = "") -> str:
    """The unit of a parameter; "mm or rad" is settled by the direction of the component (EXX mm, EAX rad)."""
    if unit != "mm or rad":
        return unit
    return "rad" if len(component) > 1 and component[1] in "ABC" else "mm"


def _plain(kind: type[Effect], key: str, value: Any) -> Any:
    """Keys that are neither place nor parameter: nodes and lengths carry mm, words and counts are taken as they are."""
    if key in ("nodes", "deviation"):
        return np.array([vector(row, "length", key) for row in value])
    if key in ("grids", "length"):
        return (
            quantity(value, "length", key)
            if key == "length"
            else tuple(np.array(vector(v, "length", key)) for v in value)
        )
    if key == "arguments":
        return tuple(value)
    if isinstance(value, float):
        raise UsageError(f"{key} = {value} of effect {kind.name} must be a whole number or a word")
    return value


def build_input(table: dict[str, Any], effects: Sequence[Effect]) -> Input:
    """One [[inputs]] table to an Input; `effects` are those of the machine (or scenario), to check the target."""
    if ("effect" in table) == ("channel" in table):
        raise UsageError('an input names either effect = "..." with parameter = "...", or channel = "..."')
    redraw, evidence = str(table.get("redraw", "machine")), str(table.get("evidence", ""))
    if "channel" in table:
        _refuse_unknown(table, ())
        channel = str(table["channel"])
        law, _ = _law(table, channel_unit(channel))
        return Input("channel", "", channel, law, redraw, evidence)
    kind = find(str(table["effect"]))
    places = [f.name for f in place_fields(kind)]
    _refuse_unknown(table, places)
    known = {f.name: f for f in parameter_fields(kind)}
    name = kind.aliases.get(str(table.get("parameter", "")), str(table.get("parameter", "")))
    if name not in known:
        raise UsageError(f'input for {kind.name}: unknown parameter "{name}".{choose_from(name, known)}')
    where = ",".join(str(table[p]) for p in places if table.get(p))
    matching = [e for e in effects if e.name == kind.name and (where in (EVERY, e.where))]
    if not matching:
        have = [e.id for e in effects if e.name == kind.name]
        hint = (
            f"; there is {', '.join(have)}" if have else f'; add it with [[effects]] effect = "{kind.name}"'
        )
        raise UsageError(f"input for {kind.name}[{where}], but the machine has no such effect{hint}")
    component = str(getattr(matching[0], "component", ""))
    law, scale = _law(table, unit_of(known[name].metadata["unit"], component))
    return Input(kind.name, where, name, law, redraw, evidence, scale)


def _refuse_unknown(table: dict[str, Any], places: Sequence[str]) -> None:
    for key in table:
        if key not in INPUT_KEYS and key not in places:
            raise UsageError(f'unknown key "{key}" of an input.{choose_from(key, [*places, *INPUT_KEYS])}')


def _law(table: dict[str, Any], unit: str) -> tuple[Any, Array | None]:
    """(law, scale per element or None) from the keys law, u, scale, dof, half_width, top, values, covariance."""
    name = str(table.get("law", "normal"))
    if name not in LAWS:
        raise UsageError(f'unknown law "{name}".{choose_from(name, LAWS)}')
    if name == "samples":
        return Samples(np.array(vector(table.get("values"), dimension_of(unit), "values"))), None
    if name == "multivariate":
        squared = parse_unit(unit).factor ** 2
        if "covariance" not in table:
            raise UsageError(f'law = "multivariate" needs covariance = [[...], ...] in ({unit})^2')
        return MultivariateNormal(np.array(table["covariance"], dtype=float) * squared), None
    key = _spread_key(table, name)
    numbers = _numbers(table[key], dimension_of(unit), key)
    if len(numbers) > 1:
        return _scalar_law(name, key, 1.0, table), numbers
    return _scalar_law(name, key, float(numbers[0]), table), None


def _numbers(value: Any, dimension: str, key: str) -> Array:
    """One number, "a b c um", a list of texts, or a list of "x y z um" rows, flattened."""
    if isinstance(value, list) and value and all(isinstance(v, str) for v in value):
        return np.concatenate([vector(v, dimension, key) for v in value])
    return np.array(vector(value, dimension, key))


def _spread_key(table: dict[str, Any], name: str) -> str:
    allowed = {"t": ("scale",), "normal": ("u",)}.get(name, ("half_width", "u"))
    given = [k for k in allowed if k in table]
    if len(given) != 1:
        other = [k for k in ("u", "scale", "half_width") if k in table]
        has = f", but {' and '.join(other)} is given" if other else ""
        raise UsageError(
            f'law = "{name}" needs {" or ".join(allowed)}{has}{did_you_mean(other[0] if other else "", allowed)}'
        )
    return given[0]


def _scalar_law(name: str, key: str, value: float, table: dict[str, Any]) -> Law:
    if value < 0:
        raise UsageError(f"{key} = {value:g} is negative; a spread is zero or positive")
    if name == "normal":
        return Normal(value)
    if name == "t":
        dof = table.get("dof")
        if not isinstance(dof, int | float) or not dof > 0:
            raise UsageError('law = "t" needs dof, the degrees of freedom, for example dof = 13')
        return StudentT(value, float(dof))
    if name == "trapezoidal":
        ratio = float(table.get("top", 0.5))
        if not 0 <= ratio <= 1:
            raise UsageError(
                f"top = {ratio:g} is the plateau as a share of the half width and lies between 0 and 1"
            )
        half = value if key == "half_width" else value / (Trapezoidal(1.0, ratio).u)
        return Trapezoidal(half, half * ratio)
    kind = BOUNDED[name]
    return kind(value if key == "half_width" else value / kind(1.0).u)
