"""vcmm demo: the Gaska 2014 twin, the main job on published input."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter


def demo_command(
    *,
    out: Path = Path("vcmm-demo"),
    twin: Literal[
        "gaska2014", "abbe_milling", "echerfaoui2017", "marin2004", "test_piece", "worn_cmm", "xcz_lathe"
    ] = "gaska2014",
    draws: int | None = None,
    trials: int = 50_000,
    json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:
    """Virtually measure a ring gauge, then a compressor body at five places of a CMM, and say how well (Gaska et al. 2014).

    The other twins mill a part virtually: abbe_milling (spline slots, arms of the rotations), marin2004 (chain, warm-up,
    rewritten program), test_piece (which error shows in which feature). worn_cmm diagnoses a log with concealed faults, xcz_lathe
    measures a flat on a lathe and takes the lathe's errors off.

    Parameters
    ----------
    out
        Folder for report.html, demo.json and, for gaska2014, demo.csv.
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
        from vcmm.cli.twins import twin_command

        return twin_command(twin, out, draws, json, _command())
    return _gaska(out, 200 if draws is None else draws, trials, json)


def _gaska(out: Path, draws: int, trials: int, json: bool) -> int:
    from vcmm import api
    from vcmm.console.documents import document, json_text, print_json
    from vcmm.console.files import output_folder, write_files
    from vcmm.console.terminal import progress, say, show_table
    from vcmm.files.scenario import load_scenario
    from vcmm.library import path
    from vcmm.pages.first import first_blocks, sentences
    from vcmm.papers.gaska2014 import twin as gaska2014
    from vcmm.papers.gaska2014.page import demo_page, table
    from vcmm.tables.evaluated import characteristic_json
    from vcmm.tables.table import csv_text

    folder = output_folder(out)
    source, ring = path("gaska2014"), path("ring_gauge")
    scenario, plain = load_scenario(source), load_scenario(ring)
    with progress() as report:
        first = api.uncertainty(plain, progress=report)
        rows = gaska2014.run(scenario, draws, trials, report)
    shown = next(r for r in rows if r.place == "3" and r.redraw == "touch")
    body = {"first": characteristic_json(first.characteristics[0]), **demo_json(rows, draws)}
    content = document("vcmm.demo/1", body, seed=scenario.settings.seed, files=[ring, source])
    shown_table = table(rows, draws)
    texts = {
        "demo.json": json_text(content),
        "demo.csv": csv_text(shown_table),
        "report.html": demo_page(scenario, rows, draws, shown.result, first_blocks(plain, first)),
    }
    write_files(folder, texts)
    if json:
        print_json(content)
        return 0
    print("\n".join(sentences(plain, first.characteristics[0])) + "\n")
    show_table(shown_table)
    say(f"wrote {folder}/report.html, demo.json, demo.csv")
    me = _command()
    print(
        f"Next:\n  open {folder}/report.html\n  {me} new ring_gauge\n  {me} uncertainty ring_gauge.toml --out ring_gauge-report"
    )
    return 0


def _command() -> str:
    """How this user calls vcmm: by name when it is on the path, else by the path that was just used."""
    import os
    import shutil
    import sys

    return "vcmm" if shutil.which("vcmm") else os.path.relpath(sys.argv[0])


def demo_json(rows: Any, draws: int) -> dict[str, Any]:
    """The body of the JSON document."""
    from vcmm.papers.gaska2014.twin import PAPER_DISTANCE_U, PAPER_FORM_U
    from vcmm.tables.evaluated import characteristic_json

    return {
        "draws": draws,
        "rows": [
            {
                "place": r.place, "redraw": r.redraw,
                "form": characteristic_json(r.form), "form_U_range_mm": list(r.form_range), "paper_form_U_mm": PAPER_FORM_U[r.place] * 1e-3,
                "distance": characteristic_json(r.distance), "distance_U_range_mm": list(r.distance_range),
                "paper_distance_U_mm": PAPER_DISTANCE_U[r.place] * 1e-3,
            }
            for r in rows
        ],
    }  # fmt: skip
