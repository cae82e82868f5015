"""Effects and what is not known of them as text of a machine file: [[effects]] and [[inputs]]."""

from __future__ import annotations

import re
from collections.abc import Mapping
from typing import Any

import numpy as np

from vcmm.core.axes import is_rotary
from vcmm.core.effect import Effect, parameter_fields, place_fields, unit_of
from vcmm.core.inputs import Input
from vcmm.core.laws import MultivariateNormal
from vcmm.core.units import in_unit


def effect_toml(effect: Effect, comment: str = "") -> str:
    """One [[effects]] table with all places, parameters and further keys of the effect."""
    lines = [
        f"[[effects]]{f'                                # {comment}' if comment else ''}",
        f'effect = "{effect.name}"',
    ]
    back = {name: word for word, name in effect.about.aliases.items() if re.fullmatch(r"[\w-]+", word)}
    for place in place_fields(effect):
        value = getattr(effect, place.name)
        if value != "" and not (place.metadata["quiet"] and value == place.default):
            lines.append(f"{place.name} = {_plain(value)}")
    letter = str(getattr(effect, "component", ""))[:1]
    for spec in parameter_fields(effect):
        if spec.metadata["only"] and letter not in spec.metadata["only"]:
            continue  # a shift has no tilt
        lines.append(f"{back.get(spec.name, spec.name)} = {_quantity(effect, spec)}")
    done = {f.name for f in (*place_fields(effect), *parameter_fields(effect))}
    for name, value in vars(effect).items():
        if name not in done and isinstance(value, str | int) and value != "" and not name.startswith("_"):
            lines.append(f"{name} = {_plain(value)}")
        elif name not in done and isinstance(value, float) and value != 0.0:
            lines.append(f'{name} = "{value:.10g} mm"')
    return "\n".join([*lines, *_array_lines(effect)]) + "\n"


def _array_lines(effect: Effect) -> list[str]:
    """Return the lines of what an effect needs besides its parameters: ends or nodes of a travel, grids and table, points."""
    lines = []
    letters = tuple(getattr(effect, "arguments", ()))
    if letters and vars(effect).get("grids"):
        grids = [_positions(a, g) for a, g in zip(letters, vars(effect)["grids"])]
        lines += [f"arguments = [{', '.join(_plain(a) for a in letters)}]", f"grids = [{', '.join(grids)}]"]
    if isinstance(process := vars(effect).get("process"), Mapping):
        lines.append(f"process = {{ {', '.join(f'{k} = {_word(v)}' for k, v in process.items())} }}")
    for name in ("nodes", "deviation", "scatter", "reading_u"):
        value = np.asarray(vars(effect).get(name, ()), dtype=float)
        if not value.size or name in {f.name for f in parameter_fields(effect)}:
            continue
        if value.ndim == 1:
            lines.append(f"{name} = {_positions(effect.link, value)}")
        else:
            points = (f'"{" ".join(f"{v:.10g}" for v in row)} mm"' for row in value)
            lines.append(f"{name} = [{', '.join(points)}]")
    return lines


def _word(value: Any) -> str:
    """A text, a number or a list of them, as TOML writes it."""
    if isinstance(value, str):
        return f'"{value}"'
    return f"[{', '.join(_word(v) for v in value)}]" if isinstance(value, list | tuple) else f"{value:.10g}"


def _positions(letter: str, values: Any) -> str:
    unit = "rad" if is_rotary(letter) else "mm"
    return f'"{" ".join(f"{v:.10g}" for v in np.asarray(values, dtype=float))} {unit}"'


def _quantity(effect: Effect, spec: Any) -> str:
    """One text for a number or a row of them, a list of texts for a table."""
    unit = unit_of(effect, spec.name)
    numbers = np.asarray(getattr(effect, spec.name), dtype=float) / _factor(unit)
    end = f" {unit}" if unit not in ("", "1") else ""
    rows = numbers if numbers.ndim == 2 else np.ravel(numbers)[None]
    texts = [f'"{" ".join(f"{n:.10g}" for n in row)}{end}"' for row in rows]
    return f"[{', '.join(texts)}]" if numbers.ndim == 2 else texts[0]


def _factor(unit: str) -> float:
    return 1.0 if unit in ("", "1") else 1.0 / in_unit(1.0, unit)


def _plain(value: object) -> str:
    return f'"{value}"' if isinstance(value, str) else str(value)


def input_toml(effect: Effect, quantity: Input, source: str) -> str:
    """One [[inputs]] table for a parameter of the effect: u for a number, a covariance for an array."""
    spec = next(f for f in parameter_fields(effect) if f.name == quantity.parameter)
    unit = unit_of(effect, spec.name)
    lines = ["[[inputs]]", f'effect = "{effect.name}"']
    for place in place_fields(effect):
        value = getattr(effect, place.name)
        if value != "" and not (place.metadata["quiet"] and value == place.default):
            lines.append(f"{place.name} = {_plain(value)}")
    lines.append(f'parameter = "{quantity.parameter}"')
    if isinstance(quantity.law, MultivariateNormal):
        rows = quantity.law.covariance / _factor(unit) ** 2
        lines += [
            'law = "multivariate"',
            "covariance = [" + ", ".join(f"[{', '.join(f'{v:.6g}' for v in row)}]" for row in rows) + "]",
        ]
    else:
        spread = f"{float(np.ravel(quantity.law.u)[0]) / _factor(unit):.6g}"
        lines += ['law = "normal"', f'u = "{spread} {unit}"' if unit not in ("", "1") else f'u = "{spread}"']
    lines.append(f'evidence = "diagnosed from {source}"')
    return "\n".join(lines) + "\n"
