"""vcmm demo: a ring gauge, measured virtually; with --twin a published job instead."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Literal

from cyclopts import Parameter
from cyclopts.validators import Number


def demo_command(
    *,
    out: Path = Path("vcmm-demo"),
    twin: Literal[
        "gaska2014", "abbe_milling", "echerfaoui2017", "marin2004", "test_piece", "worn_cmm", "xcz_lathe"
    ]
    | None = None,
    draws: Annotated[int | None, Parameter(validator=Number(gte=1, lte=10**6))] = None,
    trials: Annotated[int | None, Parameter(validator=Number(gte=1000, lte=10**9))] = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
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
        return _ring_gauge(out, json)
    if twin != "gaska2014":
        from vcmm.face.cli.twins import twin_command

        return twin_command(twin, out, draws, json, COMMAND)
    return _gaska(out, 200 if draws is None else draws, 20_000 if trials is None else trials, json)


COMMAND = "vcmm"


def _refuse_idle(given: dict[str, int | None]) -> None:
    from vcmm.core.errors import UsageError

    idle = [name for name, value in given.items() if value is not None]
    if idle:
        raise UsageError(f"{', '.join(idle)}: of a published job; add --twin gaska2014, or leave it out")


def _ring_gauge(out: Path, json: bool) -> int:
    """One part on one machine: ten lines, a report, three next commands."""
    from vcmm.face import api
    from vcmm.files.own.library import example
    from vcmm.files.own.scenario import load_scenario
    from vcmm.show.console.documents import document, json_text, print_json
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import progress
    from vcmm.show.pages.first import first_lines
    from vcmm.show.pages.uncertainty import uncertainty_page
    from vcmm.show.tables.uncertainty import characteristic_json

    folder, source = output_folder(out), example("ring_gauge")
    scenario = load_scenario(source)
    with progress() as report:
        result = api.uncertainty(scenario, progress=report)
    body = {"first": characteristic_json(result.characteristics[0])}
    content = document(
        "vcmm.demo/1", body, seed=scenario.settings.seed, files=[source], warnings=result.warnings
    )
    page = uncertainty_page(scenario, result, [source])
    write_files(folder, {"demo.json": json_text(content), "report.html": page})
    if json:
        print_json(content)
        return 0
    print("\n".join(first_lines(scenario, result.characteristics[0])))
    print(f"\nReport: {folder}/report.html\nNext:")
    for words in (
        "new ring_gauge",
        "uncertainty ring_gauge.toml --out ring_gauge-report",
        "demo --twin gaska2014",
    ):
        print(f"  {COMMAND} {words}")
    return 0


def _gaska(out: Path, draws: int, trials: int, json: bool) -> int:
    from vcmm.face import api
    from vcmm.face.twins import twin as load_twin
    from vcmm.files.own.library import example
    from vcmm.files.own.scenario import load_scenario
    from vcmm.show.console.documents import document, json_text, print_json
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import progress, say, show_answers, show_table
    from vcmm.show.pages.first import first_blocks
    from vcmm.show.tables.table import csv_text
    from vcmm.show.tables.uncertainty import characteristic_json

    folder = output_folder(out)
    source, ring = example("gaska2014"), example("ring_gauge")
    gaska = load_twin("gaska2014")
    scenario, plain = load_scenario(source), load_scenario(ring)
    with progress() as report:
        first = api.uncertainty(plain, progress=report)
        result = gaska.twin.run(scenario, draws, trials, report)
    body = {"first": characteristic_json(first.characteristics[0]), **gaska.twin.figures(result)}
    content = document("vcmm.demo/1", body, seed=scenario.settings.seed, files=[ring, source])
    texts = {
        "demo.json": json_text(content),
        "demo.csv": csv_text(gaska.page.places_table(result)),
        "report.html": gaska.page.twin_page(scenario, result, first_blocks(plain, first)),
        **gaska.twin.tracer_files(),
    }
    write_files(folder, texts)
    if json:
        print_json(content)
        return 0
    show_answers(gaska.page.answers(result))
    for table in gaska.page.tables(result):
        show_table(table)
    say(f"wrote {folder}/{', '.join(texts)}")
    print(
        f"Next:\n  {COMMAND} calibrate {folder}/tracer.toml --machine {folder}/cmm.toml --nodes\n  {COMMAND} place gaska2014"
    )
    return 0
