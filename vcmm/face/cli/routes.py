"""vcmm routes: the same task by independent routes, and whether they agree."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from vcmm.face.cli.options import Evidence


def routes_command(
    scenario: Path,
    *,
    calibrated: Path | None = None,
    repeats: Path | None = None,
    positions: Path | None = None,
    standards: Path | None = None,
    values: Path | None = None,
    trials: int | None = None,
    seed: int | None = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
    evidence: Evidence = None,
) -> int:
    """The same task by independent routes: virtual CMM, calibrated part (ISO 15530-3), several positions; E_n between them.

    Without measured data all of it is measured on a machine and parts that are drawn and hidden from the routes.
    Exit code 1 when two routes do not agree.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1).
    calibrated
        Certificate of a calibrated part: characteristic,value_mm,U_um,k.
    repeats
        What you measured of it, again and again: characteristic,value_mm (temp_part_C).
    positions
        The part itself in several positions: position,characteristic,value_mm.
    standards
        Standards for --positions: standard (length, centres, ring, sphere),calibrated_mm,U_um,k,reading_mm.
    values
        The part itself, measured once: characteristic,value_mm.
    trials
        Monte Carlo trials (default: the scenario's).
    seed
        Seed of the random streams and of the drawn machine (default: the scenario's).
    json
        Print one JSON document.
    out
        Folder for report.html, routes.json, routes.csv.
    evidence
        Zip with all files, versions, seed, influences covered and the document; `vcmm rerun` runs it again and compares.
    """
    files = {
        "calibrated": calibrated, "repeats": repeats, "positions": positions, "standards": standards, "values": values,
    }  # fmt: skip
    changes = {k: v for k, v in (("seed", seed), ("trials", trials)) if v is not None}
    return _run(scenario, files, changes, json, (out, evidence))


def _run(
    scenario: Path,
    files: dict[str, Path | None],
    changes: dict[str, Any],
    json: bool,
    written: tuple[Path | None, Path | None],
) -> int:

    from vcmm.answer.routes.job import routes
    from vcmm.face.cli.options import keep_evidence
    from vcmm.files.own.routes import read_route_data
    from vcmm.files.own.scenario import load_scenario
    from vcmm.show.console.complaints import about
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.files import output_folder
    from vcmm.show.console.terminal import progress
    from vcmm.show.tables.routes import routes_json

    out, evidence = written
    folder = output_folder(out) if out else None
    loaded = load_scenario(scenario)
    given = [f for f in files.values() if f is not None]
    data = read_route_data(loaded, **files) if given else None
    with progress() as report, about(scenario):
        found = routes(loaded, data, settings=loaded.settings.asked(**changes), progress=report)
    content = document(
        "vcmm.routes/1", routes_json(found), seed=found.seed, files=[*sources(scenario), *given], warnings=found.remarks
    )  # fmt: skip
    if evidence:
        keep_evidence(evidence, ("routes", scenario, files | changes), loaded.task(), content)
    if folder:
        _write(folder, loaded, found, content)
    if json:
        print_json(content)
    else:
        _show(found)
    return int(not found.agree)


def _show(found: Any) -> None:
    from vcmm.show.console.terminal import say_warnings, show_answers, show_table
    from vcmm.show.tables.answers import routes_answers
    from vcmm.show.tables.routes import agreements_table, routes_table

    show_answers(routes_answers(found))
    show_table(routes_table(found))
    show_table(agreements_table(found))
    said = [f"{c.name}, {e.route}: {t}" for c in found.characteristics for e in c.routes for t in e.remarks]
    say_warnings(dict.fromkeys((*found.remarks, *said)))


def _write(folder: Path, scenario: Any, found: Any, content: dict[str, Any]) -> None:
    from vcmm.show.console.documents import json_text
    from vcmm.show.console.files import write_files
    from vcmm.show.console.terminal import say
    from vcmm.show.pages.routes import routes_page
    from vcmm.show.tables.routes import contributions_table
    from vcmm.show.tables.table import csv_text

    texts = {
        "report.html": routes_page(scenario, found), "routes.json": json_text(content),
        "routes.csv": csv_text(contributions_table(found)),
    }  # fmt: skip
    write_files(folder, texts)
    say(f"wrote {', '.join(f'{folder}/{name}' for name in texts)}")
