"""Draw a result or put it into one line: rooms that compute call these functions, and `vcmm.show` registers the implementations.

Both are generic functions of the class of the result. The package registers by `fill_from` what to load before the first
call; so no room that computes imports charts, and a result without a picture loads none.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import singledispatch
from typing import Any

from vcmm.core.errors import UsageError

_waiting: list[Callable[[], object]] = []


def fill_from(load: Callable[[], object]) -> None:
    """Register `load`, which is called before the first picture or line: it registers the implementations of `picture` and `line`."""
    _waiting.append(load)


def _fill() -> None:
    for load in (
        _waiting
    ):  # an import, which costs nothing the second time and makes a second thread wait for the first
        load()


@singledispatch
def picture(result: Any, *given: Any) -> Any:
    """Draw a result on matplotlib Axes. Raises UsageError for a class that has none."""
    raise UsageError(f"{type(result).__name__} has no picture")


@singledispatch
def line(result: Any) -> str:
    """Describe a result in one line. Raises UsageError for a class that has none."""
    raise UsageError(f"{type(result).__name__} has no line")


def draw(result: Any, *given: Any) -> Any:
    """Draw a result by `picture`, after `vcmm.show` has registered its implementations."""
    _fill()
    return picture(result, *given)


def say(result: Any) -> str:
    """Describe a result by `line`, after `vcmm.show` has registered its implementations."""
    _fill()
    return line(result)
