"""Field types and error wording shared by all TOML schemas (pydantic models).

`read_model` turns a document into a model and reports every problem of the file at once, each with file, line,
what is allowed and the closest match.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable
from functools import partial
from typing import Annotated, Any, TypeVar

from pydantic import BaseModel, BeforeValidator, ConfigDict, ValidationError, WithJsonSchema

from vcmm.errors import DataError, UsageError, choose_from
from vcmm.files.toml import Document, Location
from vcmm.units import EXAMPLES, quantity, vector

M = TypeVar("M", bound="Table")


class Table(BaseModel):
    """A TOML table: unknown keys are refused."""

    model_config = ConfigDict(extra="forbid", strict=False, arbitrary_types_allowed=True)


def _as_value_error(convert: Callable[..., Any], dimension: str, value: object) -> Any:
    try:
        return convert(value, dimension, "\0")
    except UsageError as error:
        raise ValueError(str(error)) from None


def _quantity_type(dimension: str) -> Any:
    schema = {
        "type": "string",
        "description": f"{dimension} with its unit",
        "examples": [EXAMPLES[dimension]],
    }
    return Annotated[
        float, BeforeValidator(partial(_as_value_error, quantity, dimension)), WithJsonSchema(schema)
    ]


def _vector(value: object, dimension: str, what: str) -> tuple[float, ...]:
    out = vector(value, dimension, what)
    if len(out) != 3:
        raise UsageError(
            f'{what} = "{value}" has {len(out)} numbers where three are due; write for example "0 0 20 mm"'
        )
    return out


def _vector_type(dimension: str, example: str) -> Any:
    schema = {
        "anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}],
        "description": f"three numbers and a unit ({dimension})",
        "examples": [example],
    }
    return Annotated[
        tuple[float, float, float],
        BeforeValidator(partial(_as_value_error, _vector, dimension)),
        WithJsonSchema(schema),
    ]


def _list_type(dimension: str, example: str) -> Any:
    schema = {
        "anyOf": [{"type": "string"}, {"type": "array", "items": {"type": "string"}}],
        "examples": [example],
    }
    return Annotated[
        tuple[float, ...],
        BeforeValidator(partial(_as_value_error, vector, dimension)),
        WithJsonSchema(schema),
    ]


def _direction(value: object) -> Any:
    if (
        not isinstance(value, list | tuple)
        or len(value) != 3
        or not all(isinstance(v, int | float) for v in value)
    ):
        raise ValueError("\0 must be three plain numbers, for example [0, 0, 1]")
    if not any(value):
        raise ValueError("\0 = [0, 0, 0] has no direction; write for example [0, 0, 1]")
    return tuple(float(v) for v in value)


Length = _quantity_type("length")
Angle = _quantity_type("angle")
Time = _quantity_type("time")
Temperature = _quantity_type("temperature")
Kelvin = _quantity_type("temperature difference")
Expansion = _quantity_type("expansion")
Speed = _quantity_type("speed")
Acceleration = _quantity_type("acceleration")
Jerk = _quantity_type("jerk")
Frequency = _quantity_type("frequency")
Point = _vector_type("length", "0 0 20 mm")
Turn = _vector_type("angle", "0 0 90 deg")
Lengths = _list_type("length", "5 15 mm")
Direction = Annotated[
    tuple[float, float, float],
    BeforeValidator(_direction),
    WithJsonSchema(
        {"type": "array", "items": {"type": "number"}, "minItems": 3, "maxItems": 3, "examples": [[0, 0, 1]]}
    ),
]


def read_model(model: type[M], data: object, document: Document, at: Location = ()) -> M:
    """Validate a table. Raises DataError with every problem found."""
    try:
        return model.model_validate(data)
    except ValidationError as error:
        raise DataError(
            [explain(item, model, document, at) for item in error.errors(include_url=False)]
        ) from None


def explain(item: Any, model: type[BaseModel], document: Document, at: Location) -> str:
    """One pydantic error in plain words: 'machine.toml:12: unknown key "travle" in [axes.X]. Did you mean "travel"?'"""
    location = tuple(
        part for part in item["loc"] if not (isinstance(part, str) and part.startswith("function-"))
    )
    here = document.where(at + location)
    key = str(location[-1]) if location else "the file"
    table = "".join(f".{p}" if isinstance(p, str) else f"[{p + 1}]" for p in at + location[:-1]).lstrip(".")
    inside = f" in [{table}]" if table else ""
    if item["type"] == "extra_forbidden":
        return f'{here}: unknown key "{key}"{inside}.{choose_from(key, allowed_keys(model, location[:-1]))}'
    if item["type"] == "missing":
        return f'{here}: the key "{key}" is missing{inside}; add it'
    if item["type"] == "literal_error":
        allowed = [w.strip(" '") for w in item["ctx"]["expected"].replace(" or ", ", ").split(",")]
        return f'{here}: {key} = "{item["input"]}"{inside} is not allowed.{choose_from(str(item["input"]), allowed)}'
    if item["type"] == "value_error":
        text = str(item["ctx"]["error"]).replace("\0", key)
        return f"{here}: {text}{inside}"
    return f"{here}: {key} = {item['input']!r}{inside}: {item['msg'][0].lower()}{item['msg'][1:]}"


def allowed_keys(model: type[BaseModel], location: Location) -> list[str]:
    """Keys of the (nested) model at a location; empty when it cannot be told."""
    current: Any = model
    for part in location:
        models = (
            list(_models_in(current.model_fields[part].annotation))
            if part in getattr(current, "model_fields", {})
            else []
        )
        if models:
            current = models[0]
        elif not isinstance(part, int) and part not in getattr(current, "model_fields", {}):
            continue  # a name the user chose, such as axes.X
    return [f.alias or n for n, f in getattr(current, "model_fields", {}).items()]


def _models_in(annotation: Any) -> Iterable[type[BaseModel]]:
    if isinstance(annotation, type) and issubclass(annotation, BaseModel):
        yield annotation
    for inner in getattr(annotation, "__args__", ()):
        yield from _models_in(inner)


class Problems:
    """Collects what is wrong in a file, so that all of it is reported at once."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.found: list[str] = []

    def add(self, location: Location, text: str) -> None:
        self.found.append(f"{self.document.where(location)}: {text}")

    def attempt(self, location: Location, make: Callable[[], Any]) -> Any:
        """Call `make`; a complaint is noted with file and line, and None returned."""
        try:
            return make()
        except DataError as error:
            self.found.extend(error.problems)
        except UsageError as error:
            self.add(location, str(error))
        return None

    def raise_if_any(self) -> None:
        if self.found:
            raise DataError(list(dict.fromkeys(self.found)))
