"""Write to the terminal: tables on stdout, remarks and progress on stderr."""

from __future__ import annotations

import sys
import time
from collections.abc import Callable, Iterable, Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any, Literal

if TYPE_CHECKING:
    from rich.table import Table

    from vcmm.show.console.widths import FittedTable
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
    """Write a table on stdout; wide enough for a file when stdout is no terminal. Where it is wider than the terminal see `widths`."""
    from rich.console import Console

    from vcmm.show.console.widths import laid_out
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
