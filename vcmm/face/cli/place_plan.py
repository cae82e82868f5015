"""vcmm place --plan: points, styli and order under a time budget."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from vcmm.answer.placing.planfiles import plan_files, plan_json
from vcmm.answer.placing.planning import PlanResult, optimise_plan
from vcmm.core.units import quantity
from vcmm.face.job import Job, Progress, Record
from vcmm.files.own.scenario import load_scenario
from vcmm.part.gps import characteristics as gps
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import show_answers, show_table
from vcmm.show.tables.answers import plan_answers
from vcmm.show.tables.placement import curve
from vcmm.task.measuring.scenario import Scenario


@dataclass(frozen=True)
class PlanJob(Job[Scenario, PlanResult]):
    """The plan of a scenario optimised at its pose. budget: a time with its unit, "5 min"."""

    scenario: Path
    budget: str
    seed: int | None
    schema = "vcmm.plan/1"

    @property
    def place(self) -> tuple[Path, str]:
        return self.scenario, ""

    def load(self) -> Scenario:
        return load_scenario(self.scenario)

    def run(self, loaded: Scenario, report: Progress) -> PlanResult:
        seconds = quantity(self.budget, "time", "budget", "5 min")
        return optimise_plan(loaded, seconds, criterion="U", seed=self.seed_of(loaded), progress=report)

    def seed_of(self, loaded: Scenario) -> int:
        return loaded.settings.seed if self.seed is None else self.seed

    def record(self, loaded: Scenario, result: PlanResult) -> Record:
        return Record(plan_json(loaded, result), sources(self.scenario), self.seed_of(loaded))

    def texts(self, loaded: Scenario, result: PlanResult, content: str, folder: Path) -> dict[str, str]:
        from vcmm.show.pages.plan import plan_page

        plan = plan_files(result.plan, loaded.qualifications)
        return {"plan.json": content, "report.html": plan_page(loaded, result), **plan}

    def files_sentence(self, loaded: Scenario, result: PlanResult, folder: Path, names: Sequence[str]) -> str:
        points = len(names) - 3  # beside plan.json, report.html, plan.toml
        return f"wrote {folder}/report.html, plan.json, plan.toml and {points} files of points"

    def show(self, loaded: Scenario, result: PlanResult) -> None:
        units = {c.name: gps.unit(c) for c in loaded.part.characteristics}
        show_answers(plan_answers(result, units))
        show_table(curve(loaded, result))
