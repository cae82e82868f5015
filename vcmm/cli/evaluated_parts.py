"""What vcmm evaluate prints of measured parts."""

from __future__ import annotations

from collections.abc import Collection
from typing import Any


def show_parts(parts: Any, warnings: Collection[str]) -> None:
    """Values, true values, decisions and contributions of every part."""
    from vcmm.console.terminal import say, show_table
    from vcmm.tables.evaluated import largest, stated_with, undecided_because
    from vcmm.tables.inferred import joint_words, shown

    for part in parts:
        show_table(shown(part))
        found = [e.result for e in part.characteristics]
        for sentence in (*stated_with(found), *undecided_because(found), *joint_words(part.joint)):
            say(sentence)
    if len(parts) == 1:
        show_table(largest(e.result for e in parts[0].characteristics))
    for warning in warnings:
        say(f"note: {warning}")
