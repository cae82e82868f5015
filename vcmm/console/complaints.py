"""Complaints about numbers get the file and line where these stand."""

from __future__ import annotations

from collections.abc import Iterator
from contextlib import contextmanager
from pathlib import Path

from vcmm.core.errors import DataError, ModelLimit, UsageError


@contextmanager
def about(file: Path, table: str = "") -> Iterator[None]:
    """Complaints about the numbers of a scenario get its file and line: those of `table` where the file has it.

    Else the pose where a point is out of reach, else the plan.
    """
    try:
        yield
    except DataError:
        raise
    except (ModelLimit, UsageError) as error:
        from vcmm.files.toml import read_toml

        read = read_toml(file)
        usual = "pose" if isinstance(error, ModelLimit) else "plan"
        where = read.where((table if table in read.data else usual,))
        raise type(error)(f"{where}: {error}") from None
