"""Cursor: reads the tokens of one block from left to right; what the readers of all dialects with words of their own share."""

from __future__ import annotations

from collections.abc import Sequence

from vcmm.nc.faults import BlockFault
from vcmm.nc.tokens import Token


class Cursor:
    """`at` is the index of the next token."""

    def __init__(self, tokens: Sequence[Token]) -> None:
        self.tokens, self.at = tokens, 0

    @property
    def done(self) -> bool:
        return self.at >= len(self.tokens)

    @property
    def column(self) -> int:
        if not self.done:
            return self.tokens[self.at].column
        last = self.tokens[-1]
        return last.column + len(last.text)

    def peek(self, ahead: int = 0) -> Token | None:
        return self.tokens[self.at + ahead] if self.at + ahead < len(self.tokens) else None

    def upper(self, ahead: int = 0) -> str:
        token = self.peek(ahead)
        return "" if token is None else token.text.upper()

    def accept(self, *texts: str) -> bool:
        """All the texts, one after another."""
        if all(self.upper(k) == text for k, text in enumerate(texts)):
            self.at += len(texts)
            return True
        return False

    def expect(self, text: str, why: str) -> None:
        if not self.accept(text):
            raise self.fault(
                f'"{text}" is missing {why}{f", {self.upper()} stands there" if not self.done else ""}'
            )

    def fault(self, text: str, column: int | None = None) -> BlockFault:
        return BlockFault(self.column if column is None else column, text)
