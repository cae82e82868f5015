"""A question of diagnosis put to one effect."""

from __future__ import annotations

from typing import Any


def ask(effect: Any, what: str, *of: Any) -> Any:
    """The answer of one function of `diagnosis` to `effect`."""
    return getattr(effect.diagnosis, what)(effect, *of)
