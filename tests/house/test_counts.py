"""The figures of DESIGN.md are those of the tree."""

from __future__ import annotations

import re

import pytest

from tests.house.counts import JOURNEYS, journey, table
from tests.house.test_layers import PACKAGE

DESIGN = (PACKAGE.parent / "DESIGN.md").read_text(encoding="utf-8")


@pytest.mark.parametrize("row", table(), ids=lambda row: row.split("|")[1].strip()[:40])
def test_the_size_in_the_design_is_that_of_the_tree(row: str):
    assert row in DESIGN, (
        "write what `python -m tests.house.counts --table` prints into DESIGN.md, section Size"
    )


@pytest.mark.thorough
@pytest.mark.parametrize("command", [command for _, command in JOURNEYS])
def test_a_journey_in_the_design_is_that_of_the_tree(command: str):
    """Ten files more or less: which rare branches run depends on versions of libraries."""
    row = re.search(rf"\| `{re.escape(command)}` \| (\d+) \|", DESIGN)
    assert row, "write what `python -m tests.house.counts --journeys` prints into DESIGN.md, section Size"
    assert abs(sum(journey(command).values()) - int(row[1])) <= 10
