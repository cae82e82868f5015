"""A result in one line, as a notebook or a debugger shows it: name, value +- U with unit and k, decision with its probability."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Protocol, TypeVar

from vcmm.core.errors import choose_from
from vcmm.core.views import say

SHOWN = 4  # characteristics of a line; of more the number of the rest is said


def value_text(value: float, unit: str) -> str:
    """29.99998 mm, or an angle in degrees."""
    return f"{value:.5f} mm" if unit == "mm" else f"{math.degrees(value):.6f}°"


def answer(c: Any) -> str:
    """Of a CharacteristicResult: value ± U (k, p), or the interval where U has no end; the decision with its probability."""
    return say(c)


def first_few(texts: Iterable[str]) -> str:
    """The first few, and how many more."""
    every = list(texts)
    rest = f"; {len(every) - SHOWN} more" if len(every) > SHOWN else ""
    return "; ".join(every[:SHOWN]) + rest


class HasName(Protocol):
    @property
    def name(self) -> str: ...


T = TypeVar("T", bound=HasName)


def of_name(all_of_them: Iterable[T], name: str) -> T:
    """The one of this name. KeyError with the closest names where none has it."""
    every = list(all_of_them)
    for c in every:
        if c.name == name:
            return c
    raise KeyError(f'no characteristic "{name}".{choose_from(str(name), [c.name for c in every])}')
