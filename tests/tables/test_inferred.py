"""Words about several parts."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from vcmm.tables.inferred import warnings_of_parts


def part(name: str, *warnings: str) -> Any:
    return SimpleNamespace(part=name, warnings=warnings)


def test_what_only_some_parts_say_stands_with_their_names() -> None:
    parts = [part("A", "cold room"), part("B", "cold room", "oval"), part("C", "cold room", "oval", "oval")]
    assert warnings_of_parts(parts) == ["cold room", 'part "B", "C": oval']
    assert warnings_of_parts([part("", "oval")]) == ["oval"]
