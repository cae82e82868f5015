"""vcmm demo: a ring gauge, then the Gaska 2014 twin; the others are in vcmm.face.cli.twins."""

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
    ] = "gaska2014",
    draws: Annotated[int | None, Parameter(validator=Number(gte=1, lte=10**6))] = None,
    trials: Annotated[int, Parameter(validator=Number(gte=1000, lte=10**9))] = 20_000,
    json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:
    """Virtually measure a ring gauge, then a compressor body at five places of a CMM and say how well (Gaska et al. 2014).

    The other twins mill a part virtually: abbe_milling (spline slots, arms of the rotations), marin2004 (chain, warm-up,
    rewritten program), test_piece (which error shows in which feature). worn_cmm diagnoses a log with concealed faults, xcz_lathe
    measures a flat on a lathe and takes the lathe's errors off.

    Parameters
    ----------
    out
        Folder for report.html, demo.json and, for gaska2014, demo.csv and the lengths of its LaserTracer.
    twin
        Published job to run.
    draws
        Machines drawn for the ranges (gaska2014: 200 that agree with the published figures; abbe_milling: 100).
    trials
        Monte Carlo trials per place (gaska2014).
    json
        Print one JSON document.
    """
    if twin != "gaska2014":
        from vcmm.face.cli.twins import twin_command

        return twin_command(twin, out, draws, json, _command())
    return _gaska(out, 200 if draws is None else draws, trials, json)


def _gaska(out: Path, draws: int, trials: int, json: bool) -> int:
    from vcmm.face import api
    from vcmm.face.twins import twin as load_twin
    from vcmm.files.own.library import example
    from vcmm.files.own.scenario import load_scenario
    from vcmm.show.console.documents import document, json_text, print_json
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import progress, say, show_table
    from vcmm.show.pages.first import first_blocks, sentences
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
    print("\n".join(sentences(plain, first.characteristics[0])) + "\n")
    for table in gaska.page.tables(result):
        show_table(table)
    say(f"wrote {folder}/{', '.join(texts)}")
    me = _command()
    print(
        f"Next:\n  open {folder}/report.html\n  {me} calibrate {folder}/tracer.toml --machine {folder}/cmm.toml --nodes\n  {me} new ring_gauge\n  {me} uncertainty ring_gauge.toml --out ring_gauge-report"
    )
    return 0


def _command() -> str:
    """How this user calls vcmm: by name when it is on the path, else by the path that was just used."""
    import os
    import shutil
    import sys

    return "vcmm" if shutil.which("vcmm") else os.path.relpath(sys.argv[0])
