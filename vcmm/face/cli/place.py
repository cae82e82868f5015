"""vcmm place: the best pose of a part; with --plan points, styli and order under a time budget."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from vcmm.answer.placing.advice import advice, room_and_shares
from vcmm.answer.placing.placement import place
from vcmm.answer.placing.planfiles import plan_files, plan_json
from vcmm.answer.placing.planning import PlanResult, optimise_plan
from vcmm.answer.placing.result import PlacementResult, place_json
from vcmm.answer.placing.words import pose_text
from vcmm.core.errors import UsageError
from vcmm.core.units import quantity
from vcmm.face.cli.options import Cluster, CountOption, InputName, InputPath, Json, Seed, Shard, Workers
from vcmm.face.cli.place_machines import PlaceMachinesJob
from vcmm.face.job import Flags, Job, Progress, Record, run_job, run_shared, sharing_of
from vcmm.files.own.library import example
from vcmm.files.own.placement_writer import placed_text
from vcmm.files.own.scenario import load_scenario
from vcmm.files.toml import read_toml
from vcmm.part.gps import characteristics as gps
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import say_warnings, show_answers, show_table
from vcmm.show.tables.answers import place_answers, plan_answers
from vcmm.show.tables.placement import compared_poses, curve, how_sure, why
from vcmm.task.measuring.scenario import Scenario

TWIN = "gaska2014"


def place_command(
    scenario: InputName,
    *,
    plan: Annotated[bool, Parameter(name="--plan")] = False,
    budget: str | None = None,
    machines: Annotated[list[InputPath] | None, Parameter(consume_multiple=True)] = None,
    seed: Seed | None = None,
    evaluations: CountOption = None,
    scan: CountOption = None,
    trials: CountOption = None,
    draws: CountOption = None,
    workers: Workers = None,
    cluster: Cluster = None,
    shard: Shard = None,
    json: Json = False,
    out: Path | None = None,
) -> int:
    """Find the pose, among those that the fixture allows, with the smallest objective: gain, map, flatness, certificate.

    [placement] of the scenario says what may move and what is minimised; without it the part slides on the table and turns about the
    vertical, for U/T of all. A part that is cut moves with its work offset. `vcmm place gaska2014` runs the twin of a published study.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1).
    plan
        Keep the pose; choose points, styli and order instead, and show U against measuring time.
    budget
        Measuring time that a plan may take (default: "5 min"); with --plan only.
    machines
        Machine files to choose from, or folders; each takes the place of the scenario's machine.
    seed
        Seed of the search, the scan and the trials (default: the scenario's, else 0).
    evaluations
        Evaluations of the objective that the search may use (default: 5000; gaska2014: 3000).
    scan
        Further poses for the certificate, the median and the worst pose (default: 4096; gaska2014: 2048).
    trials
        Monte Carlo trials of the full evaluation at the present and the best pose.
    draws
        Machines consistent with the published figures (default: 200); for gaska2014 only.
    workers
        Processes that share the machines of --machines; the document does not depend on it.
    cluster
        Address of a Dask scheduler whose workers share them, such as tcp://scheduler:8786.
    shard
        Try one part of the machines only, such as 2/8, for a batch queue; `vcmm merge` puts all parts together.
    json
        Print one JSON document.
    out
        Folder for report.html, place.json and placed.toml (the new pose); with --plan for plan.json, plan.toml and points as CSV.
    """
    _check(plan, machines, draws, budget, (evaluations, scan, trials), (workers, cluster, shard))
    flags = Flags(json, out)
    if plan:
        return run_job(PlanJob(scenario, budget or "5 min", seed), flags)
    options = {"seed": seed, "evaluations": evaluations, "scanned": scan, "trials": trials}
    cuts = scenario.is_file() and _cuts(scenario)
    if machines and not cuts and str(scenario) != TWIN:
        sharing = sharing_of(workers, cluster, shard)
        return run_shared(PlaceMachinesJob(scenario, tuple(machines), options, sharing=sharing), flags)
    search = {name: value for name, value in options.items() if value is not None}
    if str(scenario) == TWIN and not scenario.exists():
        _refuse("the twin has machines of its own", {"--machines": machines})
        return run_job(PlaceTwinJob(draws or 200, search), flags)
    _refuse("only gaska2014 draws machines", {"--draws": draws})
    if cuts:
        from vcmm.face.cli.place_cut import PlaceCutJob

        _refuse("a program is cut on the machine that its set-up was made for", {"--machines": machines})
        return run_job(PlaceCutJob(scenario, search), flags)
    return run_job(PlaceJob(scenario, search), flags)


def _check(
    plan: bool,
    machines: list[Path] | None,
    draws: int | None,
    budget: str | None,
    search: tuple[int | None, ...],
    shared: tuple[object, ...],
) -> None:
    """Raises UsageError for options that would be passed over in silence."""
    if not machines or plan:
        options = dict(zip(("--workers", "--cluster", "--shard"), (word is not None for word in shared)))
        _refuse("only the machines of --machines are shared out", options)
    if plan:
        given = dict(zip(("--evaluations", "--scan", "--trials"), search))
        _refuse("--plan chooses points at one pose", {**given, "--machines": machines, "--draws": draws})
    else:
        _refuse("without --plan no points are chosen", {"--budget": budget})
    if machines:
        _refuse("the machines are those of --machines", {"--draws": draws})


def _refuse(why: str, given: Mapping[str, object]) -> None:
    """Refuse an option that would be ignored in silence."""
    idle = [name for name, value in given.items() if value]
    if idle:
        raise UsageError(f"{', '.join(idle)}: {why}, so this has no meaning here; leave it out")


def _cuts(scenario: Path) -> bool:
    """Return whether the scenario cuts a part."""
    return "cut" in read_toml(scenario).data


@dataclass(frozen=True)
class PlaceJob(Job[Scenario, PlacementResult]):
    """One measuring task at its best pose. search: options of the search that were given."""

    scenario: Path
    search: Mapping[str, Any]
    schema = "vcmm.place/1"

    @property
    def place(self) -> tuple[Path, str]:
        return self.scenario, "placement"

    def load(self) -> Scenario:
        return load_scenario(self.scenario)

    def run(self, loaded: Scenario, report: Progress) -> PlacementResult:
        return place(loaded, progress=report, **self.search)

    def record(self, loaded: Scenario, result: PlacementResult) -> Record:
        body = place_json(result) | {"advice": advice(result)}
        return Record(body, sources(self.scenario), result.seed, result.warnings)

    def texts(self, loaded: Scenario, result: PlacementResult, content: str, folder: Path) -> dict[str, str]:
        from vcmm.show.pages.place import place_page

        target, near = folder / "placed.toml", result.region.convenient
        placed = placed_text(self.scenario, target, result.best.pose, convenient=near)
        return {"place.json": content, "report.html": place_page(result), "placed.toml": placed}

    def files_sentence(
        self, loaded: Scenario, result: PlacementResult, folder: Path, names: Sequence[str]
    ) -> str:
        return f"wrote {folder}/report.html, place.json, placed.toml"

    def show(self, loaded: Scenario, result: PlacementResult) -> None:
        """Show poses compared, reasons, certificate and flatness, advice."""
        show_answers(place_answers(result))
        for table in (compared_poses(result), why(result), how_sure(result)):
            show_table(table)
        if result.region.convenient is not None:
            print(f"convenient pose within 2 %: {pose_text(result.region.convenient)}")
        print("\n".join(["advice:", *room_and_shares(result)]))
        say_warnings(result.warnings)


@dataclass(frozen=True)
class PlaceTwinJob(Job[Scenario, Any]):
    """The twin of the published study: ranking, optimum and node reduction. Its result is of the twin's own kind."""

    draws: int
    search: Mapping[str, Any]
    schema = "vcmm.place/1"

    def load(self) -> Scenario:
        return load_scenario(example(TWIN))

    def run(self, loaded: Scenario, report: Progress) -> Any:
        from vcmm.face.twins import twin

        return twin(TWIN).placement_command.study(loaded, self.draws, dict(self.search), report)

    def record(self, loaded: Scenario, result: Any) -> Record:
        seed = self.search.get("seed", loaded.settings.seed)
        return Record(result.body(), [example(TWIN)], seed)

    def texts(self, loaded: Scenario, result: Any, content: str, folder: Path) -> dict[str, str]:
        return {"place.json": content, "report.html": result.html()}

    def files_sentence(self, loaded: Scenario, result: Any, folder: Path, names: Sequence[str]) -> str:
        return f"wrote {folder}/report.html, place.json"

    def show(self, loaded: Scenario, result: Any) -> None:
        for table in result.tables():
            show_table(table)


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
