"""Parts and the days on which they were made or measured (part,date), to find those that an alarm of the machine makes doubtful."""

from __future__ import annotations

from pathlib import Path

from vcmm.core.errors import DataError, UsageError
from vcmm.files.sheets import SheetColumn, read_csv
from vcmm.learn.tracking.dates import moment
from vcmm.learn.tracking.doubtful import DatedPart

ADVICE = "; expected the columns part,date, such as part,date and below it 17,2026-08-19"
COLUMNS = (SheetColumn("part", advice=ADVICE), SheetColumn("date", advice=ADVICE))


def read_parts(path: Path) -> tuple[DatedPart, ...]:
    """Read one row per part. Raises DataError naming file and line: no name, no date."""
    sheet = read_csv(path)
    problems = sheet.missing(COLUMNS)
    if problems:
        raise DataError(problems)
    parts = tuple(map(DatedPart, sheet.words("part"), sheet.words("date")))
    for row, part in enumerate(parts):
        try:
            moment(part.date)
        except UsageError as error:
            problems.append(f"{sheet.at(row)}: {error}")
        if not part.name:
            problems.append(f"{sheet.at(row)}: the part has no name")
    if problems:
        raise DataError(problems)
    return parts
