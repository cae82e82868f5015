"""The jobs as Python calls on a Scenario; the command line calls the same functions."""

from __future__ import annotations

from dataclasses import replace

from vcmm.evaluation import evaluate
from vcmm.measuring import Measurement, measure_task
from vcmm.remarks import remarks
from vcmm.result import UncertaintyResult
from vcmm.sampling import Progress
from vcmm.scenario import Scenario


def measure(scenario: Scenario, seed: int | None = None) -> Measurement:
    """One virtual measurement. seed=None: errors at their estimates; an int: one draw from what is known."""
    return measure_task(scenario.task(), seed)


def uncertainty(
    scenario: Scenario,
    *,
    seed: int | None = None,
    trials: int | None = None,
    engine: str | None = None,
    digits: int | None = None,
    progress: Progress | None = None,
) -> UncertaintyResult:
    """Task-specific uncertainty of every characteristic; settings of the scenario unless given here."""
    changes = {"seed": seed, "trials": trials, "engine": engine, "digits": digits}
    settings = replace(scenario.settings, **{k: v for k, v in changes.items() if v is not None})  # type: ignore[arg-type]
    found = evaluate(scenario.task(), settings, progress)
    return replace(found, warnings=(*remarks(scenario), *found.warnings))
