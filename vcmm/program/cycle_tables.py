"""Canned cycles as tables: parameter -> meaning -> primitive, the same for every language.

A row says in the order of the manual what each parameter is, as in "RTP mm, SDIS size, DP mm?, STA deg": its name in the manual and its
kind. `Cycle.read` turns what a program gives (numbers, or None where a parameter is left out) into mm, radians and mm/min by that kind;
the primitive gets these values by name and makes the moves (vcmm.program.drilling.Hole, vcmm.program.cutter.CycleCutter).
"""

from __future__ import annotations

import math
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from typing import Generic, NamedTuple, TypeVar

Primitive = TypeVar("Primitive")

KINDS = {  # kind -> what becomes of a number
    "mm": "a length with its sign, mm",
    "size": "a length without sign, mm",
    "deg": "an angle, rad",
    "feed": "a feed, mm/min; 0: the one in force",
    "count": "a whole number",
    "plain": "a number as it is",
    "text": "a name; read apart",
}


class CycleParameter(NamedTuple):
    """One parameter of a cycle. open: whether None stays None where it is left out; else it is zero."""

    name: str
    kind: str
    open: bool = False


@dataclass(frozen=True)
class Values:
    """What a cycle is given, by the names of its manual: mm, rad, mm/min. A name that its table has not is zero."""

    given: Mapping[str, float | None]

    def __getitem__(self, name: str) -> float:
        return self.given.get(name) or 0.0

    def has(self, name: str) -> bool:
        """Whether it was given at all."""
        return self.given.get(name) is not None

    def number(self, name: str) -> int:
        """A whole number."""
        return round(self[name])

    def without(self, name: str, otherwise: float) -> float:
        """The value; `otherwise` where it is left out."""
        value = self.given.get(name)
        return otherwise if value is None else value


@dataclass(frozen=True)
class Cycle(Generic[Primitive]):
    """One row: parameters in their order, and the primitive that makes the moves."""

    parameters: tuple[CycleParameter, ...]
    primitive: Primitive

    def read(self, given: Sequence[float | None], unit: float, feed_unit: float) -> Values:
        """unit: mm of a length of the program; feed_unit: mm/min of a feed. What is given beyond the table is left alone."""
        by: dict[str, Callable[[float], float]] = {
            "mm": lambda v: v * unit, "size": lambda v: abs(v) * unit, "deg": math.radians, "feed": lambda v: v * feed_unit,
            "count": float, "plain": float, "text": float,
        }  # fmt: skip
        out: dict[str, float | None] = {}
        for k, parameter in enumerate(self.parameters):
            value = given[k] if k < len(given) else None
            if value is not None:
                out[parameter.name] = by[parameter.kind](value)
            elif not parameter.open:
                out[parameter.name] = 0.0
        return Values(out)


def cycle(parameters: str, primitive: Primitive) -> Cycle[Primitive]:
    """A row from its text. Raises ValueError for a kind that does not exist."""
    out = []
    for part in parameters.split(","):
        name, kind = part.split()
        if kind.rstrip("?") not in KINDS:
            raise ValueError(f"{kind} is no kind of a parameter; known are {', '.join(KINDS)}")
        out.append(CycleParameter(name, kind.rstrip("?"), kind.endswith("?")))
    return Cycle(tuple(out), primitive)
