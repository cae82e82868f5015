"""Read a TOML file and remember the line of every key, so that a message can name file and line."""

from __future__ import annotations

import re
import tomllib
from collections.abc import Iterator, Sequence
from dataclasses import dataclass
from functools import cached_property
from pathlib import Path
from typing import Any

from vcmm.core.confinement import check_inside
from vcmm.core.errors import DataError
from vcmm.core.text import brief, lines_of, read_text
from vcmm.files.toml_lines import Location, key_lines

__all__ = ["Document", "Location", "check_version", "key_lines", "read_toml"]


DEEPEST = 64  # brackets in brackets, parts of a key, digits of a number
_QUOTED_TEXT = re.compile(
    r'"""(?:\\.|[^\\])*?"{3,5}' r"|'''.*?'{3,5}" r'|"(?:\\.|[^"\\\n])*"' r"|'[^'\n]*'", re.DOTALL
)
_LONG_NUMBER = re.compile(rf"=\s*[-+]?[0-9_]{{{DEEPEST + 1}}}")
_LONG_KEY = re.compile(rf"(?<![A-Za-z0-9_-])(?:[A-Za-z0-9_-]+[ \t]*\.[ \t]*){{{DEEPEST}}}")


@dataclass(frozen=True)
class Document:
    """A parsed file and its text."""

    path: Path
    data: dict[str, Any]
    text: str

    @cached_property
    def lines(self) -> dict[Location, int]:
        """The path of every key and its line number (1 = first); worked out for the first message that asks."""
        return key_lines(self.text)

    def where(self, location: Location) -> str:
        """Return 'machine.toml:12', the line of the key or of the nearest table above it."""
        location = tuple(location)
        while location and location not in self.lines:
            location = location[:-1]
        return f"{self.path}:{self.lines.get(location, 1)}"

    def table(self, location: Location) -> str:
        """Return '[plan.steps 1] ', the table that holds the location; empty at the top of the file."""
        words: list[str] = []
        place: Any = self.data
        for part in location:
            inside = place[part] if _holds(place, part) else None
            if not isinstance(inside, dict | list):
                break
            if isinstance(part, int):
                words[-1] += f" {part + 1}"
            elif isinstance(inside, dict) or (inside and isinstance(inside[0], dict)):
                words.append(str(part))
            place = inside
        return f"[{'.'.join(words)}] " if words else ""


def _holds(place: Any, part: str | int) -> bool:
    if isinstance(place, dict):
        return part in place
    return isinstance(place, list) and isinstance(part, int) and part < len(place)


def read_toml(path: str | Path) -> Document:
    """Parse a file. Raises DataError: missing, a folder, not text, or a TOML syntax error with its line."""
    path = Path(path)
    text = read_text(path)
    _check_depth(path, text)
    try:
        data = tomllib.loads(text)
    except ValueError as error:  # also of a whole number with thousands of digits
        raise DataError(_syntax(path, text, str(error))) from None
    except RecursionError:  # brackets that a comment with three quotation marks hid from the count
        raise DataError(f"{path}:1: brackets are nested more than {DEEPEST} deep; correct them") from None
    document = Document(path, data, text)
    for location, value in whole_numbers(data, ()):
        if not -(2**63) <= value < 2**63:
            raise DataError(
                f"{document.where(location)}: {brief(str(value))} is beyond 64 bits; write a smaller number"
            )
    return document


def whole_numbers(value: Any, location: Location) -> Iterator[tuple[Location, int]]:
    """Yield every whole number of a document with its place."""
    if isinstance(value, int):
        yield location, value
    inside = value.items() if isinstance(value, dict) else enumerate(value) if isinstance(value, list) else ()
    for key, inner in inside:
        yield from whole_numbers(inner, (*location, key))


def _check_depth(path: Path, text: str) -> None:
    """Refuse what no file means and what would take the reader's stack: brackets in brackets, keys of many parts.

    Texts in quotes are left out first; one that is not closed is found by the reader.
    """
    open_brackets = 0
    for number, line in enumerate(lines_of(_QUOTED_TEXT.sub(_blank_text, text)), 1):
        if _LONG_KEY.search(line):
            raise DataError(f"{path}:{number}: a key of more than {DEEPEST} parts; correct the line")
        if _LONG_NUMBER.search(line):
            raise DataError(f"{path}:{number}: a number of more than {DEEPEST} digits; correct the line")
        for character in line.partition("#")[0]:
            open_brackets += (character in "[{") - (character in "]}")
            if open_brackets > DEEPEST:
                raise DataError(
                    f"{path}:{number}: brackets are nested more than {DEEPEST} deep; correct the line"
                )


def _blank_text(match: re.Match[str]) -> str:
    """Return a text in quotes as a word of its own, with its line ends."""
    return "t" + "\n" * match.group().count("\n")


def _syntax(path: Path, text: str, message: str) -> str:
    """Return the complaint of tomllib with the line it is about, and what is usually wrong."""
    match = re.search(r"line (\d+)", message)
    lines = lines_of(text)
    number = int(match[1]) if match else len(lines)
    fix = "texts need quotes, keys need ="
    blank = lines_of(_QUOTED_TEXT.sub(_blank_text, text))
    if opened := _unclosed_bracket(blank, number, message):
        noticed, (number, bracket) = number, opened
        until = f" before line {noticed}" if noticed > number else ""
        message, fix = f'the "{bracket}" is not closed{until}', f'close it with "{CLOSES[bracket]}"'
        fix += "; text in braces stays on one line" if bracket == "{" else ""
    line = lines[number - 1].strip() if 0 < number <= len(lines) else ""
    if "verwrite" in message or "twice" in message or "more than once" in message:
        fix = "each key and each table is written once"
    return f"{path}:{number}: not valid TOML: {brief(message, 120)}: {brief(line)}\n    {fix}"


CLOSES = {"[": "]", "{": "}"}


_BEGINS_ANEW = re.compile(
    r"""\s*(?:[\w.-]+\s*=|\[\[?\s*[\w."'-]+\s*\]\]?\s*(?:#.*)?$)"""
)  # key = ..., [table]


def _unclosed_bracket(lines: Sequence[str], number: int, message: str) -> tuple[int, str] | None:
    """Return line and kind of the bracket whose missing end stopped the reader on line `number`; None where it is something else.

    A list may go on over lines, so one that is open there is only the cause where the line begins a new key or table, or the file ends.
    """
    before = _open_brackets(lines[: number - 1])
    line = lines[number - 1] if number <= len(lines) else ""
    is_end = "at end of document" in message
    if before and (is_end or message.startswith("Unclosed") or _BEGINS_ANEW.match(line)):
        return before[-1]
    here = _open_brackets([line])
    if here and (is_end or message.startswith("Unclosed") or here[-1][1] == "{"):
        return number, here[-1][1]
    return None


def _open_brackets(lines: Sequence[str]) -> list[tuple[int, str]]:
    """Return the line and kind of the brackets that are opened in these lines and not closed by one of their own kind."""
    waiting: list[tuple[int, str]] = []
    for number, line in enumerate(lines, 1):
        for character in line.partition("#")[0]:
            if character in CLOSES:
                waiting.append((number, character))
            elif waiting and character == CLOSES[waiting[-1][1]]:
                waiting.pop()
    return waiting


def find_file(text: str, folder: Path) -> Path | None:
    """Return the file in `folder` that a text of a TOML file names ("errors.csv"); None where there is none."""
    if len(text) > 200 or "\n" in text or "\0" in text:
        return None
    there = folder / text
    check_inside(there)
    return there if there.suffix and there.is_file() else None


def check_version(document: Document, kind: str, version: int = 1) -> None:
    """Accept `kind/1 .. kind/version`; refuse others by name."""
    word = document.data.get("vcmm")
    at = document.where(("vcmm",))
    if word is None:
        raise DataError(f'{at}: the first line must be vcmm = "{kind}/{version}"')
    match = re.fullmatch(r"([a-z]+)/(\d+)", str(word))
    if not match or match[1] != kind:
        raise DataError(f'{at}: vcmm = "{word}", but expected a {kind} file: vcmm = "{kind}/{version}"')
    if int(match[2]) > version:
        raise DataError(
            f'{at}: "{word}" was written by a newer vcmm; this one reads {kind}/1 to {kind}/{version}: update vcmm'
        )
