"""Which measurement to take next: the add-on that separates the tied answers best per minute."""

from __future__ import annotations

from collections.abc import Sequence
from typing import Any

from vcmm.diagnosis.confusion import Standing
from vcmm.diagnosis.problem import Problem
from vcmm.diagnosis.result import NextStep
from vcmm.diagnosis.select import Selection


def next_steps(
    problem: Problem, stage: Any, selection: Selection, places: Sequence[Standing]
) -> tuple[NextStep, ...]:
    return ()
