"""Write a result in one line for a notebook or a debugger: name, value +- U with unit and k, decision with its probability."""

from __future__ import annotations

import math
from collections.abc import Iterable
from typing import Any, Protocol, TypeVar

from vcmm.core.errors import choose_from
from vcmm.core.views import say

SHOWN = 4  # characteristics of a line; only the number of further ones is shown


def value_text(value: float, unit: str) -> str:
    """Return 29.99998 mm, or an angle in degrees."""
    return f"{value:.5f} mm" if unit == "mm" else f"{math.degrees(value):.6f}°"


def answer(c: Any) -> str:
    """Return the line of a CharacteristicResult: value ± U (k, p), or the interval where U has no end; the decision with its probability."""
    return say(c)


def first_few(texts: Iterable[str]) -> str:
    """Return the first few texts, and the number of the others."""
    every = list(texts)
    rest = f"; {len(every) - SHOWN} more" if len(every) > SHOWN else ""
    return "; ".join(every[:SHOWN]) + rest


class HasName(Protocol):
    @property
    def name(self) -> str: ...


T = TypeVar("T", bound=HasName)


def of_name(all_of_them: Iterable[T], name: str) -> T:
    """Return the item of this name. KeyError with the closest names where none has it."""
    every = list(all_of_them)
    for c in every:
        if c.name == name:
            return c
    raise KeyError(f'no characteristic "{name}".{choose_from(str(name), [c.name for c in every])}')
