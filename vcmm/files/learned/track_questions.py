"""Questions about a tracked machine: the next check with which a task keeps its limits, and the parts that an alarm makes doubtful."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from vcmm.core.errors import DataError, UsageError
from vcmm.files.own.check_list import load_checks
from vcmm.files.own.scenario import load_scenario
from vcmm.files.sheets import SheetColumn, read_csv
from vcmm.learn.tracking.dates import moment
from vcmm.learn.tracking.doubtful import DatedPart, DoubtfulParts, doubtful_parts
from vcmm.learn.tracking.follow import FollowedMachine
from vcmm.learn.tracking.machine_at import DatedMachine
from vcmm.learn.tracking.next_check import CheckPlan, NextCheck, plan_checks
from vcmm.learn.tracking.task_limits import TaskLimit, gains_of, limits_of

ADVICE = "; expected the columns part,date, such as part,date and below it 17,2026-08-19"
COLUMNS = (SheetColumn("part", advice=ADVICE), SheetColumn("date", advice=ADVICE))


def read_parts(path: Path) -> tuple[DatedPart, ...]:
    """Read parts and the days on which they were made or measured (columns part,date), one row per part. Raises DataError naming file and line: no name, no date."""
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


class CheckAdvice(NamedTuple):
    """limits: of the task; each: every check by itself, the longest for its cost first; plan: of them all."""

    limits: tuple[TaskLimit, ...]
    each: tuple[NextCheck, ...]
    plan: CheckPlan


def advise_checks(
    followed: FollowedMachine, dated: DatedMachine, task: Path, limits: Sequence[str], checks: Path, days: int
) -> CheckAdvice:
    """Advise checks from the day of `dated` on. Raises UsageError and DataError for files and limits that do not fit."""
    stated = limits_of(limits, load_scenario(task), dated)
    return CheckAdvice(stated, *plan_checks(followed, dated.when, load_checks(checks), stated, days))


def parts_in_doubt(
    followed: FollowedMachine, dated: DatedMachine, task: Path, parts: Path
) -> tuple[DoubtfulParts, ...]:
    """Return the doubtful parts of every alarm. Raises UsageError and DataError for files that do not fit."""
    gains = gains_of(load_scenario(task), dated)
    return doubtful_parts(followed, read_parts(parts), gains)
