"""Record the files that the running command has read: what it writes must not replace them, or the data of its user are lost."""

from __future__ import annotations

import os
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from dataclasses import dataclass, field
from pathlib import Path

from vcmm.core.errors import UsageError


@dataclass(frozen=True)
class CommandFiles:
    """Real paths of a command. read: of others; outputs: written by the command itself, which may read and replace them."""

    read: set[str] = field(default_factory=set)
    outputs: set[str] = field(default_factory=set)


_UNDER_WAY: ContextVar[CommandFiles | None] = ContextVar("files of the command under way", default=None)


@contextmanager
def command_files() -> Iterator[None]:
    """Open the record of one command, from its first file to its last; programs that call vcmm from Python have none and may replace any file."""
    token = _UNDER_WAY.set(CommandFiles())
    try:
        yield
    finally:
        _UNDER_WAY.reset(token)


def note_read(path: Path) -> None:
    """Note that the command has read a file."""
    files = _UNDER_WAY.get()
    if files is not None and (real := os.path.realpath(path)) not in files.outputs:
        files.read.add(real)


def check_replacing(paths: Iterable[Path]) -> None:
    """Raises UsageError, before anything is written, where one of them is a file that the command has read; else they are its own."""
    files = _UNDER_WAY.get()
    if files is None:
        return
    real = {os.path.realpath(path): path for path in paths}
    lost = [path for name, path in real.items() if name in files.read]
    if lost:
        raise UsageError(
            f"{lost[0]} is one of the files that this command reads and would be lost; name another place for what it writes"
        )
    files.outputs.update(real)
