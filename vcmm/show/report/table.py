"""Tables with headers a screen reader can use, tabular figures and cells that carry a verdict."""

from __future__ import annotations

from collections.abc import Collection, Sequence
from dataclasses import dataclass
from typing import Literal

from vcmm.core.errors import DataError
from vcmm.show.report.text import DASH, escape, micro, number

MISSING = f'<span class="missing" title="not available">{DASH}</span>'
DENSE = 10  # columns from which on they stand closer
_NOT_A_VALUE = {DASH, "nan", "inf", "-inf", "+inf", "none"}


@dataclass(frozen=True)
class Cell:
    """A cell with a verdict, shown as a tinted badge; the words must say the verdict too."""

    text: object
    kind: Literal["good", "warning", "bad", "muted"] = "muted"


@dataclass(frozen=True)
class Raw:
    """HTML or SVG put into a cell as it is."""

    html: str


def content(cell: object) -> str:
    """Return HTML of a cell: text escaped, floats with 4 significant digits, missing values as an en dash."""
    if isinstance(cell, Raw):
        return cell.html
    if isinstance(cell, Cell):
        return f'<span class="badge {cell.kind}">{content(cell.text)}</span>'
    if isinstance(cell, bool):
        return "yes" if cell else "no"
    words = number(float(cell), 4) if isinstance(cell, float) else str(cell)
    return MISSING if words.strip().lower() in _NOT_A_VALUE else escape(micro(words))


def table(
    columns: Sequence[str],
    rows: Sequence[Sequence[object]],
    *,
    caption: str = "",
    numeric: Collection[int] = (),
    emphasise: Collection[int] = (),
    foot: Sequence[Sequence[object]] = (),
) -> str:
    """Return a table; the first cell of a row is its header.

    `numeric`: columns set to the right in tabular figures. `emphasise`: rows that matter. `foot`: closing rows
    (totals). DataError: a row with more or fewer cells than there are columns.
    """
    _check(columns, [*rows, *foot])
    head = "".join(_head(name, _align(i, numeric)) for i, name in enumerate(columns)) if any(columns) else ""
    body = "".join(_row(row, numeric, i in emphasise) for i, row in enumerate(rows))
    last = f"<tfoot>{''.join(_row(row, numeric, False) for row in foot)}</tfoot>" if foot else ""
    dense = ' class="dense"' if len(columns) >= DENSE else ""
    name = f"<caption>{escape(caption)}</caption>" if caption else ""
    top = f"<thead><tr>{head}</tr></thead>" if head else ""
    return f'<div class="scroll"><table{dense}>{name}{top}<tbody>{body}</tbody>{last}</table></div>'


def _check(columns: Sequence[str], rows: Sequence[Sequence[object]]) -> None:
    wrong = [i for i, row in enumerate(rows) if len(row) != len(columns)]
    if wrong:
        i = wrong[0]
        raise DataError(
            f"Table row {i + 1} has {len(rows[i])} cells but the table has {len(columns)} columns: "
            "give every row one cell per column."
        )


def _head(name: str, align: str) -> str:
    """Return a column's name; a corner without one is no header."""
    return f'<th scope="col"{align}>{escape(name)}</th>' if name else "<td></td>"


def _align(column: int, numeric: Collection[int]) -> str:
    return ' class="num"' if column in numeric else ""


def _row(row: Sequence[object], numeric: Collection[int], strong: bool) -> str:
    first = f'<th scope="row"{_align(0, numeric)}>{content(row[0])}</th>' if row else ""
    rest = "".join(f"<td{_align(i, numeric)}>{content(cell)}</td>" for i, cell in enumerate(row) if i > 0)
    kind = ' class="strong"' if strong else ""
    return f"<tr{kind}>{first}{rest}</tr>"
