"""Edits of TOML texts that people wrote: values change, their comments and their layout stay (tomlkit)."""

from __future__ import annotations

import os
from collections.abc import Iterator, Sequence
from pathlib import Path
from typing import Any

from vcmm.core.text import read_text
from vcmm.files.toml import find_file, read_toml
from vcmm.files.toml_lines import Location, key_lines


def editable(path: Path) -> Any:
    """Return the document of a file, as tomlkit has it: `document["pose"]["turn"] = ...`. DataError: no valid TOML."""
    import tomlkit

    read_toml(path)  # says what is wrong, with its line
    return tomlkit.parse(read_text(path).rstrip() + "\n")


def move_names(document: Any, old: Path, new: Path) -> None:
    """Rewrite names of files that lie beside a file in `old` as they are seen from `new`."""
    if old.resolve() == new.resolve():
        return
    for holder, key, text in _texts(document):
        there = find_file(text, old)
        if there is not None:
            holder[key] = os.path.relpath(there, new)


def _texts(holder: Any) -> Iterator[tuple[Any, Any, str]]:
    """Yield every text of a document: what holds it, under which key or index, and the text."""
    pairs = list(holder.items()) if isinstance(holder, dict) else list(enumerate(holder))
    for key, value in pairs:
        if isinstance(value, str):
            yield holder, key, str(value)
        elif isinstance(value, dict | list):
            yield from _texts(value)


def with_value_for_table(document: Any, key: str, value: str) -> None:
    """Write `key = "value"` at the head of the document in place of the value or of all tables [key...].

    A table goes with the comments inside it; the comments and blank lines over the table that follows stay.
    """
    left = _taken_out(document, key) if isinstance(document.get(key), dict) else []
    document[key] = value
    _put_back(document, left)


def without_table(document: Any, key: str) -> None:
    """Take out all tables [key...]; the comments and blank lines over the table that follows stay."""
    if key in document:
        _put_back(document, _taken_out(document, key))


def _taken_out(document: Any, key: str) -> list[tuple[Any, str]]:
    """Remove all tables [key...]: what tomlkit leaves in the place of each, and the comments at its end."""
    places = [i for i, (name, _) in enumerate(document.body) if name is not None and name.key == key]
    headings = [_last_comments(document.body[i][1].as_string()) for i in places]
    document.remove(key)
    return [(document.body[i][1], heading) for i, heading in zip(places, headings)]


def _put_back(document: Any, left: Sequence[tuple[Any, str]]) -> None:
    """Put the comments back to the place of the tables."""
    import tomlkit

    for i, (_, item) in enumerate(list(document.body)):
        for empty, heading in left:
            if item is empty:
                document.body[i] = (None, tomlkit.ws(heading))


def _last_comments(text: str) -> str:
    """Return the blank lines and comments at the end of a text."""
    lines = text.splitlines(keepends=True)
    first = len(lines)
    while first and (not lines[first - 1].strip() or lines[first - 1].lstrip().startswith("#")):
        first -= 1
    return "".join(lines[first:])


def with_comment_under(text: str, location: Location, comment: str) -> str:
    """Return the text with a comment in the line after a key or the heading of a table."""
    lines = text.splitlines()
    lines.insert(key_lines(text)[location], f"# {comment}")
    return "\n".join(lines) + "\n"
