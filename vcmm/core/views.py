"""How what is computed is drawn and said in one line: rooms that compute call these functions, and `vcmm.show` says how.

Both are generic functions of the class of the result. The package tells them by `fill_from` what is to be loaded before the first
call; so no room that computes imports charts, and a result that nobody draws loads none.
"""

from __future__ import annotations

from collections.abc import Callable
from functools import singledispatch
from typing import Any

from vcmm.core.errors import UsageError

_waiting: list[Callable[[], object]] = []


def fill_from(load: Callable[[], object]) -> None:
    """Have `load` called before the first picture or line: it registers them with `picture` and `line`."""
    _waiting.append(load)


def _fill() -> None:
    for load in (
        _waiting
    ):  # an import, which costs nothing the second time and makes a second thread wait for the first
        load()


@singledispatch
def picture(result: Any, *given: Any) -> Any:
    """The picture of a result on matplotlib Axes. Raises UsageError for a class that has none."""
    raise UsageError(f"{type(result).__name__} has no picture")


@singledispatch
def line(result: Any) -> str:
    """A result in one line. Raises UsageError for a class that has none."""
    raise UsageError(f"{type(result).__name__} has no line")


def draw(result: Any, *given: Any) -> Any:
    """`picture`, once `vcmm.show` has said how."""
    _fill()
    return picture(result, *given)


def say(result: Any) -> str:
    """`line`, once `vcmm.show` has said how."""
    _fill()
    return line(result)
