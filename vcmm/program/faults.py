"""Faults of a program with their place: line and column are data."""

from __future__ import annotations

from typing import NoReturn

from vcmm.core.errors import DataError, ModelLimit
from vcmm.program.moves import Source


class BlockFault(DataError):
    """A block cannot be understood: column from 1 (0: the reader of the block knows it), and one sentence that ends with
    the remedy. The reader of the program adds file and line."""

    column: int

    def __init__(self, column: int, text: str) -> None:
        super().__init__(text)
        self.column, self.text = column, text


class ProgramFault(DataError):
    """The same with its place: 'part.nc:12:7: ...'."""

    line: int
    column: int

    def __init__(self, file: str, line: int, column: int, reason: str) -> None:
        super().__init__(f"{file}:{line}:{column}: {reason}")
        self.file, self.line, self.column, self.reason = file, line, column, reason


class ProgramLimit(ModelLimit):
    """Tool or machine cannot follow a program there: 'part.nc:12:7: ...', 'line 12: ...' where the file is not known."""

    line: int
    column: int

    def __init__(self, file: str, line: int, column: int, reason: str) -> None:
        super().__init__(f"{file}:{line}:{column}: {reason}" if file else f"line {line}: {reason}")
        self.file, self.line, self.column, self.reason = file, line, column, reason


def refuse(file: str, source: Source, what: str, fix: str) -> NoReturn:
    """Raise ProgramLimit where the tool cannot follow: what it is, and what to do."""
    raise ProgramLimit(file, source.line, source.first, f"{what}; {fix}.")
