"""Subprograms in files of their own: beside the program that calls them."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path


def file_beside(program: str, names: Sequence[str]) -> Path | None:
    """The first of the names that is a file in the folder of the program, large and small letters alike; None: none is.

    program: path of the calling program; a text that is no file has nothing beside it.
    """
    path = Path(program)
    if not path.is_file():
        return None
    there = {p.name.upper(): p for p in sorted(path.parent.iterdir()) if p.is_file()}
    return next((there[n.upper()] for n in names if n.upper() in there), None)
