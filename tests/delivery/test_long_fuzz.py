"""Eight times as many mutations as the everyday suite gives to the readers, with seeds of their own."""

from __future__ import annotations

from pathlib import Path

import pytest

from tests.hostile.judge import trial
from tests.hostile.test_fuzz import TOGETHER

pytestmark = pytest.mark.thorough
FIRST, SLICES, EACH = 1_000_000, 8, TOGETHER


@pytest.mark.parametrize("part", range(SLICES))
def test_mutations(part: int, tmp_path: Path) -> None:
    first = FIRST + part * EACH
    found = [(seed, trial(tmp_path, seed)) for seed in range(first, first + EACH)]
    assert [f"{seed} {v.case}, {v.file}: {v.mutation.what}: {v.fault}" for seed, v in found if v.fault] == []
