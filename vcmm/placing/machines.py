"""Which of several machines suits the part: each is given the best pose that is found on it."""

from __future__ import annotations

from collections.abc import Callable, Mapping
from dataclasses import dataclass
from typing import Any

from vcmm.core.errors import ModelLimit, UsageError
from vcmm.measuring.scenario import Scenario
from vcmm.placing.job import place
from vcmm.placing.result import Placed


@dataclass(frozen=True, eq=False)
class Choice:
    """placed: per machine; order: names from the best to the worst; refused: machines that cannot take the part, why."""

    placed: Mapping[str, Placed]
    order: tuple[str, ...]
    refused: Mapping[str, str]


def choose_machine(
    scenarios: Mapping[str, Scenario], *, progress: Callable[[str, float], None] | None = None, **options: Any
) -> Choice:
    """Place the part on every machine (options: those of `place`) and rank them by the objective.

    Raises UsageError when no machine can take the part.
    """
    placed, refused = {}, {}
    for name, scenario in scenarios.items():
        try:
            placed[name] = place(scenario, progress=progress, **options)
        except ModelLimit as error:
            refused[name] = str(error)
    if not placed:
        why = "; ".join(f"{n}: {w}" for n, w in refused.items())
        raise UsageError(f"none of the machines can take the part: {why}")
    order = tuple(sorted(placed, key=lambda n: placed[n].best.value))
    return Choice(placed, order, refused)
