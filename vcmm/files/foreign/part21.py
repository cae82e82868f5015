"""The exchange structure of ISO 10303-21 (STEP files): entities by number, their values, their lines, their units."""

from __future__ import annotations

import math
import re
from bisect import bisect_right
from collections.abc import Iterator
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from vcmm.core.confinement import check_inside
from vcmm.core.errors import DataError
from vcmm.core.text import brief

LARGEST = 300_000_000  # bytes
DEEPEST = 40  # lists within lists
ENTITY = re.compile(r"#(\d+)\s*=\s*((?:[^;']+|'[^']*')*+);")
TOKEN = re.compile(
    r"\s*(?:#(?P<ref>\d+)|'(?P<text>(?:[^']|'')*)'|\.(?P<word>\w+)\.|(?P<number>[+-]?\d+\.?\d*(?:[eE][+-]?\d+)?)"
    r"|(?P<name>[A-Za-z_]\w*)|(?P<sign>[(),$*]))"
)
PREFIX = {"MILLI": 1e-3, "CENTI": 1e-2, "DECI": 1e-1, "KILO": 1e3, "MICRO": 1e-6, "NANO": 1e-9}
UNITS = {"METRE": 1000.0, "RADIAN": 1.0}  # to mm and rad


class Ref(int):
    """The number of a referenced entity."""


@dataclass(frozen=True, eq=False)
class Entity:
    """number, where (file:line), and the values of each of its names: one of a simple, several of a complex entity."""

    number: int
    at: str
    parts: dict[str, list[Any]]

    def values(self, *names: str) -> list[Any]:
        """Return the values under the first of the names that it has, or none."""
        return next((self.parts[n] for n in names if n in self.parts), [])


class Part21:
    """A file: `numbers` in file order, entities parsed on demand."""

    def __init__(self, path: Path, text: str) -> None:
        self.path = path
        self._starts = [m.start() for m in re.finditer("\n", text)]
        self._bodies: dict[int, tuple[int, str]] = {}
        self._found: dict[int, Entity] = {}
        for match in ENTITY.finditer(text):
            number = int(match[1])
            if number in self._bodies:
                raise DataError(f"{self._at(match.start())}: #{number} is defined a second time")
            self._bodies[number] = (match.start(), match[2])

    def _at(self, place: int) -> str:
        return f"{self.path}:{bisect_right(self._starts, place) + 1}"

    @cached_property
    def numbers(self) -> list[int]:
        """Numbers of the entities in the order of the file."""
        return list(self._bodies)

    @cached_property
    def _by_name(self) -> dict[str, list[int]]:
        out: dict[str, list[int]] = {}
        for number, (_, body) in self._bodies.items():
            complex_ = body.lstrip().startswith("(")
            names = self[number].parts if complex_ else [body.partition("(")[0].strip().upper()]
            for name in names:
                out.setdefault(name, []).append(number)
        return out

    def of(self, *names: str) -> Iterator[Entity]:
        """Yield entities with one of the names, in the order of the file."""
        for number in sorted({n for name in names for n in self._by_name.get(name, [])}, key=self._order):
            yield self[number]

    def _order(self, number: int) -> int:
        return self._bodies[number][0]

    def __contains__(self, number: object) -> bool:
        return number in self._bodies

    def __getitem__(self, number: int) -> Entity:
        """Return an entity. DataError: no such entity, values that cannot be read."""
        if number not in self._found:
            if number not in self._bodies:
                raise DataError(f"{self.path}:1: #{number} is referred to and does not exist")
            place, body = self._bodies[number]
            at = self._at(place)
            self._found[number] = Entity(number, at, _Reader(at, body).parts())
        return self._found[number]

    def measure(self, number: int) -> float:
        """Return a measure with its unit, in mm or rad. DataError: no measure, a unit that is neither length nor angle."""
        entity = self[number]
        value, unit = (entity.values("MEASURE_WITH_UNIT", "LENGTH_MEASURE_WITH_UNIT", "PLANE_ANGLE_MEASURE_WITH_UNIT") + [None, None])[:2]  # fmt: skip
        if not isinstance(value, float) or not isinstance(unit, Ref):
            raise DataError(f"{entity.at}: expected a measure with unit")
        return value * self._factor(unit, 0)

    def _factor(self, number: int, depth: int) -> float:
        entity = self[number]
        if si := entity.values("SI_UNIT"):
            prefix, name = si[-2:]
            if name in UNITS and (prefix is None or prefix in PREFIX):
                return UNITS[name] * PREFIX.get(prefix, 1.0)
        if (factor := entity.values("CONVERSION_BASED_UNIT")) and depth < DEEPEST:
            inner = self[factor[1]].values("MEASURE_WITH_UNIT", "LENGTH_MEASURE_WITH_UNIT", "PLANE_ANGLE_MEASURE_WITH_UNIT")  # fmt: skip
            if len(inner) == 2 and isinstance(inner[0], float):
                return inner[0] * self._factor(inner[1], depth + 1)
        raise DataError(f"{entity.at}: expected a unit of length or angle, in SI or converted to it")


class _Reader:
    """Reads the values of one entity."""

    def __init__(self, at: str, body: str) -> None:
        self.at, self.body, self.place = at, body, 0

    def parts(self) -> dict[str, list[Any]]:
        """Name -> values."""
        out: dict[str, list[Any]] = {}
        kind, value = self._next()
        if kind == "name":
            return {value.upper(): self._list(0)}
        if value != "(":
            raise self._wrong()
        while (token := self._next())[1] != ")":
            if token[0] != "name":
                raise self._wrong()
            out[token[1].upper()] = self._list(0)
        return out

    def _list(self, depth: int) -> list[Any]:
        if depth > DEEPEST or self._next()[1] != "(":
            raise self._wrong()
        return self._read_list(depth)

    def _read_list(self, depth: int) -> list[Any]:
        out: list[Any] = []
        while True:
            kind, value = self._next()
            if kind == "sign" and value == ")":
                return out
            if kind == "sign" and value == ",":
                continue
            out.append(self._value(kind, value, depth))

    def _value(self, kind: str, value: str, depth: int) -> Any:
        if depth > DEEPEST:
            raise self._wrong()
        if kind == "sign":
            return self._read_list(depth + 1) if value == "(" else None
        if kind == "name":  # a typed value: what it holds
            members = self._list(depth + 1)
            return members[0] if len(members) == 1 else members
        if kind == "number":
            number = float(value)
            if not math.isfinite(number):
                raise self._wrong()
            return number
        return Ref(value) if kind == "ref" else value

    def _next(self) -> tuple[str, str]:
        match = TOKEN.match(self.body, self.place)
        if match is None or match.lastgroup is None:
            raise self._wrong()
        self.place = match.end()
        return match.lastgroup, match[match.lastgroup]

    def _wrong(self) -> DataError:
        rest = self.body[self.place : self.place + 40]
        return DataError(
            f'{self.at}: "{brief(rest)}" cannot be read as the values of an entity (ISO 10303-21)'
        )


def read_part21(path: str | Path) -> Part21:
    """Raises DataError with file and line: no such file, no STEP file, values that cannot be read."""
    file = Path(path)
    check_inside(file)
    try:
        if file.stat().st_size > LARGEST:
            raise DataError(f"{file}: larger than {LARGEST / 1e6:.0f} MB; export the part alone")
        text = file.read_text(encoding="utf-8", errors="replace")
    except OSError as error:
        raise DataError(f"{file}: cannot be read ({error.strerror})") from None
    if not text.lstrip("\ufeff \r\n\t").startswith("ISO-10303-21"):
        raise DataError(f"{file}:1: this is no STEP file: it does not begin with ISO-10303-21")
    part21 = Part21(file, re.sub(r"/\*.*?\*/", lambda m: "\n" * m[0].count("\n"), text, flags=re.S))
    if not part21.numbers:
        raise DataError(f"{file}:1: this STEP file holds no entity")
    _check_depth(file, text)
    return part21


def _check_depth(file: Path, text: str) -> None:
    """Raise DataError where lists are nested deeper than any value is: Open CASCADE would end the whole program by a full stack."""
    depth = line = 0
    for match in re.finditer(r"'[^']*'|[()\n]", text):
        mark = match[0]
        line += mark.count("\n")
        depth += (mark == "(") - (mark == ")")
        if depth > DEEPEST:
            raise DataError(
                f"{file}:{line + 1}: lists are nested deeper than {DEEPEST}; no STEP file needs that"
            )
