"""Confine readers of files from others to one folder: a path outside it is not opened, and no message says whether it exists.

Every reader asks `check_inside` before it touches a path. The folder is that of the thread which reads.
"""

from __future__ import annotations

import os
from collections.abc import Iterator
from contextlib import contextmanager
from contextvars import ContextVar
from pathlib import Path

from vcmm.core.errors import DataError

_ROOT: ContextVar[str | None] = ContextVar("the folder that readers are confined to", default=None)


@contextmanager
def confine(root: Path) -> Iterator[None]:
    """Make readers raise DataError for a path outside `root` while the context is open."""
    token = _ROOT.set(os.path.realpath(root))
    try:
        yield
    finally:
        _ROOT.reset(token)


def is_outside(path: str | Path) -> bool:
    """Return whether readers are confined and the path leaves their folder, with links followed. A name that no path can have is outside."""
    root = _ROOT.get()
    if root is None:
        return False
    try:
        real = os.path.realpath(path)
    except (OSError, ValueError):
        return True
    return real != root and not real.startswith(root.rstrip(os.sep) + os.sep)


def check_inside(path: str | Path) -> None:
    """Raises DataError where `is_outside`; the message is the same whether the file exists or not."""
    if is_outside(path):
        raise DataError(
            "a file outside the given files is named, and none of those is read; give all files together "
            "and name them by relative paths"
        )
