"""Questions about a tracked machine: the next check with which a task keeps its limits, and the parts that an alarm makes doubtful."""

from __future__ import annotations

from collections.abc import Sequence
from pathlib import Path
from typing import NamedTuple

from vcmm.files.own.check_list import load_checks
from vcmm.files.own.dated_parts import read_parts
from vcmm.files.own.scenario import load_scenario
from vcmm.learn.tracking.doubtful import DoubtfulParts, doubtful_parts
from vcmm.learn.tracking.follow import FollowedMachine
from vcmm.learn.tracking.machine_at import DatedMachine
from vcmm.learn.tracking.next_check import CheckPlan, NextCheck, plan_checks
from vcmm.learn.tracking.task_limits import TaskLimit, gains_of, limits_of


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
