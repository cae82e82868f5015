"""vcmm demo: a ring gauge, measured virtually; with --twin a published job instead."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from inspect import signature
from pathlib import Path
from types import ModuleType
from typing import Annotated, Any, Literal, NamedTuple

from cyclopts import Parameter
from cyclopts.validators import Number

from vcmm.answer.evaluation.result import CharacteristicResult, UncertaintyResult
from vcmm.core.errors import UsageError
from vcmm.face import api
from vcmm.face.cli.options import Json
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.face.twins import twin as load_twin
from vcmm.files.own.library import companions, cuts, example, records, scenarios, turns_over
from vcmm.files.own.scenario import load_scenario
from vcmm.show.console.terminal import show_answers, show_table
from vcmm.show.pages.uncertainty import characteristic_charts, scenes, uncertainty_page
from vcmm.show.report import blocks as r
from vcmm.show.tables.table import csv_text
from vcmm.show.tables.uncertainty import characteristic_json
from vcmm.task.measuring.scenario import Scenario

COMMAND = "vcmm"


def demo_command(
    *,
    out: Path = Path("vcmm-demo"),
    twin: Literal[
        "gaska2014", "abbe_milling", "echerfaoui2017", "marin2004", "test_piece", "worn_cmm", "xcz_lathe"
    ]
    | None = None,
    draws: Annotated[int | None, Parameter(validator=Number(gte=1, lte=10**6))] = None,
    trials: Annotated[int | None, Parameter(validator=Number(gte=1000, lte=10**9))] = None,
    json: Json = False,
) -> int:
    """Virtually measure a ring gauge: value, U, decision, main contributor, a report. Start here.

    With --twin a published job: gaska2014 measures a compressor body at five places of a CMM; abbe_milling, marin2004 and test_piece mill a
    part virtually, worn_cmm diagnoses a log with concealed faults, xcz_lathe measures a flat on a lathe and takes the lathe's errors off.

    Parameters
    ----------
    out
        Folder for report.html, demo.json and, for gaska2014, demo.csv and the lengths of its LaserTracer.
    twin
        Published job to run instead.
    draws
        Machines drawn for the ranges (gaska2014: 200 that agree with the published figures; abbe_milling: 100).
    trials
        Monte Carlo trials per place (gaska2014).
    json
        Print one JSON document.
    """
    if twin is None:
        _refuse_idle({"--draws": draws, "--trials": trials})
        return run_job(RingGaugeJob(out), Flags(json, out))
    if twin != "gaska2014":
        return run_job(TwinJob(twin, draws, out, COMMAND), Flags(json, out))
    return run_job(
        GaskaJob(200 if draws is None else draws, 20_000 if trials is None else trials, out), Flags(json, out)
    )


def _refuse_idle(given: dict[str, int | None]) -> None:
    idle = [name for name, value in given.items() if value is not None]
    if idle:
        raise UsageError(f"{', '.join(idle)}: of a published job; add --twin gaska2014, or leave it out")


@dataclass(frozen=True)
class RingGaugeJob(Job[Scenario, UncertaintyResult]):
    """One part on one machine: ten lines, a report, three next commands. folder: of the report."""

    folder: Path
    schema = "vcmm.demo/1"

    def load(self) -> Scenario:
        return load_scenario(example("ring_gauge"))

    def run(self, loaded: Scenario, report: Progress) -> UncertaintyResult:
        return api.uncertainty(loaded, progress=report)

    def record(self, loaded: Scenario, result: UncertaintyResult) -> Record:
        body = {"first": characteristic_json(result.characteristics[0])}
        return Record(body, [example("ring_gauge")], loaded.settings.seed, result.warnings)

    def texts(
        self, loaded: Scenario, result: UncertaintyResult, content: str, folder: Path
    ) -> dict[str, str]:
        page = uncertainty_page(loaded, result, [example("ring_gauge")])
        return {"demo.json": content, "report.html": page}

    def files_sentence(
        self, loaded: Scenario, result: UncertaintyResult, folder: Path, names: Sequence[str]
    ) -> str:
        return ""  # the answer names the report

    def show(self, loaded: Scenario, result: UncertaintyResult) -> None:
        print("\n".join(first_lines(loaded, result.characteristics[0])))
        print(f"\nReport: {self.folder}/report.html\nNext:")
        for words in (
            "new ring_gauge",
            "uncertainty ring_gauge.toml --out ring_gauge-report",
            "demo --twin gaska2014",
        ):
            print(f"  {COMMAND} {words}")


class GaskaTask(NamedTuple):
    """The twin, its scenario, and the ring gauge that comes first."""

    twin: ModuleType
    scenario: Scenario
    ring: Scenario


class GaskaResult(NamedTuple):
    """The ring gauge, and the result of the twin, of its own kind."""

    first: UncertaintyResult
    twin: Any


@dataclass(frozen=True)
class GaskaJob(Job[GaskaTask, GaskaResult]):
    """A compressor body at five places of a CMM. folder: of the report and of the lengths of the LaserTracer."""

    draws: int
    trials: int
    folder: Path
    schema = "vcmm.demo/1"

    def load(self) -> GaskaTask:
        twin = load_twin("gaska2014")
        return GaskaTask(twin, load_scenario(example("gaska2014")), load_scenario(example("ring_gauge")))

    def run(self, loaded: GaskaTask, report: Progress) -> GaskaResult:
        first = api.uncertainty(loaded.ring, progress=report)
        return GaskaResult(first, loaded.twin.twin.run(loaded.scenario, self.draws, self.trials, report))

    def record(self, loaded: GaskaTask, result: GaskaResult) -> Record:
        first = characteristic_json(result.first.characteristics[0])
        body = {"first": first, **loaded.twin.twin.figures(result.twin)}
        return Record(body, [example("ring_gauge"), example("gaska2014")], loaded.scenario.settings.seed)

    def texts(self, loaded: GaskaTask, result: GaskaResult, content: str, folder: Path) -> dict[str, str]:
        page = loaded.twin.page
        first = first_blocks(loaded.ring, result.first)
        return {
            "demo.json": content,
            "demo.csv": csv_text(page.places_table(result.twin)),
            "report.html": page.twin_page(loaded.scenario, result.twin, first),
            **loaded.twin.twin.tracer_files(),
        }

    def show(self, loaded: GaskaTask, result: GaskaResult) -> None:
        page, folder = loaded.twin.page, self.folder
        show_answers(page.answers(result.twin))
        for table in page.tables(result.twin):
            show_table(table)
        print(
            f"Next:\n  {COMMAND} calibrate {folder}/tracer.toml --machine {folder}/cmm.toml --nodes\n  {COMMAND} place gaska2014"
        )


def first_lines(scenario: Scenario, c: CharacteristicResult) -> list[str]:
    """Return the measurement and its place; then the answer."""
    touches = sum(len(s.points) for s in scenario.plan.steps)
    what = f"{scenario.name[:1].upper()}{scenario.name[1:]}: {touches} points on a {scenario.machine.name}, measured virtually."
    return [what, "", r.answer_text([r.answer_of(c)])]


def first_blocks(scenario: Scenario, result: UncertaintyResult) -> list[str]:
    """Return the sentences, the charts of the first characteristic and the picture of its touches."""
    c = result.characteristics[0]
    title = "The part and its touches"
    picture = r.scene(
        scenes(result)[1],
        title=title,
        caption="Ellipsoids: where each touch may really be, k = 1.",
        height=380,
    )
    what, _, _ = first_lines(scenario, c)
    return [r.paragraph(what), r.answers_block([r.answer_of(c)]), *characteristic_charts(c), picture]


class Outcome(NamedTuple):
    """The twin's result, of its own kind, its page, the files read."""

    result: Any
    html: str
    files: list[Path]


@dataclass(frozen=True)
class TwinJob(Job[ModuleType, Outcome]):
    """One twin on its embedded files. folder: of report.html and demo.json; me: how the user calls vcmm."""

    name: str
    draws: int | None
    folder: Path
    me: str
    schema = "vcmm.twin/1"

    def load(self) -> ModuleType:
        package = load_twin(self.name)
        if self.draws is not None and not draws_machines(package):
            raise UsageError(f"--draws is of no use to {self.name}: it draws no machines; leave it out")
        return package

    def run(self, loaded: ModuleType, report: Progress) -> Outcome:
        run, _ = way_of(self.name)
        return run(self.name, loaded, {} if self.draws is None else {"draws": self.draws}, report)

    def record(self, loaded: ModuleType, result: Outcome) -> Record:
        return Record({"twin": self.name, **loaded.twin.figures(result.result)}, result.files)

    def texts(self, loaded: ModuleType, result: Outcome, content: str, folder: Path) -> dict[str, str]:
        return {"demo.json": content, "report.html": result.html}

    def files_sentence(self, loaded: ModuleType, result: Outcome, folder: Path, names: Sequence[str]) -> str:
        return f"wrote {folder}/report.html, demo.json"

    def show(self, loaded: ModuleType, result: Outcome) -> None:
        show_answers(loaded.page.answers(result.result))
        for table in loaded.page.tables(result.result):
            show_table(table)
        _, following = way_of(self.name)
        nexts = ["Next:", f"open {self.folder}/report.html", *(f"{self.me} {words}" for words in following)]
        print("\n  ".join(nexts))


def draws_machines(package: ModuleType) -> bool:
    """Return whether the ranges of a twin are over sampled machines, so that `--draws` states their number."""
    return "draws" in signature(package.twin.run).parameters


def way_of(name: str) -> tuple[Callable[..., Outcome], list[str]]:
    """Return how a twin is run, according to its scenario, and the commands that come next."""
    if name not in scenarios():
        return _run_drawn, ["calibrate --help"]
    new = f"new {name}"
    if turns_over(example(name)):
        return _run_drawn, [new]
    if cuts(example(name)):
        return _run_cut, [new, f"cut {name}.toml --out {name}-report"]
    if records(example(name)):
        return _run_recorded, [new, f"diagnose {name}.toml --out {name}-report"]
    return _run_drawn, [new]


def _run_cut(
    name: str,
    package: ModuleType,
    options: dict[str, int],
    report: Progress,
) -> Outcome:
    """Run a twin that cuts its scenario."""
    from vcmm.files.own.cut_scenario import load_cut

    scenario = load_cut(example(name))
    result = package.twin.run(scenario, **options, progress=report)
    return Outcome(
        result, package.page.twin_page(scenario, result), [example(name), *companions(name).values()]
    )


def _run_drawn(
    name: str,
    package: ModuleType,
    options: dict[str, int],
    report: Progress,
) -> Outcome:
    """Run a twin whose machines and readings are sampled."""
    result = package.twin.run(**options, progress=report)
    return Outcome(result, package.page.twin_page(result), [])


def _run_recorded(
    name: str,
    package: ModuleType,
    options: dict[str, int],
    report: Progress,
) -> Outcome:
    """Run a twin that diagnoses its recording, and does the measuring job of the scenario plate."""
    from vcmm.files.own.recording import load_recording
    from vcmm.files.own.scenario import load_scenario

    recording, machine = load_recording(example(name))
    result = package.twin.run(recording, machine, load_scenario(example("plate")), progress=report)
    return Outcome(
        result,
        package.page.twin_page(result),
        [example(name), *companions(name).values(), example("plate")],
    )
