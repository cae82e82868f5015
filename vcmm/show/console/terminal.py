"""Write to the terminal: tables on stdout, remarks and progress on stderr.

A table that is wider than the terminal is fitted: no column of numbers is cut or lost; names and words are shortened.
"""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass, replace
from itertools import count
from typing import TYPE_CHECKING, Any, Literal

from vcmm.core.text import brief
from vcmm.show.tables.table import Cells

if TYPE_CHECKING:
    from rich.table import Table

    from vcmm.show.report.answers import AnswerLine
    from vcmm.show.tables.table import ResultTable

EVERY = 60.0  # s between lines of a long job whose stderr is no terminal


@contextmanager
def progress(show: bool = True) -> Iterator[Any]:
    """Return a callback (text, share 0..1) that draws a bar on stderr; where that is no terminal a long job writes a line every minute."""
    if not show:
        yield lambda text, share: None
        return
    if not sys.stderr.isatty():
        yield SeldomSaid()
        return
    from rich.console import Console
    from rich.progress import BarColumn, Progress, TextColumn, TimeElapsedColumn

    columns = (
        TextColumn("{task.description:28}"),
        BarColumn(),
        TextColumn("{task.percentage:3.0f} %"),
        TimeElapsedColumn(),
    )
    with Progress(*columns, console=Console(stderr=True), transient=True) as bar:
        task = bar.add_task("starting", total=1.0)
        yield lambda text, share: bar.update(task, description=text, completed=share)


class SeldomSaid:
    """Writes a line on stderr every EVERY seconds from the reports of a job; nothing for a shorter job."""

    def __init__(self, clock: Callable[[], float] = time.monotonic) -> None:
        self.clock, self.begun = clock, clock()
        self.due = self.begun + EVERY

    def __call__(self, text: str, share: float) -> None:
        now = self.clock()
        if now >= self.due:
            self.due = now + EVERY
            say(f"{now - self.begun:.0f} s: {text}, {share:.0%} of this step")


def say(text: str) -> None:
    """Write a remark for the user on stderr."""
    from vcmm.show.report.text import micro

    print(micro(text), file=sys.stderr)


def say_warnings(texts: Iterable[str]) -> None:
    """Write the warnings beside a result, each with its severity: note, warning or error."""
    from vcmm.show.report.notices import in_terminal

    for text in texts:
        say(in_terminal(text))


def show_answers(lines: Iterable[AnswerLine]) -> None:
    """Write the answer first: value ± U, limits, decision, largest contributor, what to change; then an empty line."""
    from vcmm.show.report.answers import answer_text

    print(answer_text(lines) + "\n")


def show_table(table: ResultTable[Any]) -> None:
    """Write a table on stdout; wide enough for a file when stdout is no terminal. Where it is wider than the terminal see `laid_out`."""
    from rich.console import Console

    from vcmm.show.tables.table import in_terminal

    class WarningConsole(Console):
        def on_broken_pipe(self) -> None:
            """Leave a closed reader (| head) to the command, instead of letting rich end the process with 1."""
            raise BrokenPipeError

    console = WarningConsole(width=None if sys.stdout.isatty() else 160, highlight=False)
    parts = laid_out(in_terminal(table), console.width)
    for i, part in enumerate(parts):
        title = table.title if i == 0 else "(continued)"
        console.print(_rich_table(part, title, table.caption if part is parts[-1] else ""))


def _rich_table(part: FittedTable, title: str, caption: str) -> Table:
    from rich import box
    from rich.table import Table

    shown = Table(
        title=_plain(title),
        caption=_plain(caption) or None,
        box=box.SIMPLE_HEAD,
        title_justify="left",
        caption_justify="left",
        title_style="bold",
        caption_style="",
    )
    for i, (name, width) in enumerate(zip(part.cells.heads, part.widths)):
        side: Literal["left", "right"] = "left" if i in part.cells.words else "right"
        shown.add_column(_plain(name), justify=side, width=width, overflow="fold")
    for row in part.cells.rows:
        shown.add_row(*[_plain(cell) for cell in row])
    return shown


def _plain(text: str) -> str:
    """Return text in which square brackets are text, not the markup of rich."""
    return text.replace("[", "\\[")


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
