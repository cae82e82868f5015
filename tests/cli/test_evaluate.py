"""vcmm evaluate: every part keeps its sheet."""

from __future__ import annotations

from vcmm.cli.evaluate import _sheet_name


def test_parts_with_names_that_look_alike_keep_their_sheets() -> None:
    names: list[str] = []
    for part in ("a", "a/b", "a?b", "A_B", ""):
        names.append(_sheet_name(part, names))
    assert names == ["sheet-a.html", "sheet-a_b.html", "sheet-a_b-2.html", "sheet-A_B-3.html", "sheet.html"]
