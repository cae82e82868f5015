"""Read [[inputs]] tables: knowledge about a parameter of an effect or about a column of the run."""

from __future__ import annotations

from collections.abc import Iterator, Mapping, Sequence
from contextlib import contextmanager
from dataclasses import Field
from typing import Any

import numpy as np

from vcmm.core.effect import Effect, parameter_fields, place_fields, unit_of
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.inputs import EVERY, Input
from vcmm.core.laws import (
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
from vcmm.core.run import Array
from vcmm.core.units import channel_unit, dimension_of, parse_unit, shorten, vector
from vcmm.files.columns import REDRAW, check_channel
from vcmm.files.own.effects import KeyProblems, check_matters, kind_of, may_be_left_out, noting
from vcmm.files.problems import TableProblems, misspelt
from vcmm.files.schema import is_number
from vcmm.physics.structure.residual import CorrelatedField, ResidualField

BOUNDED_LAWS = {"uniform": Uniform, "triangular": Triangular, "arcsine": Arcsine}
LAW_KEYS = {  # the first is the spread; of u and half_width one is given
    "normal": ("u", "nu"), "t": ("scale", "dof", "nu"), "uniform": ("half_width", "u", "nu"), "triangular": ("half_width", "u", "nu"),
    "trapezoidal": ("half_width", "u", "top", "nu"), "arcsine": ("half_width", "u", "nu"), "samples": ("values", "nu"),
    "multivariate": ("covariance", "nu"),
}  # fmt: skip
NO_SPREAD = ("dof", "nu", "top")
INPUT_KEYS = (
    "effect", "channel", "parameter", "law", "u", "scale", "dof", "nu", "half_width", "top", "values", "covariance",
    "redraw", "evidence",
)  # fmt: skip


def build_input(table: dict[str, Any], effects: Sequence[Effect], complete: bool = True) -> Input | None:
    """Convert one [[inputs]] table to an Input; `effects` are those of the machine (or scenario), to check the target.

    Raises TableProblems naming every wrong key, unit or word. Where not all effects could be read (complete =
    False) a missing target is no mistake of the input, and None is returned.
    """
    problems: KeyProblems = []
    near = misspelt("effect", table) or misspelt("channel", table)
    if "effect" not in table and "channel" not in table and near:
        raise TableProblems([("", f"an input names an effect or a channel.{near}")])
    if ("effect" in table) == ("channel" in table):
        text = 'an input names either effect = "..." with parameter = "...", or channel = "..."'
        raise TableProblems([("effect" if "effect" in table else "", text)])
    for key in ("evidence", "redraw", "law", "parameter"):
        if not isinstance(table.get(key, ""), str):
            problems.append((key, f"{key} = {shorten(table[key])} must be a text in quotes"))
    redraw = str(table.get("redraw", "machine"))
    if redraw not in REDRAW:
        problems.append(("redraw", f'redraw = "{redraw}" is no label.{choose_from(redraw, REDRAW)}'))
    out = (
        _channel_input(table, problems)
        if "channel" in table
        else _effect_input(table, effects, complete, problems)
    )
    if problems:
        raise TableProblems(problems)
    return out


def _channel_input(table: dict[str, Any], problems: KeyProblems) -> Input | None:
    _note_unknown(table, (), problems)
    channel = str(table["channel"])
    with noting(problems, "channel"):
        check_channel(channel)
        law, _ = _law(table, channel_unit(channel), difference=True)
        return Input(
            "channel",
            "",
            channel,
            law,
            redraw_of(table),
            str(table.get("evidence", "")),
            nu=degrees_of_freedom(table),
        )
    return None


def _effect_input(
    table: dict[str, Any], effects: Sequence[Effect], complete: bool, problems: KeyProblems
) -> Input | None:
    kind = kind_of(table, problems)
    if kind is None:
        return None
    places = [f.name for f in place_fields(kind)]
    _note_unknown(table, places, problems)
    target = None
    with noting(problems, places[0] if places and places[0] in table else "effect"):
        target = _target(kind, table, effects, complete)
    spec = None
    with noting(problems, "parameter"):
        spec = input_parameter(kind, table, "" if target is None else str(getattr(target, "component", "")))
    if spec is None or target is None:
        return None
    law, scale = None, None
    with noting(problems, "law"):
        covariance = target.covariance() if isinstance(target, CorrelatedField) else None
        law_of_field = target.own_law(spec.name) if isinstance(target, ResidualField) else None
        if law_of_field is not None:
            law = _refusing_others(kind, table, law_of_field)
        elif covariance is not None:
            law = _own_law(kind, covariance, table)
        else:
            law, scale = _law(table, unit_of(target, spec.name))
        _check_size(law, scale, int(np.size(getattr(target, spec.name))), spec.name)
    if law is None:
        return None
    return Input(
        effect=kind.name,
        where=EVERY if _everywhere(kind, table) else target.where,
        parameter=spec.name,
        law=law,
        redraw=redraw_of(table),
        evidence=str(table.get("evidence", "")),
        scale=scale,
        nu=degrees_of_freedom(table),
    )


def _own_law(kind: type[Effect], covariance: Array, table: dict[str, Any]) -> MultivariateNormal:
    """Return the law of the effect's own kernel; any other law would not be that field."""
    law: MultivariateNormal = _refusing_others(
        kind, table, MultivariateNormal(covariance), "nodes and length"
    )
    return law


def _refusing_others(kind: type[Effect], table: dict[str, Any], own_law: Any, by: str = "process") -> Any:
    """Return the law that the effect gives; any other law in the table is refused."""
    keys = {"law", *(key for keys in LAW_KEYS.values() for key in keys)}
    stated = [k for k in table if k in keys and table[k] != "multivariate"]
    if stated:
        raise UsageError(
            f"{stated[0]} does not belong to an input of {kind.name}: its {by} give{'s' if by == 'process' else ''} the "
            f"{'law' if by == 'process' else 'covariance'}; remove it"
        )
    return own_law


def _check_size(law: Any, scale: Array | None, size: int, name: str) -> None:
    """Check that there are as many numbers as the parameter has elements."""
    key, given = "covariance", size
    if isinstance(law, MultivariateNormal):
        given = len(law.covariance)
    elif scale is not None:
        key, given = "law", len(scale)
    if given != size:
        raise TableProblems([(key, f"{given} numbers for {name}, which has {size}; give one per element")])


def redraw_of(table: dict[str, Any]) -> str:
    return str(table.get("redraw", "machine"))


def _stated_places(kind: type[Effect], table: dict[str, Any]) -> list[str]:
    """Return the places that the table names."""
    return [str(table[f.name]) for f in place_fields(kind) if table.get(f.name)]


def _everywhere(kind: type[Effect], table: dict[str, Any]) -> bool:
    given = _stated_places(kind, table)
    return bool(given) and set(given) == {EVERY}


def _sits_there(effect: Effect, table: dict[str, Any]) -> bool:
    """Return whether an effect is at the place in the table; a place that is left out means its default."""
    places = place_fields(effect)
    return all(
        str(table.get(f.name, f.default if may_be_left_out(f) else "")) == str(getattr(effect, f.name))
        for f in places
    )


def _target(
    kind: type[Effect], table: dict[str, Any], effects: Sequence[Effect], complete: bool
) -> Effect | None:
    """Return the first effect that an input is about."""
    where = ",".join(_stated_places(kind, table))
    same = [e for e in effects if e.name == kind.name]
    for effect in same:
        if _everywhere(kind, table) or _sits_there(effect, table):
            return effect
    if not complete:
        return None
    if not same:
        raise UsageError(
            f'an input for {kind.name}, but there is no such effect; add it with [[effects]] effect = "{kind.name}"'
        )
    have = [e.id for e in same]
    missing = [f.name for f in place_fields(kind) if f.name not in table]
    if missing and not where:
        raise UsageError(
            f'the input does not say which {kind.name}; add {missing[0]} = "{getattr(same[0], missing[0])}"'
        )
    raise UsageError(
        f"an input for {kind.name}[{where}], but there is no such effect.{choose_from(f'{kind.name}[{where}]', have)}"
    )


def input_parameter(kind: type[Effect], table: dict[str, Any], component: str) -> Field[Any]:
    parameters = {f.name: f for f in parameter_fields(kind)}
    word = str(table.get("parameter", ""))
    allowed = list(dict.fromkeys([*kind.about.aliases, *parameters]))
    if not word:
        raise UsageError(f'the key "parameter" is missing; write for example parameter = "{allowed[0]}"')
    name = kind.about.aliases.get(word, word)
    if name not in parameters:
        raise UsageError(f'{kind.name} has no parameter "{word}".{choose_from(word, allowed)}')
    check_matters(parameters[name], component, name)
    return parameters[name]


def _note_unknown(table: dict[str, Any], places: Sequence[str], problems: KeyProblems) -> None:
    keys = INPUT_KEYS if places else tuple(k for k in INPUT_KEYS if "channel" in table or k != "channel")
    for key in table:
        if key not in keys and key not in places:
            problems.append((key, f'unknown key "{key}" of an input.{choose_from(key, [*places, *keys])}'))


def _law(table: dict[str, Any], unit: str, difference: bool = False) -> tuple[Any, Array | None]:
    """Return (law, scale per element or None) from the keys law, u, scale, dof, half_width, top, values, covariance.

    difference: the unit K is that of a departure from a temperature.
    """
    dimension = "temperature difference" if difference and unit == "K" else dimension_of(unit)
    name = str(table.get("law", "normal"))
    if name not in LAW_KEYS:
        raise UsageError(f'unknown law "{name}".{choose_from(name, LAW_KEYS)}')
    _refuse_keys_of_other_laws(table, name)
    if name == "samples":
        if "values" not in table:
            raise UsageError(f'law = "samples" needs values, for example values = "0.1 -0.2 0.3 {unit}"')
        with _key("values"):
            return Samples(np.array(vector(table["values"], dimension, "values", f"0.1 -0.2 {unit}"))), None
    if name == "multivariate":
        return _multivariate(table, unit), None
    key = _spread_key(table, name, unit)
    with _key(key):
        numbers = _numbers(table[key], dimension, key, _example(unit))
        if (numbers < 0).any():
            raise UsageError(f"{key} = {shorten(table[key])} is negative; a spread is zero or positive")
        if len(numbers) > 1:
            return _scalar_law(name, key, 1.0, table), numbers
        return _scalar_law(name, key, float(numbers[0]), table), None


@contextmanager
def _key(key: str) -> Iterator[None]:
    """Assign complaints inside the context to this key."""
    try:
        yield
    except TableProblems:
        raise
    except UsageError as error:
        raise TableProblems([(key, str(error))]) from None


def _refuse_keys_of_other_laws(table: dict[str, Any], name: str) -> None:
    foreign = [k for keys in LAW_KEYS.values() for k in keys if k in table and k not in LAW_KEYS[name]]
    foreign = list(dict.fromkeys(foreign))
    if foreign and any(k in table for k in LAW_KEYS[name]):
        owner = next(law for law, keys in LAW_KEYS.items() if foreign[0] in keys)
        text = f'{foreign[0]} does not belong to law = "{name}", which takes {" or ".join(LAW_KEYS[name])}'
        raise TableProblems([(foreign[0], f'{text}; remove it or write law = "{owner}"')])


def _multivariate(table: dict[str, Any], unit: str) -> MultivariateNormal:
    if "covariance" not in table:
        raise UsageError(f'law = "multivariate" needs covariance = [[...], ...] in ({unit})^2')
    with _key("covariance"):
        rows = table["covariance"]
        square = isinstance(rows, list) and all(isinstance(r, list) and len(r) == len(rows) for r in rows)
        if not square or not all(is_number(v) for row in rows for v in row):
            raise UsageError(
                f"covariance must be a square of plain numbers in ({unit})^2, as in [[1.0, 0.2], [0.2, 1.0]]"
            )
        return MultivariateNormal(np.array(rows, dtype=float) * parse_unit(unit).factor ** 2)


def _example(unit: str) -> str:
    """Return a value of the size of an uncertainty: table values are kept in mm and rad, and written in um and urad."""
    small = {"mm": "um", "rad": "urad"}
    return f"0.5 {small.get(unit, unit)}"


def _numbers(value: Any, dimension: str, key: str, example: str) -> Array:
    """Return one number, "a b c um", a list of texts, or a list of "x y z um" rows, flattened."""
    if isinstance(value, list) and value and all(isinstance(v, str) for v in value):
        return np.concatenate([vector(v, dimension, key, example) for v in value])
    return np.array(vector(value, dimension, key, example))


def _spread_key(table: dict[str, Any], name: str, unit: str) -> str:
    allowed = [k for k in LAW_KEYS[name] if k not in NO_SPREAD]
    given = [k for k in allowed if k in table]
    if len(given) == 1:
        return given[0]
    if given:
        raise TableProblems([(given[1], f"{' and '.join(given)} are both given; keep one of them")])
    other = next((k for k in ("u", "scale", "half_width") if k in table), "")
    if other:
        owner = next(law for law, keys in LAW_KEYS.items() if other in keys)
        text = f'law = "{name}" needs {" or ".join(allowed)}, but {other} is given; {other} goes with law = "{owner}"'
        raise TableProblems([(other, text)])
    raise UsageError(
        f'law = "{name}" needs {" or ".join(allowed)}; write for example {allowed[0]} = "{_example(unit)}"'
    )


def _scalar_law(name: str, key: str, value: float, table: dict[str, Any]) -> Law:
    if name == "normal":
        nu = degrees_of_freedom(table)
        return Normal(value) if nu == np.inf else StudentT(value, nu)
    if name == "t":
        if "dof" not in table and "nu" in table:
            return StudentT(value, degrees_of_freedom(table))
        with _key("dof"):
            dof = _plain_number(table.get("dof"), "dof", "13")
            return StudentT(value, dof)
    if name == "trapezoidal":
        with _key("top"):
            ratio = _plain_number(table.get("top", 0.5), "top", "0.5")
            if not 0 <= ratio <= 1:
                raise UsageError(
                    f"top = {ratio:g} is the plateau as a share of the half width and lies between 0 and 1"
                )
        half = value if key == "half_width" else value / (Trapezoidal(1.0, ratio).u)
        return Trapezoidal(half, half * ratio)
    kind = BOUNDED_LAWS[name]
    return kind(value if key == "half_width" else value / kind(1.0).u)


def degrees_of_freedom(table: Mapping[str, Any]) -> float:
    """Return nu of a table, infinite where it states none: degrees of freedom of its u. TableProblems: no number of at least 1, dof beside it.

    A normal law with nu is the scaled and shifted t-law of scale u that JCGM 101, 6.4.9.7 assigns to a certificate with nu_eff.
    """
    if "nu" not in table:
        return float("inf")
    with _key("nu"):
        if "dof" in table:
            raise UsageError("nu and dof both state the degrees of freedom; keep one of them")
        if not is_number(table["nu"]) or not table["nu"] >= 1:
            raise UsageError(
                f"nu = {shorten(table['nu'])} must be a plain number of at least 1, the degrees of freedom of u; write for example nu = 13"
            )
        return float(table["nu"])


def _plain_number(value: Any, key: str, example: str) -> float:
    if value is None:
        raise UsageError(
            f'law = "t" needs {key}, the degrees of freedom; write for example {key} = {example}'
        )
    if not is_number(value):
        raise UsageError(
            f"{key} = {shorten(value)} must be a plain number; write for example {key} = {example}"
        )
    return float(value)
