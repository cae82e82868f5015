"""Exceptions of vcmm, and which of them to raise:

    UsageError    your call or your command line is wrong (a mistyped word, a wrong type)
    DataError     your file is wrong (what, file, line, what is allowed, what to do next)
    ModelLimit    the numbers leave the range in which the model is valid (travel, 1 mrad, a missing column)
    Environment   the computer cannot do it (a folder that cannot be written, a missing library)

Every message is one plain sentence that ends with the fix. Nothing is clipped, nothing becomes NaN in silence.
"""

from __future__ import annotations

import difflib
from collections.abc import Iterable


class VcmmError(Exception):
    """Base of all errors that vcmm raises on purpose. `exit_code` is what the command line returns.

    row: of a run, from 0; line, column: of a file, from 1; each where it is known.
    """

    exit_code = 2

    def __init__(
        self, *args: object, row: int | None = None, line: int | None = None, column: int | None = None
    ) -> None:
        super().__init__(*args)
        self.row, self.line, self.column = row, line, column


class UsageError(VcmmError):
    """The call is wrong."""


class OptionError(UsageError):
    """An option of a call or of a command line is wrong, whatever its file says: no line of the file is to blame."""


class DataError(VcmmError):
    """A file is wrong. `problems` holds every problem found in it, one sentence each."""

    def __init__(
        self,
        problems: str | Iterable[str],
        *,
        row: int | None = None,
        line: int | None = None,
        column: int | None = None,
    ) -> None:
        self.problems = (problems,) if isinstance(problems, str) else tuple(problems)
        super().__init__("\n".join(self.problems), row=row, line=line, column=column)


class ModelLimit(VcmmError):
    """The numbers leave the range in which the model is valid."""


class BeyondFirstOrder(ModelLimit):
    """Errors are so large that the transforms have to be multiplied."""


class Environment(VcmmError):
    """The computer lacks something: a writable folder, a library, a display."""

    exit_code = 3


def first_of(error: VcmmError) -> str:
    """Return the first problem and the number of further ones, for files that are rows of a table."""
    problems = error.problems if isinstance(error, DataError) else [str(error)]
    more = f" (and {len(problems) - 1} more problems)" if len(problems) > 1 else ""
    return problems[0] + more


def did_you_mean(word: str, allowed: Iterable[str]) -> str:
    """Return ' Did you mean "travel"?' for the closest allowed word, else ''."""
    allowed = list(allowed)
    match = difflib.get_close_matches(word, allowed, n=1, cutoff=0.6)
    if not match:  # Exx for EXX: the case alone is wrong
        match = [a for a in allowed if a.lower() == word.lower()][:1]
    return f' Did you mean "{match[0]}"?' if match else ""


def choose_from(word: str, allowed: Iterable[str]) -> str:
    """Return the suggestion followed by the whole list of allowed words."""
    allowed = list(allowed)
    return f"{did_you_mean(word, allowed)} Allowed: {', '.join(allowed)}."
