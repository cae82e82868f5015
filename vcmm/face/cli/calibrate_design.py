"""vcmm calibrate --design: errors that planned set-ups identify, and which set-ups to take."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

from vcmm.core.machine import Machine
from vcmm.face.cli.calibrate_poses import PosesJob
from vcmm.face.job import Job, Progress, Record
from vcmm.files.own.design import load_design
from vcmm.learn.calibration.design import (
    PlannedSetup,
    Proposal,
    SetupPlan,
    best_within,
    cheapest_complete,
    plan_of,
    proposal,
)
from vcmm.learn.calibration.pose_design import is_pose_design
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import show_answers, show_table
from vcmm.show.tables.answers_runs import design_answers
from vcmm.show.tables.calibration import PROPOSALS, setups
from vcmm.show.tables.table import records


def design_job(path: Path) -> Job[Any, Any]:
    """Return the job of a plan: of set-ups, or of the rotary positions of a touch probe."""
    made, machine, budget = load_design(path)
    planned = [PlannedSetup(*setup) for setup in made]
    if is_pose_design(planned):
        return PosesJob(path, planned, machine, budget)
    return DesignJob(path, planned, budget, plan_machine=machine)


class Proposals(NamedTuple):
    """Errors that all set-ups of a plan identify together, the best set-ups within the budget, the cheapest complete ones."""

    plan: SetupPlan
    everything: Proposal
    best: Proposal | None
    cheapest: Proposal | None


@dataclass(frozen=True)
class DesignJob(Job[list[PlannedSetup], Proposals]):
    """The set-ups of a plan. budget: minutes. Exit code 1 where even all of them leave something open."""

    path: Path
    setups: list[PlannedSetup]
    budget: float | None
    plan_machine: Machine
    schema = "vcmm.design/1"

    @property
    def place(self) -> tuple[Path, str]:
        return self.path, "setups"

    def load(self) -> list[PlannedSetup]:
        return self.setups

    def run(self, loaded: list[PlannedSetup], report: Progress) -> Proposals:
        plan, budget = plan_of(loaded, self.plan_machine), self.budget
        complete = cheapest_complete(plan)
        return Proposals(
            plan,
            proposal(plan, range(len(plan.names))),
            None if budget is None else proposal(plan, best_within(plan, budget)),
            None if complete is None else proposal(plan, complete),
        )

    def record(self, loaded: list[PlannedSetup], result: Proposals) -> Record:
        body = {
            "setups": len(result.plan.names),
            "all": _only(result.everything),
            "budget_minutes": self.budget,
            "best_within_budget": None if result.best is None else _only(result.best),
            "cheapest_complete": None if result.cheapest is None else _only(result.cheapest),
        }
        return Record(body, sources(self.path), 0)

    def texts(
        self, loaded: list[PlannedSetup], result: Proposals, content: str, folder: Path
    ) -> dict[str, str]:
        return {"design.json": content}

    def exit_code(self, loaded: list[PlannedSetup], result: Proposals) -> int:
        return int(bool(result.everything.identifiability.combinations))

    def show(self, loaded: list[PlannedSetup], result: Proposals) -> None:
        _, everything, best, cheapest = result
        chosen = (
            ("all", everything),
            ("best within the budget", best),
            ("cheapest that is complete", cheapest),
        )
        show_answers(design_answers(everything, best, cheapest))
        show_table(setups([(what, proposal) for what, proposal in chosen if proposal is not None]))
        for c in everything.identifiability.combinations:
            print(f"not identified, even by all: {c.text}")


def _only(proposal: Proposal) -> dict[str, object]:
    """Return the record of one proposal."""
    (record,) = records(PROPOSALS, [proposal])
    return record
