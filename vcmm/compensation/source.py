"""The text of a program, byte for byte: lines with their own ends, words changed in place, everything else untouched."""

from __future__ import annotations

import re
from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple, TypeVar

from vcmm.core.errors import DataError, Environment, ModelLimit, VcmmError
from vcmm.core.own_files import check_replacing
from vcmm.program.reading import read_bytes

_LINE = re.compile(r"([^\r\n]*)(\r\n|\n|\r|\Z)")
_COMMENT = re.compile(r"\([^()]*\)|;.*")
_SPACED_WORDS, _JOINED_WORDS = re.compile(r"[\d.]\s+[A-Za-z]"), re.compile(r"[\d.][A-Za-z]")
_BOM = "\ufeff"
E = TypeVar("E", bound=VcmmError)


@dataclass(frozen=True)
class SourceText:
    """lines: text and end of each line ("" after the last one where the file has none). encoding: to write it back."""

    name: str
    lines: tuple[tuple[str, str], ...]
    encoding: str = "utf-8"
    bom: bool = False

    @property
    def text(self) -> str:
        return "".join(body + end for body, end in self.lines)

    @property
    def end(self) -> str:
        """The line end that the file uses."""
        return next((end for _, end in self.lines if end), "\n")

    def encode(self, text: str) -> bytes:
        """Return the bytes of a text in the encoding of the source."""
        return ((_BOM if self.bom else "") + text).encode(self.encoding)


def source_text(text: str, name: str, encoding: str = "utf-8", bom: bool = False) -> SourceText:
    """Split a text into lines. CR LF, LF and CR end a line."""
    lines = [(m[1], m[2]) for m in _LINE.finditer(text)]
    if lines and lines[-1] == ("", ""):
        lines.pop()
    return SourceText(name, tuple(lines), encoding, bom)


def read_source(path: Path) -> SourceText:
    """Read a program file; Latin-1 where it is no UTF-8, as old posts write comments. Raises DataError."""
    text = read_bytes(path)
    raw = path.read_bytes()
    try:
        raw.decode("utf-8")
        encoding = "utf-8"
    except UnicodeDecodeError:
        encoding = "latin-1"
    return source_text(text, str(path), encoding, raw.startswith(b"\xef\xbb\xbf"))


def write_source(path: Path, content: bytes) -> None:
    """Write a whole program or nothing. Raises Environment."""
    draft = path.with_name(f".{path.name}.part")
    check_replacing([path])
    try:
        draft.write_bytes(content)
        draft.replace(path)
    except OSError as error:
        raise Environment(
            f"{path} cannot be written ({error.strerror}); choose another file with --out"
        ) from None


def at_line(kind: type[E], name: str, line: int, message: str, column: int | None = None) -> E:
    """Return the error of a place in a program, which it names in its text and carries as data."""
    place = f"{name}:{line}" if column is None else f"{name}:{line}:{column}"
    return kind(f"{place}: {message}", line=line, column=column)


def at_origin(error: VcmmError, name: str, origin: Sequence[int]) -> VcmmError:
    """Return the same error at the line of the file from which its line (from 1) of a written-out program comes."""
    head, line = f"{name}:{error.line}:", error.line
    if line is None or not 0 < line <= len(origin) or not str(error).startswith(head):
        return error
    message = f"{name}:{origin[line - 1]}:{str(error).removeprefix(head)}"
    kind = DataError if isinstance(error, DataError) else ModelLimit
    return kind(message, line=origin[line - 1], column=error.column)


class Edit(NamedTuple):
    """Columns from 1: line[first - 1 : last - 1] becomes `text`; first == last inserts."""

    first: int
    last: int
    text: str


def apply_edits(line: str, edits: Sequence[Edit]) -> str:
    """Return a line with its edits made; those at one place stay in their order, insertions before what goes."""
    for edit in sorted(edits, key=lambda e: (e.first, e.last))[::-1]:
        line = line[: edit.first - 1] + edit.text + line[edit.last - 1 :]
    return line


def code_of(line: str) -> str:
    """Return the line with comments blanked, so that columns stay."""
    return _COMMENT.sub(lambda m: " " * len(m[0]), line)


def semicolon_code(line: str) -> str:
    """Return the same where only `;` begins a comment, and brackets belong to the words."""
    at = re.match(r'(?:[^;"]|"[^"]*"?)*', line)
    code = at[0] if at else line
    return code + " " * (len(line) - len(code))


def separator(source: SourceText) -> str:
    """Return the separator between two words of the program: a blank, or nothing where words are written without."""
    code = [code_of(line) for line, _ in source.lines]
    apart = sum(len(_SPACED_WORDS.findall(line)) for line in code)
    close = sum(len(_JOINED_WORDS.findall(line)) for line in code)
    return " " if apart >= close else ""
