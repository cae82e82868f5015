"""Canned cycles as tables: parameter -> meaning -> primitive, the same for every language.

A row says in the order of the manual what each parameter is, as in "RTP mm, SDIS size, DP mm?, STA deg" or "Q262=diameter mm!": its name
in the manual, what it means where primitives of several cycles share a meaning, and its kind. "?": it stays open where it is left out
(else it is zero); "!": the cycle needs it. `Cycle.read` turns what a program gives into mm, radians and mm/min by that kind; the
primitive gets these values by meaning and makes the moves (vcmm.program.drilling.Hole, .cutter.CycleCutter, .probing.Feeler).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

Primitive = TypeVar("Primitive")

NUMBER_KINDS = {  # kind -> what becomes of a number
    "mm": "a length with its sign, mm",
    "size": "a length without sign, mm",
    "radius": "a length along X, mm; halved where X counts diameters",
    "steps": "a length that counts increments where it has no point, mm",
    "deg": "an angle, rad",
    "feed": "a feed, mm/min; 0: the one in force",
    "time": "a time, s",
    "count": "a whole number",
    "plain": "a number as it is",
    "text": "a name; read apart",
}


class CycleParameter(NamedTuple):
    """One parameter of a cycle. open: whether it stays open where it is left out, else it is zero; is_needed: whether it may not be."""

    name: str
    meaning: str
    kind: str
    open: bool = False
    is_needed: bool = False


Conversion = Callable[[CycleParameter, float], float]


def in_units(length: float, feed: float) -> Conversion:
    """Return the conversion of lengths and feeds. length: mm of a length of the program; feed: mm/min of a feed."""
    by: dict[str, Callable[[float], float]] = {
        "mm": lambda v: v * length, "size": lambda v: abs(v) * length, "deg": math.radians, "feed": lambda v: v * feed,
    }  # fmt: skip
    return lambda parameter, value: by.get(parameter.kind, float)(value)


@dataclass(frozen=True)
class Values:
    """Inputs of a cycle, by meaning: mm, rad, mm/min. A meaning missing in its table is zero."""

    numbers: Mapping[str, float]

    def __getitem__(self, name: str) -> float:
        return self.numbers.get(name, 0.0)

    def has(self, name: str) -> bool:
        """Return whether it was given at all."""
        return name in self.numbers

    def number(self, name: str) -> int:
        """Return a whole number."""
        return round(self[name])

    def without(self, name: str, otherwise: float) -> float:
        """Return the value; `otherwise` where it is left out."""
        return self.numbers.get(name, otherwise)


@dataclass(frozen=True)
class Cycle(Generic[Primitive]):
    """One row: parameters in their order, and the primitive that makes the moves."""

    parameters: tuple[CycleParameter, ...]
    primitive: Primitive

    def uses(self, name: str) -> bool:
        """Return whether the cycle has a parameter of that name."""
        return any(p.name == name for p in self.parameters)

    @property
    def required_names(self) -> tuple[str, ...]:
        """Names of the parameters without which it does not go."""
        return tuple(p.name for p in self.parameters if p.is_needed)

    def by_name(self, arguments: Sequence[float | None]) -> dict[str, float]:
        """Return the arguments in the order of the manual, by name. Arguments beyond the table are left out."""
        return {p.name: v for p, v in zip(self.parameters, arguments) if v is not None}

    def read(self, numbers: Mapping[str, float], convert: Conversion) -> Values:
        """Return the values of the given parameters by meaning."""
        out: dict[str, float] = {}
        for parameter in self.parameters:
            if parameter.name in numbers:
                out[parameter.meaning] = convert(parameter, numbers[parameter.name])
            elif not parameter.open:
                out.setdefault(parameter.meaning, 0.0)
        return Values(out)


def cycle(parameters: str, primitive: Primitive) -> Cycle[Primitive]:
    """Return a row from its text. Raises ValueError for a kind that does not exist."""
    out = []
    for part in filter(None, map(str.strip, parameters.split(","))):
        word, kind = part.split()
        name, _, meaning = word.partition("=")
        if kind.rstrip("?!") not in NUMBER_KINDS:
            raise ValueError(f"{kind} is no kind of a parameter; known are {', '.join(NUMBER_KINDS)}")
        out.append(
            CycleParameter(name, meaning or name, kind.rstrip("?!"), kind.endswith("?"), kind.endswith("!"))
        )
    return Cycle(tuple(out), primitive)
