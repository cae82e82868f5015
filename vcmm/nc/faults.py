"""What is wrong with a program, and where: line and column are data, so that nobody has to read them out of a message."""

from __future__ import annotations

from typing import NoReturn

from vcmm.core.errors import DataError, ModelLimit, VcmmError
from vcmm.nc.moves import Source


class BlockFault(DataError):
    """A block cannot be understood: column from 1 (0: whoever reads the block knows it), and one sentence that ends with what
    to do. The reader of the program adds file and line."""

    def __init__(self, column: int, text: str) -> None:
        super().__init__(text)
        self.column, self.text = column, text


class _Placed(VcmmError):
    """A sentence and its place in a program: 'part.nc:12:7: ...', 'part.nc:12: ...' without a column, 'line 12: ...' without
    a file."""

    def __init__(self, file: str, line: int, column: int | None, reason: str) -> None:
        where = f"{file}:{line}" + ("" if column is None else f":{column}") if file else f"line {line}"
        super().__init__(f"{where}: {reason}")
        self.file, self.line, self.column, self.reason = file, line, column, reason


class ProgramFault(_Placed, DataError):
    """A program cannot be understood, or what it says cannot be done."""


class ProgramLimit(_Placed, ModelLimit):
    """Tool or machine cannot follow a program, or the model does not hold there."""


def moved(error: ProgramFault | ProgramLimit, line: int) -> ProgramFault | ProgramLimit:
    """The same at another line."""
    return type(error)(error.file, line, error.column, error.reason)


def refuse(file: str, source: Source, what: str, fix: str) -> NoReturn:
    """Raises ProgramLimit where the tool cannot follow: what it is, and what to do."""
    raise ProgramLimit(file, source.line, source.first, f"{what}; {fix}.")
