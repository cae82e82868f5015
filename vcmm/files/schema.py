"""Field types and error wording shared by all TOML schemas (pydantic models).

`read_model` turns a document into a model and reports every problem of the table at once, each with file, line,
what is allowed and the closest match.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable
from copy import deepcopy
from functools import partial
from types import UnionType
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError, WithJsonSchema, field_validator

from vcmm.core.errors import UsageError, choose_from
from vcmm.core.expansions import SHRINKS, USUAL_WORDS
from vcmm.core.text import LARGEST
from vcmm.core.units import quantity, shorten, usual, vector
from vcmm.files.problems import Problems, bad_name
from vcmm.files.toml import Document, Location

M = TypeVar("M", bound="Table")
NAME = "\0"  # placeholder for the key in messages of validators, which do not know it
SOLID = "of a solid"
EXPECTED_WORDS = {  # pydantic's error type -> the expected value, in words
    "string_type": "a text in quotes", "int_type": "a whole number", "int_from_float": "a whole number",
    "int_parsing": "a whole number", "float_type": "a plain number", "float_parsing": "a plain number",
    "finite_number": "a finite number", "bool_type": "true or false", "bool_parsing": "true or false",
    "list_type": "a list in [ ]", "dict_type": "a table in { }", "model_type": "a table in { }",
    "model_attributes_type": "a table in { }",
}  # fmt: skip


class Table(BaseModel):
    """A TOML table: unknown keys are refused, nothing is converted in silence."""

    model_config = ConfigDict(extra="forbid", strict=True, arbitrary_types_allowed=True, defer_build=True)

    @field_validator("name", check_fields=False)
    @classmethod
    def _one_line(cls, name: object) -> object:
        """Return a name that fits tables and pages, for any kind of object."""
        if isinstance(name, str) and (bad := bad_name(name)):
            raise ValueError(f"{NAME} {bad}" if name.strip() else f'{NAME} = "{name}" {bad}')
        return name


def _as_value_error(convert: Callable[[object], Any], value: object) -> Any:
    try:
        return convert(value)
    except UsageError as error:
        raise ValueError(str(error)) from None


def _check_sign(number: float, text: object, dimension: str, bound: str) -> float:
    """Refuse a sign that makes no sense; bound: "" any, "positive", "not negative"."""
    if (bound == "positive" and not number > 0) or (bound == "not negative" and number < 0):
        raise UsageError(f"{NAME} = {shorten(text)} must be {bound}")
    if bound == SOLID and number < SHRINKS:
        raise UsageError(
            f"{NAME} = {shorten(text)}: no solid that is measured shrinks so as it warms; {USUAL_WORDS}"
        )
    if bound == "positive" and number < usual(dimension) / LARGEST:
        raise UsageError(f"{NAME} = {shorten(text)} is as good as zero and must be {bound}")
    return number


def _parse_quantity(dimension: str, example: str, bound: str, value: object) -> float:
    return _check_sign(quantity(value, dimension, NAME, example), value, dimension, bound)


def _three(dimension: str, example: str, value: object) -> tuple[float, ...]:
    return _exactly(3, "three", vector(value, dimension, NAME, example), value, example)


def _two_sizes(dimension: str, example: str, value: object) -> tuple[float, ...]:
    out = _exactly(2, "two", vector(value, dimension, NAME, example), value, example)
    if min(out) <= 0:
        raise UsageError(
            f'{NAME} = {shorten(value)} must be positive; write for example {NAME} = "{example}"'
        )
    return out


def _exactly(n: int, word: str, numbers: tuple[float, ...], value: object, example: str) -> tuple[float, ...]:
    if len(numbers) != n:
        raise UsageError(
            f"{NAME} = {shorten(value)} has {_count(len(numbers), 'number')}, expected {word}; "
            f'write for example {NAME} = "{example}"'
        )
    return numbers


def _quantity_type(dimension: str, example: str, bound: str = "") -> Any:
    text = f"{dimension} with its unit" + (f", {bound}" if bound else "")
    schema = {"type": "string", "description": text, "examples": [example]}
    convert = partial(_parse_quantity, dimension, example, bound)
    return Annotated[float, BeforeValidator(partial(_as_value_error, convert)), WithJsonSchema(schema)]


def _degrees(example: str, value: object) -> float:
    """Return a difference of temperatures that files also give in degC (the columns end in _C)."""
    text = value.replace("degC", "K").replace("°C", "K") if isinstance(value, str) else value
    return quantity(text, "temperature difference", NAME, example)


def _either(dimensions: tuple[str, str], example: str, value: object) -> str:
    """Return a text that is right for a linear or for a rotary axis; the axis letter decides which is expected."""
    try:
        _parse_quantity(dimensions[1], example, "positive", value)
    except UsageError:
        _parse_quantity(dimensions[0], example, "positive", value)
    return str(value)


def _axis_rate_type(dimension: str, example: str) -> Any:
    convert = partial(_either, (dimension, f"angular {dimension}"), example)
    schema = {
        "type": "string",
        "description": f"{dimension} with its unit, angular for a rotary axis, positive",
        "examples": [example],
    }
    return Annotated[str, BeforeValidator(partial(_as_value_error, convert)), WithJsonSchema(schema)]


def _temperature_or_difference(value: object) -> str:
    """Return a temperature in degC or a difference in K; whether there is a room decides which is expected."""
    try:
        quantity(value, "temperature difference", NAME, "0.4 K")
    except UsageError:
        quantity(value, "temperature", NAME, "20.4 degC")
    return str(value)


def _temperature_difference_type(example: str) -> Any:
    schema = {"type": "string", "description": "temperature difference with its unit", "examples": [example]}
    return Annotated[
        float, BeforeValidator(partial(_as_value_error, partial(_degrees, example))), WithJsonSchema(schema)
    ]


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
    if not plain or not all(is_number(v) and math.isfinite(v) for v in value):  # type: ignore[attr-defined]
        raise ValueError(
            f"{NAME} = {shorten(value)} must be three plain finite numbers; write for example {NAME} = [0, 0, 1]"
        )
    numbers = tuple(float(v) for v in value)  # type: ignore[attr-defined]
    if not any(numbers):
        raise ValueError(f"{NAME} = [0, 0, 0] has no direction; write for example {NAME} = [0, 0, 1]")
    return numbers


def pair_of(example: str, value: object) -> Any:
    """Return two texts with units; the unit depends on other keys and is checked later."""
    if not (isinstance(value, list) and len(value) == 2 and all(isinstance(v, str) for v in value)):
        raise ValueError(
            f"{NAME} = {shorten(value)} must be two values with units; write for example {NAME} = {example}"
        )
    return value


def is_number(value: object) -> bool:
    return isinstance(value, int | float) and not isinstance(value, bool)


def _pair_type(example: str) -> Any:
    schema = {
        "type": "array",
        "items": {"type": "string"},
        "minItems": 2,
        "maxItems": 2,
        "examples": [example],
    }
    return Annotated[list[str], BeforeValidator(partial(pair_of, example)), WithJsonSchema(schema)]


Size = _quantity_type("length", "30 mm", "positive")
Distance = _quantity_type("length", "3 mm", "not negative")
Spread = _quantity_type("length", "0.5 um", "not negative")
Deviation = _quantity_type("length", "0.5 um")
ToolLength = _quantity_type("length", "80 mm")
Diameter = _quantity_type("length", "10 mm", "positive")
Angle = _quantity_type("angle", "30 deg")
Compliance = _quantity_type("compliance", "0.05 um/N", "not negative")
AngleSpread = _quantity_type("angle", "1 urad", "not negative")
Temperature = _quantity_type("temperature", "20.4 degC")
KelvinSpread = _quantity_type("temperature difference", "0.05 K", "not negative")
TemperatureOrDifference = Annotated[
    str,
    BeforeValidator(partial(_as_value_error, _temperature_or_difference)),
    WithJsonSchema(
        {
            "type": "string",
            "description": "temperature with its unit; beside room a difference to it",
            "examples": ["20.4 degC"],
        }
    ),
]
Gradient = _temperature_difference_type("0.1 K")
Expansion = _quantity_type("expansion", "11.5 um/(m K)", SOLID)
ExpansionSpread = _quantity_type("expansion", "0.5 um/(m K)", "not negative")
Speed = _quantity_type("speed", "5 mm/s", "positive")
Mass = _quantity_type("mass", "20 kg", "not negative")
AxisSpeed = _axis_rate_type("speed", "500 mm/s")
AxisAcceleration = _axis_rate_type("acceleration", "2 m/s^2")
AxisJerk = _axis_rate_type("jerk", "50 m/s^3")
Frequency = _quantity_type("frequency", "40 1/s", "positive")
_THREE = tuple[float, float, float]
Point = _vector_type(_three, "length", "0 0 20 mm", _THREE)
Turn = _vector_type(_three, "angle", "0 0 90 deg", _THREE)
TwoSizes = _vector_type(_two_sizes, "length", "80 80 mm", tuple[float, float])
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
    checked = checked_model(model, data, problems, at)
    problems.raise_if_any()
    assert checked is not None
    return checked


def checked_model(model: type[M], data: object, problems: Problems, at: Location = ()) -> M | None:
    """Validate a table, noting what is wrong.

    Returns the model without the wrong keys, so that the rest of the file can still be checked; None where a
    key that must be there is missing or wrong.
    """
    try:
        return model.model_validate(data)
    except ValidationError as error:
        items = error.errors(include_url=False)
    for item in items:
        where, text = explain(item, model)
        problems.add((*at, *where), text, table=(*at, *_key_location(where)[:-1]))
    try:
        return model.model_validate(_without(data, [item["loc"] for item in items]))
    except ValidationError:
        return None


def is_complete(table: Table, data: object) -> bool:
    """Return whether a table still has all keys it was given: the remainder of a wrong one gives false complaints only."""
    return isinstance(data, dict) and set(data) == table.model_fields_set


def _without(data: object, locations: Iterable[tuple[Any, ...]]) -> object:
    """Return a copy without the innermost keys on the way to each location."""
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


def explain(item: Any, model: type[BaseModel]) -> tuple[Location, str]:
    """Return one pydantic error in plain words, and where it is: 'unknown key "travle". Did you mean "travel"?'"""
    where = _in_data(item["loc"])
    location = _key_location(where)
    key = str(location[-1]) if location else "the table"
    return where, _sentence(item, key, model, location)


def _key_location(location: Location) -> Location:
    """Return the location of a key; an element of a list is reported by the key of its list."""
    while location and isinstance(location[-1], int):
        location = location[:-1]
    return location


def _sentence(item: Any, key: str, model: type[BaseModel], location: Location) -> str:
    kind, value = item["type"], item["input"]
    if kind == "extra_forbidden":
        usual = getattr(_model_at(model, location[:-1]), "other_names", {}).get(key, key)
        return f'unknown key "{key}".{choose_from(usual, allowed_keys(model, location[:-1]))}'
    if kind == "missing":
        example = _example(model, location)
        return f'the key "{key}" is missing; ' + (
            f"write for example {key} = {example}" if example else f"add {key} = ..."
        )
    if kind == "literal_error":
        allowed = [w.strip(" '") for w in item["ctx"]["expected"].replace(" or ", ", ").split(",")]
        return f"{key} = {shorten(value)} is not allowed.{choose_from(str(value), allowed)}"
    if kind == "value_error":
        return str(item["ctx"]["error"]).replace(NAME, key)
    if kind == "greater_than_equal":
        return f"{key} = {shorten(value)} must be {item['ctx']['ge']:g} or more"
    if kind in EXPECTED_WORDS:
        example = _example(model, location)
        fix = f"; write for example {key} = {example}" if example else ""
        return (
            f"{key} = {shorten(value)} must be {_expected_type(model, location, EXPECTED_WORDS[kind])}{fix}"
        )
    return f"{key} = {shorten(value)}: {item['msg'][0].lower()}{item['msg'][1:]}"


def _expected_type(model: type[BaseModel], location: Location, otherwise: str) -> str:
    """Return the types of a key that takes a text or a list or a table."""
    field = _field(model, location)
    if field is None or not isinstance(field.annotation, UnionType):
        return otherwise
    names = {str: "a text", list: "a list of texts", dict: "a table"}
    words = [names.get(getattr(inner, "__origin__", inner), "") for inner in field.annotation.__args__]
    words = [w for w in words if w]
    return " or ".join(words) if len(words) > 1 else otherwise


def _count(n: int, word: str) -> str:
    return f"{n} {word}" if n == 1 else f"{n} {word}s"


def _in_data(location: tuple[Any, ...]) -> Location:
    """Return the location without the parts that pydantic adds for validators and unions."""
    added = ("str", "int", "float", "bool", "list[", "dict[", "function-", "tuple[")
    return tuple(
        p for p in location if not (isinstance(p, str) and (p in added[:4] or p.startswith(added[4:])))
    )


def allowed_keys(model: type[BaseModel], location: Location) -> list[str]:
    """Return the keys of the (nested) model at a location; empty when the location is not found."""
    return [f.alias or n for n, f in getattr(_model_at(model, location), "model_fields", {}).items()]


def _model_at(model: type[BaseModel], location: Location) -> Any:
    current: Any = model
    for part in location:
        fields = getattr(current, "model_fields", {})
        if part in fields:
            models = list(_models_in(fields[part].annotation))
            current = models[0] if models else None
    return current  # parts that are no fields are names the user chose, such as axes.X


def _field(model: type[BaseModel], location: Location) -> Any:
    fields = getattr(_model_at(model, location[:-1]), "model_fields", {})
    return fields.get(location[-1]) if location else None


def _example(model: type[BaseModel], location: Location) -> str:
    """Return an example of a right value, as written in TOML; '' where none is known."""
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
