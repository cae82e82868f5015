"""A part of another system in the terms of part/1, and its TOML text."""

from __future__ import annotations

import json
from collections.abc import Collection, Iterable, Mapping, Sequence
from dataclasses import dataclass, field
from typing import Any

import numpy as np

from vcmm.core.run import Array

DEFAULT_EXTENT = 20.0  # mm, side or length of a feature whose extent neither the file nor its points tell
DIGITS = 12  # significant digits of a length in mm: 1e-9 mm at a metre


class NotHere(Exception):
    """A characteristic that part/1 cannot express; the text names the part of it."""


@dataclass(frozen=True, eq=False)
class DrawnPart:
    """features, characteristics: the tables of part/1. points: measured, by feature (n, 3) mm. targets: touches of a
    measuring program by feature, (n, 6): place in mm and outward normal. tip_radius mm: the measured points are centres of
    such a tip (None: on the surface). notes: what was assumed or left out, with its line. silent: characteristics that stand in the
    file as a comment, each with its reason.
    """

    source: str
    name: str
    features: dict[str, dict[str, Any]] = field(default_factory=dict)
    characteristics: list[dict[str, Any]] = field(default_factory=list)
    points: dict[str, Array] = field(default_factory=dict)
    targets: dict[str, Array] = field(default_factory=dict)
    notes: list[str] = field(default_factory=list)
    tip_radius: float | None = None
    silent: Sequence[tuple[dict[str, Any], str]] = ()

    def free_name(self, wanted: str) -> str:
        """Return a name for a characteristic that no other one has."""
        return _free(wanted, {c["name"] for c in self.characteristics})

    def free_feature(self, wanted: str) -> str:
        """Return a name for a feature that no other one has."""
        return _free(wanted, self.features)

    def reference_first(self, features: Sequence[str]) -> list[str]:
        """Return the features of a distance as part/1 wants them: a plane first, then axes, centres last; otherwise as they came."""
        rank = {"plane": 0, "line": 1, "cylinder": 1, "cone": 1}
        return sorted(features, key=lambda n: rank.get(self.features[n]["type"], 2))


def mm(*values: float) -> str:
    """Return lengths as a text with the unit: "1 2 3 mm"."""
    return " ".join(_digits(v) for v in values) + " mm"


def deg(value: float) -> str:
    """Return an angle in rad as a text in degrees."""
    return f"{_digits(np.degrees(value))} deg"


def unit(direction: Sequence[float]) -> list[float]:
    """Return a direction of length 1, as a list. Raises ValueError for no direction at all."""
    d = np.asarray(direction, float)
    size = float(np.linalg.norm(d))
    if not np.isfinite(size) or size < 1e-9:
        raise ValueError("the direction has no length")
    return [float(f"{v:.15g}") for v in d / size]


def part_toml(drawn: DrawnPart) -> str:
    """Return the text of a part/1 file; the notes are at its head."""
    lines = [f"# part of {comment(drawn.source)}, drawing frame = its coordinate system"]
    lines += [f"# {comment(note)}" for note in drawn.notes]
    lines += ['vcmm = "part/1"', f"name = {toml_value(drawn.name)}"]
    lines += [
        'expansion = "11.5 um/(m K)"             # steel: state yours',
        'u_expansion = "1 um/(m K)"',
        "",
    ]
    lines += features_toml(drawn, "features")
    for c in drawn.characteristics:
        lines += ["", *_characteristic_toml(c)]
    for c, why in drawn.silent:
        lines += ["", f"# {comment(why)}:", *(f"# {line}" for line in _characteristic_toml(c))]
    return "\n".join(lines) + "\n"


def _characteristic_toml(table: Mapping[str, Any]) -> list[str]:
    return ["[[characteristics]]", *(f"{k} = {toml_value(v)}" for k, v in table.items())]


def features_toml(drawn: DrawnPart, head: str) -> list[str]:
    """Return the lines of the table of features."""
    return [f"[{head}]", *(f"{_key(n)} = {toml_value(t)}" for n, t in drawn.features.items())]


def toml_value(value: Any) -> str:
    """Return a value as TOML: texts, numbers, lists, inline tables."""
    if isinstance(value, bool):
        return "true" if value else "false"
    if isinstance(value, str):
        return json.dumps(value, ensure_ascii=False).replace("\x7f", "\\u007f")
    if isinstance(value, Mapping):
        return "{ " + ", ".join(f"{_key(k)} = {toml_value(v)}" for k, v in value.items()) + " }"
    if isinstance(value, Iterable):
        return "[" + ", ".join(toml_value(v) for v in value) + "]"
    return repr(float(value)) if isinstance(value, float) else str(value)


def _key(name: str) -> str:
    plain = name.isascii() and name.replace("_", "").replace("-", "").isalnum()
    return name if plain else toml_value(name)


def comment(text: str) -> str:
    """Return a text as the words of one line."""
    return " ".join("".join(c if c.isprintable() else " " for c in text).split())


def _digits(value: float) -> str:
    return f"{value + 0.0:.{DIGITS}g}"


def _free(wanted: str, taken: Collection[str]) -> str:
    """Return the name itself, or the first of "name (2)", "name (3)" ... that is free."""
    names = (wanted if n == 1 else f"{wanted} ({n})" for n in range(1, len(taken) + 2))
    return next(name for name in names if name not in taken)


def spanned_plane(place: Array, axis: Array, points: Array) -> dict[str, Any]:
    """Return centre, size and first direction of the rectangle of points (n, 3) on a plane; {} where they span none."""
    u = np.eye(3)[0] if abs(axis[0]) < 0.9 else np.eye(3)[1]
    u = u - axis * (u @ axis)
    u /= np.linalg.norm(u)
    both = np.stack([points @ u, points @ np.cross(axis, u)], axis=1)
    low, high = both.min(axis=0), both.max(axis=0)
    if (high - low).min() <= 0.0:
        return {}
    middle = 0.5 * (low + high)
    at = axis * (place @ axis) + u * middle[0] + np.cross(axis, u) * middle[1]
    return {"point": mm(*at), "size": mm(*(high - low)), "u": unit(u)}
