"""checks/1: the checks that a shop has, with what each costs.

vcmm = "checks/1"
[[checks]]
name = "ball bar, three planes"
like = "2026-03-15_bar.toml"      # a recording that was followed: the same places and instrument again
cost = 40                         # in any unit, the same for all
minutes = 30
"""

from __future__ import annotations

from pathlib import Path

from pydantic import Field

from vcmm.core.errors import DataError
from vcmm.files.problems import Problems
from vcmm.files.schema import Table, checked_model
from vcmm.files.toml import check_version, read_toml
from vcmm.learn.tracking.next_check import ShopCheck


class CheckTable(Table):
    name: str = Field(examples=['"ball bar"'])
    like: str = Field(examples=['"2026-03-15_bar.toml"'])
    cost: float = Field(gt=0, allow_inf_nan=False, examples=["40"])
    minutes: float = Field(default=0.0, ge=0, allow_inf_nan=False, examples=["30"])


class CheckListFile(Table):
    """checks/1"""

    vcmm: str
    checks: list[CheckTable] = Field(min_length=1)


def load_checks(path: str | Path) -> tuple[ShopCheck, ...]:
    """Read a list of checks. Raises DataError with every problem and its line."""
    document = read_toml(path)
    check_version(document, "checks")
    problems = Problems(document)
    model = checked_model(CheckListFile, document.data, problems)
    problems.raise_if_any()
    assert model is not None
    names = [c.name for c in model.checks]
    twice = sorted({n for n in names if names.count(n) > 1})
    if twice:
        raise DataError(f"{path}: two checks have the name {twice[0]}; name each once")
    return tuple(ShopCheck(c.name, c.like, c.cost, c.minutes) for c in model.checks)
