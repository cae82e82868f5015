"""Twins for `vcmm demo --twin`: run, tables, report, JSON."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any


def twin_command(name: str, folder: Path, draws: int | None, json: bool, me: str) -> int:
    """Run one twin on its embedded files and write report.html and demo.json. me: how the user calls vcmm."""
    from vcmm.core.errors import UsageError
    from vcmm.face.twins import twin as load
    from vcmm.show.console.documents import document, json_text, print_json
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import progress, say, show_answers, show_table

    package = load(name)
    if draws is not None and not draws_machines(package):
        raise UsageError(f"--draws is of no use to {name}: it draws no machines; leave it out")
    output_folder(folder)
    run, following = way_of(name)
    with progress() as report:
        result, html, files = run(name, package, {} if draws is None else {"draws": draws}, report)
    content = document("vcmm.twin/1", {"twin": name, **package.twin.figures(result)}, files=files)
    write_files(folder, {"demo.json": json_text(content), "report.html": html})
    if json:
        print_json(content)
        return 0
    show_answers(package.page.answers(result))
    for table in package.page.tables(result):
        show_table(table)
    say(f"wrote {folder}/report.html, demo.json")
    print("\n  ".join(["Next:", f"open {folder}/report.html", *(f"{me} {words}" for words in following)]))
    return 0


def draws_machines(package: ModuleType) -> bool:
    """Whether the ranges of a twin are over drawn machines, so that `--draws` says how many."""
    from inspect import signature

    return "draws" in signature(package.twin.run).parameters


def way_of(name: str) -> tuple[Callable[..., Outcome], list[str]]:
    """How a twin is run, which its scenario says, and the commands that come next."""
    from vcmm.files.own.library import cuts, example, records, scenarios, turns_over

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


Outcome = tuple[Any, str, list[Path]]  # the twin's result, its page, the files read


def _run_cut(
    name: str,
    package: ModuleType,
    options: dict[str, int],
    report: Callable[[str, float], None],
) -> Outcome:
    """A twin that cuts its scenario."""
    from vcmm.files.own.cut_scenario import load_cut
    from vcmm.files.own.library import companions, example

    scenario = load_cut(example(name))
    result = package.twin.run(scenario, **options, progress=report)
    return result, package.page.twin_page(scenario, result), [example(name), *companions(name).values()]


def _run_drawn(
    name: str,
    package: ModuleType,
    options: dict[str, int],
    report: Callable[[str, float], None],
) -> Outcome:
    """A twin whose machines and readings are drawn."""
    result = package.twin.run(**options, progress=report)
    return result, package.page.twin_page(result), []


def _run_recorded(
    name: str,
    package: ModuleType,
    options: dict[str, int],
    report: Callable[[str, float], None],
) -> Outcome:
    """A twin that diagnoses its recording, and does the measuring job of the scenario plate."""
    from vcmm.files.own.library import companions, example
    from vcmm.files.own.recording import load_recording
    from vcmm.files.own.scenario import load_scenario

    recording, machine = load_recording(example(name))
    result = package.twin.run(recording, machine, load_scenario(example("plate")), progress=report)
    return (
        result,
        package.page.twin_page(result),
        [example(name), *companions(name).values(), example("plate")],
    )
