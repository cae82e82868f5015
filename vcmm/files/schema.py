"""Field types and error wording shared by all TOML schemas (pydantic models).

`read_model` turns a document into a model and reports every problem of the table at once, each with file, line,
what is allowed and the closest match.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from copy import deepcopy
from functools import partial
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError, WithJsonSchema

from vcmm.errors import UsageError, choose_from
from vcmm.files.problems import Problems
from vcmm.files.toml import Document, Location
from vcmm.units import quantity, vector

M = TypeVar("M", bound="Table")
NAME = "\0"  # stands for the key in messages of validators, which do not know it
WANTED = {  # pydantic's error type -> what is due, in words
    "string_type": "a text in quotes", "int_type": "a whole number", "int_from_float": "a whole number",
    "int_parsing": "a whole number", "float_type": "a plain number", "float_parsing": "a plain number",
    "finite_number": "a finite number", "bool_type": "true or false", "bool_parsing": "true or false",
    "list_type": "a list in [ ]", "dict_type": "a table in { }", "model_type": "a table in { }",
    "model_attributes_type": "a table in { }",
}  # fmt: skip


class Table(BaseModel):
    """A TOML table: unknown keys are refused, nothing is converted in silence."""

    model_config = ConfigDict(extra="forbid", strict=True, arbitrary_types_allowed=True)


def _as_value_error(convert: Callable[[object], Any], value: object) -> Any:
    try:
        return convert(value)
    except UsageError as error:
        raise ValueError(str(error)) from None


def _checked(number: float, text: object, dimension: str, bound: str) -> float:
    """Refuse a sign that makes no sense; bound: "" any, "positive", "not negative"."""
    if (bound == "positive" and not number > 0) or (bound == "not negative" and number < 0):
        raise UsageError(f'{NAME} = "{text}" must be {bound}')
    return number


def _one(dimension: str, example: str, bound: str, value: object) -> float:
    return _checked(quantity(value, dimension, NAME, example), value, dimension, bound)


def _three(dimension: str, example: str, value: object) -> tuple[float, ...]:
    out = vector(value, dimension, NAME, example)
    if len(out) != 3:
        raise UsageError(
            f"{NAME} = {_shown(value)} has {_count(len(out), 'number')} where three are due; "
            f'write for example {NAME} = "{example}"'
        )
    return out


def _several(dimension: str, example: str, value: object) -> tuple[float, ...]:
    return vector(value, dimension, NAME, example)


def _quantity_type(dimension: str, example: str, bound: str = "") -> Any:
    text = f"{dimension} with its unit" + (f", {bound}" if bound else "")
    schema = {"type": "string", "description": text, "examples": [example]}
    convert = partial(_one, dimension, example, bound)
    return Annotated[float, BeforeValidator(partial(_as_value_error, convert)), WithJsonSchema(schema)]


def _vector_type(convert: Any, dimension: str, example: str, kind: Any) -> Any:
    schema = {
        "anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}],
        "description": f"numbers and a unit ({dimension})",
        "examples": [example],
    }
    return Annotated[
        kind,
        BeforeValidator(partial(_as_value_error, partial(convert, dimension, example))),
        WithJsonSchema(schema),
    ]


def _direction(value: object) -> Any:
    plain = isinstance(value, list | tuple) and len(value) == 3
    if not plain or not all(_is_number(v) and math.isfinite(v) for v in value):  # type: ignore[attr-defined]
        raise ValueError(
            f"{NAME} = {_shown(value)} must be three plain finite numbers; write for example {NAME} = [0, 0, 1]"
        )
    numbers = tuple(float(v) for v in value)  # type: ignore[attr-defined]
    if not any(numbers):
        raise ValueError(f"{NAME} = [0, 0, 0] has no direction; write for example {NAME} = [0, 0, 1]")
    return numbers


def _pair(example: str, value: object) -> Any:
    """Two texts with units; the unit depends on other keys and is checked later."""
    if not (isinstance(value, list) and len(value) == 2 and all(isinstance(v, str) for v in value)):
        raise ValueError(
            f"{NAME} = {_shown(value)} must be two values with units; write for example {NAME} = {example}"
        )
    return value


def _is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _pair_type(example: str) -> Any:
    schema = {
        "type": "array",
        "items": {"type": "string"},
        "minItems": 2,
        "maxItems": 2,
        "examples": [example],
    }
    return Annotated[list[str], BeforeValidator(partial(_pair, example)), WithJsonSchema(schema)]


Size = _quantity_type("length", "30 mm", "positive")
Distance = _quantity_type("length", "3 mm", "not negative")
Spread = _quantity_type("length", "0.5 um", "not negative")
Deviation = _quantity_type("length", "0.5 um")
Angle = _quantity_type("angle", "30 deg")
AngleSpread = _quantity_type("angle", "1 urad", "not negative")
Temperature = _quantity_type("temperature", "20.4 degC")
Kelvin = _quantity_type("temperature difference", "0.1 K")
KelvinSpread = _quantity_type("temperature difference", "0.05 K", "not negative")
Expansion = _quantity_type("expansion", "11.5 um/(m K)")
ExpansionSpread = _quantity_type("expansion", "0.5 um/(m K)", "not negative")
Speed = _quantity_type("speed", "5 mm/s", "positive")
Acceleration = _quantity_type("acceleration", "2 m/s^2", "positive")
Jerk = _quantity_type("jerk", "50 m/s^3", "positive")
Frequency = _quantity_type("frequency", "40 1/s", "positive")
_THREE = tuple[float, float, float]
Point = _vector_type(_three, "length", "0 0 20 mm", _THREE)
Turn = _vector_type(_three, "angle", "0 0 90 deg", _THREE)
Lengths = _vector_type(_several, "length", "80 80 mm", tuple[float, ...])
Travel = _pair_type('["0 mm", "600 mm"]')
Limits = _pair_type('["0 mm", "0.021 mm"]')
Direction = Annotated[
    _THREE,
    BeforeValidator(_direction),
    WithJsonSchema(
        {
            "type": "array",
            "items": {"type": "number"},
            "minItems": 3,
            "maxItems": 3,
            "examples": ["[0, 0, 1]"],
        }
    ),
]


def read_model(model: type[M], data: object, document: Document, at: Location = ()) -> M:
    """Validate a table. Raises DataError with every problem found."""
    problems = Problems(document)
    found = checked_model(model, data, problems, at)
    problems.raise_if_any()
    assert found is not None
    return found


def checked_model(model: type[M], data: object, problems: Problems, at: Location = ()) -> M | None:
    """Validate a table, noting what is wrong.

    Returns the model without the wrong keys, so that the rest of the file can still be checked; None where a
    key that must be there is missing or wrong.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        items = error.errors(include_url=False)
    for text in _merged([explain(item, model, problems.document, at) for item in items]):
        problems.add((), text)
    try:
        return model.model_validate(_without(data, [item["loc"] for item in items]))
    except ValidationError:
        return None


def _merged(texts: list[str]) -> list[str]:
    return list(dict.fromkeys(texts))


def _without(data: object, locations: Iterable[tuple[Any, ...]]) -> object:
    """A copy without the innermost keys on the way to each location."""
    out = deepcopy(data)
    for location in locations:
        place, last = out, None
        for part in location:
            if not isinstance(place, dict | list) or not _holds(place, part):
                break
            last = (place, part) if isinstance(place, dict) else last
            place = place[part]
        if last is not None:
            last[0].pop(last[1], None)
    return out


def _holds(place: Any, part: object) -> bool:
    return part in place if isinstance(place, dict) else isinstance(part, int) and part < len(place)


def explain(item: Any, model: type[BaseModel], document: Document, at: Location) -> str:
    """One pydantic error in plain words: 'machine.toml:12: [axes.X] unknown key "travle". Did you mean "travel"?'"""
    location = _in_data(item["loc"])
    here = document.where(at + location)
    while location and isinstance(location[-1], int) and item["type"] != "missing":
        location = location[:-1]  # an element is reported by the key of its list
    key = str(location[-1]) if location else "the table"
    inside = table_name(at + location[:-1])
    text = _sentence(item, key, model, location)
    return f"{here}: {inside}{text}"


def table_name(location: Location) -> str:
    """('plan', 'steps', 0) -> '[plan.steps 1] '; empty at the top of a file."""
    words: list[str] = []
    for part in location:
        if isinstance(part, int) and words:
            words[-1] += f" {part + 1}"
        else:
            words.append(str(part))
    return f"[{'.'.join(words)}] " if words else ""


def _sentence(item: Any, key: str, model: type[BaseModel], location: Location) -> str:
    kind, value = item["type"], item["input"]
    if kind == "extra_forbidden":
        return f'unknown key "{key}".{choose_from(key, allowed_keys(model, location[:-1]))}'
    if kind == "missing":
        example = _example(model, location)
        return f'the key "{key}" is missing; ' + (
            f"write for example {key} = {example}" if example else f"add {key} = ..."
        )
    if kind == "literal_error":
        allowed = [w.strip(" '") for w in item["ctx"]["expected"].replace(" or ", ", ").split(",")]
        return f"{key} = {_shown(value)} is not allowed.{choose_from(str(value), allowed)}"
    if kind == "value_error":
        return str(item["ctx"]["error"]).replace(NAME, key)
    if kind in WANTED:
        example = _example(model, location)
        fix = f"; write for example {key} = {example}" if example else ""
        return f"{key} = {_shown(value)} must be {_wanted(model, location, WANTED[kind])}{fix}"
    return f"{key} = {_shown(value)}: {item['msg'][0].lower()}{item['msg'][1:]}"


def _wanted(model: type[BaseModel], location: Location, otherwise: str) -> str:
    """Where a key takes a text or a list or a table, say so."""
    field = _field(model, location)
    words = []
    for inner in getattr(field.annotation, "__args__", ()) if field is not None else ():
        origin = getattr(inner, "__origin__", inner)
        words += [{str: "a text", list: "a list of texts", dict: "a table"}.get(origin, "")]
    words = [w for w in words if w]
    return " or ".join(words) if len(words) > 1 else otherwise


def _shown(value: object) -> str:
    """A value as it stands in TOML, shortened."""
    if isinstance(value, bool):
        return str(value).lower()
    if isinstance(value, str):
        return f'"{value}"'
    if isinstance(value, list | tuple):
        return "[" + ", ".join(_shown(v) for v in value[:6]) + (", ..." if len(value) > 6 else "") + "]"
    if isinstance(value, dict):
        return "{ " + ", ".join(f"{k} = {_shown(v)}" for k, v in list(value.items())[:4]) + " }"
    return str(value)


def _count(n: int, word: str) -> str:
    return f"{n} {word}" if n == 1 else f"{n} {word}s"


def _in_data(location: tuple[Any, ...]) -> Location:
    """Without the parts that pydantic adds for validators and unions."""
    added = ("str", "int", "float", "bool", "list[", "dict[", "function-", "tuple[")
    return tuple(
        p for p in location if not (isinstance(p, str) and (p in added[:4] or p.startswith(added[4:])))
    )


def allowed_keys(model: type[BaseModel], location: Location) -> list[str]:
    """Keys of the (nested) model at a location; empty when it cannot be told."""
    return [f.alias or n for n, f in getattr(_model_at(model, location), "model_fields", {}).items()]


def _model_at(model: type[BaseModel], location: Location) -> Any:
    current: Any = model
    for part in location:
        known = getattr(current, "model_fields", {})
        if part in known:
            models = list(_models_in(known[part].annotation))
            current = models[0] if models else None
    return current  # parts that are no fields are names the user chose, such as axes.X


def _field(model: type[BaseModel], location: Location) -> Any:
    known = getattr(_model_at(model, location[:-1]), "model_fields", {})
    return known.get(location[-1]) if location else None


def _example(model: type[BaseModel], location: Location) -> str:
    """What a right value looks like, as written in TOML; '' where none is known."""
    field = _field(model, location)
    if field is None:
        return ""
    for meta in field.metadata:
        shown = getattr(meta, "json_schema", {}) if isinstance(meta, WithJsonSchema) else {}
        for text in (shown or {}).get("examples", []):
            return text if text.startswith("[") else f'"{text}"'
    return str(field.examples[0]) if field.examples else ""


def _models_in(annotation: Any) -> Iterable[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in getattr(annotation, "__args__", ()):
        yield from _models_in(inner)
