"""Collect the problems of a file, so that all of them are reported at once, each with file and line."""

from __future__ import annotations

import difflib
import re
from collections.abc import Callable, Iterable
from typing import TypeVar

from vcmm.core.errors import DataError, ModelLimit, UsageError
from vcmm.files.toml import Document, Location

T = TypeVar("T")
_LOCATION = re.compile(r".+?:\d+: ")  # 'machine.toml:12: ...' says where already


Key = str | tuple[str, ...]  # a key of a table, or the way to one inside it; "" is the table itself


def misspelt(word: str, present: Iterable[str]) -> str:
    """Return ' "efect" is there; rename it to "effect".' where a missing word is present in another spelling, else ''."""
    words = [str(p) for p in present if p]
    match = difflib.get_close_matches(word, words, n=1, cutoff=0.6) or [
        w for w in words if word.startswith(w)
    ]
    return f' "{match[0]}" is there; rename it to "{word}".' if match else ""


LONGEST_NAME = 200  # characters


def bad_name(name: str) -> str:
    """Return what is wrong with a name for tables and pages, '' where nothing is."""
    if not name.strip():
        return "is empty; write a name"
    if len(name) > LONGEST_NAME:
        return f"has {len(name)} characters; {LONGEST_NAME} are the most"
    return "" if name.isprintable() else "holds a control character; a name is one line of plain text"


class TableProblems(UsageError):
    """Several things wrong in one table: (key, sentence) each."""

    def __init__(self, key_problems: Iterable[tuple[Key, str]]) -> None:
        self.found = tuple(key_problems)
        super().__init__("\n".join(text for _, text in self.found))


class Problems:
    """Problems of a document."""

    def __init__(self, document: Document) -> None:
        self.document = document
        self.found: list[str] = []

    def add(self, location: Location, text: str, table: Location | None = None) -> None:
        """Note one problem with file, line and table; a text that names file and line already is left as it is."""
        here = f"{self.document.where(location)}: {self.document.table(location if table is None else table)}"
        self.found.append(text if _LOCATION.match(text) else here + text)

    def attempt(self, location: Location, make: Callable[[], T]) -> T | None:
        """Call `make`; complaints are noted with file and line, and None is returned."""
        try:
            return make()
        except TableProblems as error:
            for key, text in error.found:
                inside = (key,) if isinstance(key, str) else key
                self.add((*location, *inside) if key else location, text)
        except DataError as error:
            for text in error.problems:
                self.add(location, text)
        except (UsageError, ModelLimit) as error:
            self.add(location, str(error))
        return None

    def raise_if_any(self) -> None:
        """Raises DataError with everything that was noted."""
        if self.found:
            raise DataError(list(dict.fromkeys(self.found)))
