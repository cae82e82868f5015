"""Lines of all keys and list elements of a TOML text. tomllib gives the values, this module their lines.

The text has been read by tomllib before, so it is valid TOML and the scanner only follows it: headers, keys, inline
tables and lists over any number of lines, strings of all four kinds, comments.
"""

from __future__ import annotations

import bisect
import re

Location = tuple[str | int, ...]

_BLANK = re.compile(r"(?:[ \t\r\n]|#[^\n]*)*")
_BARE_KEY = re.compile(r"[A-Za-z0-9_-]+")
_TEXT = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}' r"|'''.*?'{3,5}" r'|"(?:\\.|[^"\\\n])*"' r"|'[^'\n]*'", re.DOTALL
)
_SCALAR = re.compile(r"[^,\]}\n#]+")  # numbers, dates, true and false


def key_lines(text: str) -> dict[Location, int]:
    """Return the location of every table, key and list element -> line number (1 = first)."""
    return _Scanner(text).lines


class _Scanner:
    def __init__(self, text: str) -> None:
        self.text, self.at = text, 0
        self.starts = [m.end() for m in re.finditer(r"\n", text)]
        self.lines: dict[Location, int] = {}
        self.counts: dict[Location, int] = {}  # tables of an array of tables seen so far
        table: Location = ()
        while self.skip_blank() < len(text):
            before = self.at
            table = self.header() if text[self.at] == "[" else self.assignment(table)
            if self.at == before:  # cannot happen in valid TOML; never turn for ever
                break

    def skip_blank(self) -> int:
        match = _BLANK.match(self.text, self.at)
        self.at = match.end() if match else self.at
        return self.at

    def note(self, location: Location) -> None:
        """Remember the first line of a location and of the tables above it."""
        line = bisect.bisect_right(self.starts, self.at) + 1
        for depth in range(1, len(location) + 1):
            self.lines.setdefault(location[:depth], line)

    def header(self) -> Location:
        """Read [a.b] or [[a.b]]; the name of a list is its last table."""
        several = self.text.startswith("[[", self.at)
        begin = self.at
        self.at += 2 if several else 1
        name = self.key()
        end = self.at
        self.at = begin
        location: Location = ()
        for part in name[:-1]:
            location = self.last((*location, part))
        location = (*location, name[-1])
        self.note(location)
        if several:
            self.counts[location] = self.counts.get(location, -1) + 1
        location = self.last(location)
        self.note(location)
        self.at = end
        self.skip_blank()
        self.at += 2 if several else 1
        return location

    def last(self, location: Location) -> Location:
        return (*location, self.counts[location]) if location in self.counts else location

    def assignment(self, table: Location) -> Location:
        """Read key = value below `table`; return `table`."""
        begin = self.at
        name = self.key()
        end, self.at = self.at, begin
        self.note((*table, *name))
        self.at = end
        self.skip_blank()
        self.at += 1  # the equals sign
        self.value((*table, *name))
        return table

    def key(self) -> tuple[str, ...]:
        parts: list[str] = []
        while True:
            self.skip_blank()
            match = _TEXT.match(self.text, self.at) or _BARE_KEY.match(self.text, self.at)
            if not match:
                return (*parts, "")
            parts.append(match.group().strip("\"'"))
            self.at = match.end()
            self.skip_blank()
            if not self.text.startswith(".", self.at):
                return tuple(parts)
            self.at += 1

    def value(self, location: Location) -> None:
        self.skip_blank()
        opening = self.text[self.at : self.at + 1]
        if opening in ("[", "{"):
            self.at += 1
            self.items(location, "]" if opening == "[" else "}")
            return
        match = _TEXT.match(self.text, self.at) or _SCALAR.match(self.text, self.at)
        self.at = match.end() if match else len(self.text)

    def items(self, location: Location, closing: str) -> None:
        """Read the inside of a list or of an inline table, up to and with its closing bracket."""
        index = 0
        while self.skip_blank() < len(self.text) and self.text[self.at] != closing:
            if closing == "]":
                self.note((*location, index))
                self.value((*location, index))
                index += 1
            else:
                self.assignment(location)
            self.skip_blank()
            if self.text.startswith(",", self.at):
                self.at += 1
        self.at += 1
