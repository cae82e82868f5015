"""What a person sees: tables on stdout, remarks and progress on stderr."""

from __future__ import annotations

import sys
from collections.abc import Iterator
from contextlib import contextmanager
from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from vcmm.tables.table import ResultTable


@contextmanager
def progress(show: bool = True) -> Iterator[Any]:
    """A callback (text, share 0..1) that draws a bar on stderr; silent when stderr is no terminal."""
    if not show or not sys.stderr.isatty():
        yield lambda text, share: None
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


def say(text: str) -> None:
    """A remark for the person, on stderr."""
    print(text, file=sys.stderr)


def show_table(table: ResultTable[Any]) -> None:
    """A table on stdout; wide enough for a file when stdout is no terminal."""
    from rich import box
    from rich.console import Console
    from rich.table import Table

    from vcmm.tables.table import in_terminal

    width = None if sys.stdout.isatty() else 160
    shown = Table(
        title=_plain(table.title),
        caption=_plain(table.caption) or None,
        box=box.SIMPLE_HEAD,
        title_justify="left",
        caption_justify="left",
        title_style="bold",
        caption_style="",
    )
    cells = in_terminal(table)
    for i, name in enumerate(cells.heads):
        words = i in cells.words
        shown.add_column(_plain(name), justify="left" if words else "right", no_wrap=words and i == 0)
    for row in cells.rows:
        shown.add_row(*[_plain(cell) for cell in row])

    class Told(Console):
        def on_broken_pipe(self) -> None:
            """The reader has gone (| head): that is for the command to say, not for rich to end the process with 1."""
            raise BrokenPipeError

    Told(width=width, highlight=False).print(shown)


def _plain(text: str) -> str:
    """Square brackets are text, not the markup of rich."""
    return text.replace("[", "\\[")
