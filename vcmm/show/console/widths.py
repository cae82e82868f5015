"""Fit a table that is wider than the terminal: no column of numbers is cut or lost; names and words are shortened."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from itertools import count

from vcmm.core.text import brief
from vcmm.show.tables.table import Cells

# characters that a column and the table take beside their text (rich, box SIMPLE_HEAD)
BETWEEN = 3
AROUND = 1
NAME, WORD = 16, 12  # a name is not shortened below this, a word is broken only beyond that
HEADING = 3  # lines
# longer than a number with its unit, or an interval of two: ready text that was not declared as words
NUMBER = 32


@dataclass(frozen=True)
class FittedTable:
    """A table as it fits. widths: characters of each column; None for one that takes the remaining width and wraps its words."""

    cells: Cells
    widths: tuple[int | None, ...]


def laid_out(cells: Cells, width: int) -> list[FittedTable]:
    """Return the table as one where all fits into `width` characters. Else names are shortened in the middle, words wrap, and columns for which
    there is no room even so follow in a further table behind the same names.
    """
    if AROUND + sum(_longest(cells, i) + BETWEEN for i in range(len(cells.heads))) <= width:
        return [FittedTable(cells, (None,) * len(cells.heads))]
    least = [_least(cells, i) for i in range(len(cells.heads))]
    named = 0 in cells.words and len(cells.heads) > 1
    return [_fit(cells, columns, least, width, named) for columns in _blocks(least, width, named)]


def _fit(cells: Cells, columns: Sequence[int], least: Sequence[int], width: int, named: bool) -> FittedTable:
    part = Cells(
        [cells.heads[i] for i in columns],
        [[row[i] for i in columns] for row in cells.rows],
        [place for place, i in enumerate(columns) if i in cells.words],
    )
    widths = [None if _wraps(cells, i) else least[i] for i in columns]
    if not named:
        return FittedTable(part, tuple(widths))
    room = max(width - AROUND - BETWEEN * len(columns) - sum(least[i] for i in columns[1:]), least[0])
    part = _shorten(part, room)
    return FittedTable(part, (min(room, _longest(part, 0)), *widths[1:]))


def _shorten(cells: Cells, most: int) -> Cells:
    """Return names of at most `most` characters; whole, to be wrapped, where two would look alike."""
    names = [str(row[0]) for row in cells.rows]
    short = [brief(name, most) for name in names]
    if len(set(short)) < len(set(names)):
        return cells
    return replace(cells, rows=[[name, *row[1:]] for name, row in zip(short, cells.rows)])


def _texts(cells: Cells, column: int) -> list[str]:
    return [str(row[column]) for row in cells.rows]


def _longest(cells: Cells, column: int) -> int:
    return max(map(len, [cells.heads[column], *_texts(cells, column)]))


def _wraps(cells: Cells, column: int) -> bool:
    return column in cells.words or max(map(len, _texts(cells, column)), default=0) > NUMBER


def _least(cells: Cells, column: int) -> int:
    """Return the fewest characters: the longest of the numbers, the first NAME of a name, the longest word of words; headings wrap."""
    texts, heading = _texts(cells, column), cells.heads[column]
    if not _wraps(cells, column):
        return max(map(len, texts), default=0) if not heading else _of_heading(heading, texts)
    if column == 0 and column in cells.words:
        return max(min(max(map(len, texts), default=0), NAME), *map(len, heading.split() or [""]))
    return min(max((len(word) for text in [heading, *texts] for word in text.split()), default=0), WORD)


def _of_heading(heading: str, texts: Sequence[str]) -> int:
    from textwrap import wrap

    shortest = max(map(len, [*texts, *heading.split()]))
    return next(w for w in count(shortest) if len(wrap(heading, w)) <= HEADING)


def _blocks(least: Sequence[int], width: int, named: bool) -> list[list[int]]:
    """Return the columns of each table, in their order; column 0 leads every one where it names the rows."""
    blocks: list[list[int]] = [[0]]
    for i in range(1, len(least)):
        taken = AROUND + sum(least[j] + BETWEEN for j in [*blocks[-1], i])
        if taken > width and len(blocks[-1]) > named:
            blocks.append([0, i] if named else [i])
        else:
            blocks[-1].append(i)
    return blocks
