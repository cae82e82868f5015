"""Write complaints with the file and line of the numbers, and short enough to be read."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from vcmm.core.errors import DataError, ModelLimit, OptionError, UsageError
from vcmm.core.text import brief

MOST_PROBLEMS = 20  # problems that are shown
LONGEST = 800  # characters of one problem
MOST_BYTES = 3800  # bytes of all of them, so that a message with its count stays under 4 kB


@contextmanager
def about(file: Path, table: str = "") -> Iterator[None]:
    """Give complaints about the numbers of a scenario its file and line: those of `table` where the file has it.

    Else the pose where a point is out of reach, else the plan. A complaint with its own file and line (a refusal of the NC program)
    is not changed, and so is a complaint about an option of the command line.
    """
    try:
        yield
    except (DataError, OptionError):
        raise
    except (ModelLimit, UsageError) as error:
        from vcmm.files.toml import read_toml
        from vcmm.program.faults import ProgramLimit

        if isinstance(error, ProgramLimit):
            raise
        read = read_toml(file)
        usual = "pose" if isinstance(error, ModelLimit) else "plan"
        where = read.where((table if table in read.data else usual,))
        raise type(error)(f"{where}: {error}") from None


def list_problems(problems: Sequence[str]) -> str:
    """Return the problems, one line each: at most 20 problems and 3.8 kB, then a count; control characters are spelled out."""
    lines: list[str] = []
    left = MOST_BYTES
    for problem in problems[:MOST_PROBLEMS]:
        line = "vcmm: " + visible_text(brief(problem, LONGEST))
        left -= len(line.encode("utf-8", "replace")) + 1
        if left < 0 and lines:
            break
        lines.append(line)
    rest = len(problems) - len(lines)
    return "\n".join([*lines, *([f"vcmm: and {rest} more problems of {len(problems)}"] if rest else [])])


def visible_text(text: str) -> str:
    """Return control characters and lone surrogates as \\x1b and the like: a file must not steer the terminal."""
    return "".join(c if c == "\n" or c.isprintable() else ascii(c)[1:-1] for c in text)
