"""Twins for `vcmm demo --twin`: run, tables, report, JSON."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass
from inspect import signature
from pathlib import Path
from types import ModuleType
from typing import Any, NamedTuple

from vcmm.core.errors import UsageError
from vcmm.face.job import Job, Progress, Record
from vcmm.face.twins import twin as load_twin
from vcmm.files.own.library import companions, cuts, example, records, scenarios, turns_over
from vcmm.show.console.terminal import show_answers, show_table


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
