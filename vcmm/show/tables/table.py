"""A table whose columns are declared once: value of a cell, its text for people, its key in documents and its CSV heading.

A cell is computed from the object of its row in the units of the inside (mm, rad). What has no number is None or not
finite, and shown as a dash. A row with an attribute `unit` ("rad") is written in the units of that kind; else in mm.
"""

from __future__ import annotations

import math
from collections.abc import Callable, Iterable, Sequence
from dataclasses import dataclass, field
from functools import partial
from typing import Any, Generic, Literal, TypeVar

from vcmm.core.text import csv_of

R = TypeVar("R")
Unit = str  # "mm" or "rad": the unit of a row
VALUE_UNITS, FINE_UNITS = {"mm": "mm", "rad": "deg"}, {"mm": "µm", "rad": "µrad"}


@dataclass(frozen=True)
class Writing:
    """Text of values of one kind for people: in the terminal with their unit, on a page where a heading states it.

    Both take the value and the unit of its row. page: None for the same words. words: set to the left.
    """

    terminal: Callable[[Any, Unit], str]
    page: Callable[[Any, Unit], object] | None = None
    words: bool = False


def written_out(value: Any, unit: Unit) -> str:
    """Return a cell of a CSV file: six significant digits of a float, empty where there is no finite number."""
    if value is None or (isinstance(value, float) and not math.isfinite(value)):
        return ""
    return f"{value:.6g}" if isinstance(value, float) else str(value)


WORDS = Writing(lambda value, unit: str(value), words=True)
COUNT = Writing(lambda value, unit: f"{value:,}" if value else "–")


@dataclass(frozen=True)
class Column(Generic[R]):
    """One column over rows of type R.

    head: heading for people, None where only documents have the column; page_head: where the page says it otherwise.
    on: the only place where people see it. key: in JSON documents. csv: heading in a file. Headings and keys may hold
    {unit} (mm, rad), {large} (mm, deg) or {small} (µm, µrad) of the row; of a heading, of the first one.
    """

    head: str | None
    cell: Callable[[R], Any]
    writing: Writing = WORDS
    key: str = ""
    csv: str = ""
    page_head: str | None = None
    on: Literal["both", "terminal", "page"] = "both"
    file: Callable[[Any, Unit], str] = written_out

    def is_shown(self, place: str) -> bool:
        return self.head is not None and self.on in ("both", place)


@dataclass(frozen=True)
class ResultTable(Generic[R]):
    """Columns, the objects of the rows, and the texts around them."""

    title: str
    columns: Sequence[Column[R]]
    rows: Sequence[R]
    caption: str = ""
    page_caption: str = ""  # where the page says more, or other units


@dataclass(frozen=True)
class Cells:
    """A table as it is put before people: headings, rows of cells, indices of the columns that hold words."""

    heads: list[str]
    rows: list[list[Any]]
    words: list[int] = field(default_factory=list)


def unit_of(row: object) -> Unit:
    return str(getattr(row, "unit", "mm"))


def _fill_units(text: str, row: object) -> str:
    unit = unit_of(row)
    return text.format(unit=unit, large=VALUE_UNITS[unit], small=FINE_UNITS[unit]) if "{" in text else text


def in_terminal(table: ResultTable[R]) -> Cells:
    """Return the headings and cells as text with units."""
    columns = [c for c in table.columns if c.is_shown("terminal")]
    rows = [[c.writing.terminal(c.cell(row), unit_of(row)) for c in columns] for row in table.rows]
    return Cells([_head(c.head, table) for c in columns], rows, _words(columns))


def on_page(table: ResultTable[R]) -> Cells:
    """Return the headings and cells as a page has them: text, floats or the cells of `vcmm.show.report`."""
    columns = [c for c in table.columns if c.is_shown("page")]
    rows = [
        [(c.writing.page or c.writing.terminal)(c.cell(row), unit_of(row)) for c in columns]
        for row in table.rows
    ]
    heads = [_head(c.head if c.page_head is None else c.page_head, table) for c in columns]
    return Cells(heads, rows, _words(columns))


def _head(text: str | None, table: ResultTable[R]) -> str:
    return _fill_units(text or "", table.rows[0] if table.rows else None)


def _words(columns: Sequence[Column[R]]) -> list[int]:
    return [i for i, c in enumerate(columns) if c.writing.words]


def html(
    table: ResultTable[R],
    emphasise: Sequence[int] = (),
    more: Sequence[Sequence[object]] = (),
    foot: Sequence[Sequence[object]] = (),
) -> str:
    """Return the table of a report. emphasise: rows that matter; more: further rows, as cells; foot: closing rows."""
    from vcmm.show.report.table import table as html_table

    cells = on_page(table)
    numeric = [i for i in range(len(cells.heads)) if i not in cells.words]
    return html_table(
        cells.heads,
        [*cells.rows, *more],
        caption=table.page_caption or table.caption,
        numeric=numeric,
        emphasise=emphasise,
        foot=foot,
    )


def titled_html(table: ResultTable[R]) -> list[str]:
    """Return the heading and table of a report."""
    from vcmm.show.report.page import heading

    return [heading(table.title), html(table)]


def text(table: ResultTable[R]) -> str:
    """Return the lines of fixed width, as the documentation shows them."""
    shown = in_terminal(table)
    cells = [shown.heads, *shown.rows]
    widths = [max(len(row[i]) for row in cells) for i in range(len(shown.heads))]
    return "\n".join(
        "  ".join(
            c.ljust(w) if i in shown.words else c.rjust(w) for i, (c, w) in enumerate(zip(row, widths))
        ).rstrip()
        for row in cells
    )


def csv_text(table: ResultTable[R]) -> str:
    """Return the columns that have a CSV heading, one line per row."""
    columns = [c for c in table.columns if c.csv]
    rows = ([c.file(c.cell(row), unit_of(row)) for c in columns] for row in table.rows)
    return csv_of([[c.csv for c in columns], *rows])


def records(columns: Sequence[Column[R]], rows: Iterable[R]) -> list[dict[str, Any]]:
    """Return the rows of a JSON document: every column that has a key, as its value."""
    named = [c for c in columns if c.key]
    return [{_fill_units(c.key, row): c.cell(row) for c in named} for row in rows]


def entry(key: str, cell: Callable[[R], Any]) -> Column[R]:
    """Return a column that only JSON documents have."""
    return Column(None, cell, key=key)


def listing(
    title: str,
    heads: Sequence[str],
    rows: Iterable[Sequence[str]],
    words: Sequence[int] = (0,),
    caption: str = "",
) -> ResultTable[Sequence[str]]:
    """Return a table of ready text, row by row. words: columns set to the left."""
    columns = [
        Column(head, partial(_item, i), WORDS if i in words else NUMBER_TEXT) for i, head in enumerate(heads)
    ]
    return ResultTable(title, columns, list(rows), caption)


def _item(index: int, row: Sequence[str]) -> str:
    return row[index]


NUMBER_TEXT = Writing(lambda value, unit: str(value))  # ready text that is set to the right
