"""Words about several parts."""

from __future__ import annotations

from types import SimpleNamespace
from typing import Any

from vcmm.tables.inferred import warnings_of_parts, wholes


def part(name: str, *warnings: str) -> Any:
    return SimpleNamespace(part=name, warnings=warnings)


def test_what_only_some_parts_say_stands_with_their_names() -> None:
    parts = [part("A", "cold room"), part("B", "cold room", "oval"), part("C", "cold room", "oval", "oval")]
    assert warnings_of_parts(parts) == ["cold room", 'part "B", "C": oval']
    assert warnings_of_parts([part("", "oval")]) == ["oval"]


def test_parts_as_wholes_are_counted_by_their_decision() -> None:
    joint = [SimpleNamespace(decision=d) for d in ("conforms", "undecided", "conforms")]
    parts: Any = [SimpleNamespace(part=n, joint=j) for n, j in zip("ABC", joint)]
    assert wholes(parts) == [
        "all tolerances together: 2 of 3 parts: conforms (A, C)",
        "all tolerances together: 1 of 3 parts: undecided (B)",
    ]
    assert wholes([SimpleNamespace(part="A", joint=None)]) == []
