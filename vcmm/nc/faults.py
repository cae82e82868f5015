"""BlockFault: what is wrong in one block. The interpreter adds file and line; whoever finds the fault knows the column."""

from __future__ import annotations

from vcmm.core.errors import DataError


class BlockFault(DataError):
    """A block cannot be understood: column from 1, and one sentence that ends with what to do."""

    column: int

    def __init__(self, column: int, text: str) -> None:
        super().__init__(text)
        self.column, self.text = column, text


class ProgramFault(DataError):
    """The same with its place: 'part.nc:12:7: ...'."""

    line: int
    column: int

    def __init__(self, name: str, line: int, column: int, text: str) -> None:
        super().__init__(f"{name}:{line}:{column}: {text}")
        self.line, self.column, self.reason = line, column, text
