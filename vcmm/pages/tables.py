"""A table that is shown the same way in the terminal, in a report and in the documentation."""

from __future__ import annotations

from dataclasses import dataclass

from vcmm import report as r


@dataclass(frozen=True)
class Shown:
    """Cells as text; `left`: columns that hold words."""

    title: str
    columns: tuple[str, ...]
    rows: tuple[tuple[str, ...], ...]
    caption: str = ""
    left: tuple[int, ...] = (0,)


def html(shown: Shown) -> list[str]:
    """Heading and table of a report."""
    numeric = tuple(i for i in range(len(shown.columns)) if i not in shown.left)
    return [
        r.heading(shown.title),
        r.table(shown.columns, shown.rows, numeric=numeric, caption=shown.caption),
    ]


def text(shown: Shown) -> str:
    """Lines of fixed width, as the documentation shows them."""
    cells = [shown.columns, *shown.rows]
    widths = [max(len(row[i]) for row in cells) for i in range(len(shown.columns))]
    return "\n".join(
        "  ".join(
            c.ljust(w) if i in shown.left else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths))
        ).rstrip()
        for row in cells
    )
