"""The lossless layer: a program text cut into tokens whose texts, put together again, are the text, byte for byte.

    "".join(t.text for t in tokenize(text)) == text

Kinds: end (CR LF, LF or CR), space, comment, word (a letter with a plain number: X-12.5, g 1), name (two letters or more:
SIN, GOTO, sub), letter, number, symbol (any other single character, so that nothing is ever dropped).
A word may hold blanks, as controls allow: "X 1 0" is one word that means 10.
"""

from __future__ import annotations

import re
from collections.abc import Iterator
from typing import NamedTuple

__all__ = ["Token", "split_lines", "tokenize"]

_NUMBER = r"(?:\d[\d \t]*(?:\.[\d \t]*)?|\.[ \t]*\d[\d \t]*)(?<![ \t])"
_TOKEN = re.compile(
    rf"""(?P<end>\r\n|\n|\r)
    |(?P<space>[ \t]+)
    |(?P<comment>\([^()\r\n]*\)|;[^\r\n]*)
    |(?P<name>[A-Za-z]{{2,}})
    |(?P<word>[A-Za-z][ \t]*[-+]?[ \t]*{_NUMBER})
    |(?P<letter>[A-Za-z])
    |(?P<number>{_NUMBER})
    |(?P<symbol>.)""",
    re.VERBOSE | re.DOTALL,
)
_LINE_END = re.compile(r"\r\n|\n|\r")


class Token(NamedTuple):
    """A piece of the text; line and column from 1."""

    kind: str
    text: str
    line: int
    column: int


def tokenize(text: str) -> Iterator[Token]:
    """Yield all tokens of a text, in order; together they are the text."""
    return match_tokens(_TOKEN, text)


def match_tokens(pattern: re.Pattern[str], text: str) -> Iterator[Token]:
    """Yield the tokens of a pattern whose groups name their kinds ("end": the end of a line), with line and column.

    A stray CR within a token counts as a line, as it does in editors, but ends no comment.
    """
    line, begin = 1, 0
    for match in pattern.finditer(text):
        kind = str(match.lastgroup)
        yield Token(kind, match[0], line, match.start() - begin + 1)
        if kind == "end":
            line, begin = line + 1, match.end()
        elif "\r" in match[0]:
            line, begin = line + match[0].count("\r"), match.start() + match[0].rfind("\r") + 1


def split_lines(text: str) -> list[str]:
    """Return the lines without their ends. CR LF, LF and CR end a line, and nothing else does (str.splitlines knows ten ends)."""
    lines = _LINE_END.split(text) if "\r" in text else text.split("\n")
    if lines and not lines[-1]:
        lines.pop()
    return lines
