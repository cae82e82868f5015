"""Twins for `vcmm demo --twin`: run, tables, report, JSON."""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from types import ModuleType
from typing import Any


def _abbe_milling() -> tuple[ModuleType, ModuleType]:
    from vcmm.papers.abbe_milling import page, twin

    return twin, page


def _echerfaoui2017() -> tuple[ModuleType, ModuleType]:
    from vcmm.papers.echerfaoui2017 import page, twin

    return twin, page


def _marin2004() -> tuple[ModuleType, ModuleType]:
    from vcmm.papers.marin2004 import page, twin

    return twin, page


def _test_piece() -> tuple[ModuleType, ModuleType]:
    from vcmm.cases import test_piece_errors, test_piece_page

    return test_piece_errors, test_piece_page


def _worn_cmm() -> tuple[ModuleType, ModuleType]:
    from vcmm.cases import worn_cmm, worn_cmm_page

    return worn_cmm, worn_cmm_page


def _xcz_lathe() -> tuple[ModuleType, ModuleType]:
    from vcmm.papers.xcz_lathe import page, twin

    return twin, page


# Twin (run, figures) and page (tables, twin_page) of each name, imported when it is run.
TWINS: dict[str, Callable[[], tuple[ModuleType, ModuleType]]] = {
    "abbe_milling": _abbe_milling,
    "echerfaoui2017": _echerfaoui2017,
    "marin2004": _marin2004,
    "test_piece": _test_piece,
    "worn_cmm": _worn_cmm,
    "xcz_lathe": _xcz_lathe,
}
DRAWN = ("abbe_milling", "echerfaoui2017", "xcz_lathe")  # twins whose ranges are over drawn machines


def twin_command(name: str, folder: Path, draws: int | None, json: bool, me: str) -> int:
    """Run one twin on its embedded files and write report.html and demo.json. me: how the user calls vcmm."""
    from vcmm.core.errors import UsageError
    from vcmm.files.own.library import scenarios
    from vcmm.show.console.documents import document, json_text, print_json
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import progress, say, show_table

    if draws is not None and name not in DRAWN:
        raise UsageError(f"--draws is of no use to {name}: it draws no machines; leave it out")
    output_folder(folder)
    twin, page = TWINS[name]()
    run = {"worn_cmm": _recorded_run, "echerfaoui2017": _drawn_run, "xcz_lathe": _drawn_run}.get(
        name, _cut_run
    )
    with progress() as report:
        result, html, files = run(name, twin, page, {} if draws is None else {"draws": draws}, report)
    content = document("vcmm.twin/1", {"twin": name, **twin.figures(result)}, files=files)
    write_files(folder, {"demo.json": json_text(content), "report.html": html})
    if json:
        print_json(content)
        return 0
    for table in page.tables(result):
        show_table(table)
    say(f"wrote {folder}/report.html, demo.json")
    if run is _drawn_run:
        more = f"new {name}" if name in scenarios() else "calibrate --help"
        print(f"Next:\n  open {folder}/report.html\n  {me} {more}")
        return 0
    verb = "diagnose" if name == "worn_cmm" else "cut"
    print(
        f"Next:\n  open {folder}/report.html\n  {me} new {name}\n  {me} {verb} {name}.toml --out {name}-report"
    )
    return 0


Outcome = tuple[Any, str, list[Path]]  # the twin's result, its page, the files read


def _cut_run(
    name: str,
    twin: ModuleType,
    page: ModuleType,
    options: dict[str, int],
    report: Callable[[str, float], None],
) -> Outcome:
    """A twin that cuts its scenario."""
    from vcmm.files.own.cut_scenario import load_cut
    from vcmm.files.own.library import companions, example

    scenario = load_cut(example(name))
    result = twin.run(scenario, **options, progress=report)
    return result, page.twin_page(scenario, result), [example(name), *companions(name).values()]


def _drawn_run(
    name: str,
    twin: ModuleType,
    page: ModuleType,
    options: dict[str, int],
    report: Callable[[str, float], None],
) -> Outcome:
    """A twin whose machines and readings are drawn."""
    result = twin.run(**options, progress=report)
    return result, page.twin_page(result), []


def _recorded_run(
    name: str,
    twin: ModuleType,
    page: ModuleType,
    options: dict[str, int],
    report: Callable[[str, float], None],
) -> Outcome:
    """A twin that diagnoses its recording, and does the measuring job of the scenario plate."""
    from vcmm.files.own.library import companions, example
    from vcmm.files.own.recording import load_recording
    from vcmm.files.own.scenario import load_scenario

    recording, machine = load_recording(example(name))
    result = twin.run(recording, machine, load_scenario(example("plate")), progress=report)
    return result, page.twin_page(result), [example(name), *companions(name).values(), example("plate")]
