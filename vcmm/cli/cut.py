"""vcmm cut: machine the part virtually; deviations of its features, U, decision, who owns the error, cycle time."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter


def cut_command(
    scenario: Path,
    *,
    trials: int | None = None,
    seed: int | None = None,
    engine: Literal["auto", "montecarlo", "exact"] = "auto",
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
) -> int:
    """Machine a part virtually: program, machine, tools and set-up to the deviations of its features.

    Exit code 1 when a characteristic does not conform.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1) with a [cut] table.
    trials
        Monte Carlo trials (default: the scenario's, else 10^6).
    seed
        Seed of the random streams (default: the scenario's, else 0).
    json
        Print one JSON document.
    engine
        As in `vcmm uncertainty`; exact: transforms multiplied and the deepest of the candidates taken in every trial.
    out
        Folder for report.html, cut.json, surface.csv and, where the set-up states a stock, stock.stl.
    """
    from vcmm.console.complaints import about
    from vcmm.console.documents import document, print_json, sources
    from vcmm.console.files import output_folder
    from vcmm.console.terminal import progress
    from vcmm.files.cut_scenario import load_cut
    from vcmm.machining.job import cut
    from vcmm.tables.cut import cut_json

    folder = output_folder(out) if out else None
    loaded = load_cut(scenario)
    with progress() as report, about(scenario, "cut"):
        found = cut(loaded, seed=seed, trials=trials, engine=engine, progress=report)
    files = [*sources(scenario), loaded.program]
    content = document(
        "vcmm.cut/1", cut_json(found), seed=found.uncertainty.seed, files=files, warnings=found.warnings
    )
    if folder:
        _write(folder, loaded, found, content)
    if json:
        print_json(content)
    else:
        show(found)
    return (
        1 if any(c.decision and c.decision.text == "does not conform" for c in found.characteristics) else 0
    )


def show(found: Any) -> None:
    """Deviations, who owns them, what a batch shares, the surface."""
    from vcmm.console.terminal import say, show_table
    from vcmm.tables import cut as tables

    show_table(tables.finished_part(found))
    for table in (tables.owners(found), tables.largest_contributions(found), tables.batch(found)):
        show_table(table)
    s = found.surface
    minutes, seconds = divmod(found.seconds, 60)
    print(
        f"surface: largest departure {s.max_um:.2f} um, rms {s.rms_um:.2f} um over {s.points} points of the nets on all "
        f"features; of these {s.uncut} uncut, {s.gouges} gouged by the program itself (deeper than {s.deep_um:g} um)\n"
        f"{_recut_text(found.recut)}"
        f"cycle time: {minutes:.0f} min {seconds:.1f} s"
    )
    if found.blank is not None:
        print(
            f"stock ({found.blank.kept_as}): {found.blank.removed / 1e3:.1f} cm³ removed, "
            f"{len(found.blank.collisions)} rapids through material"
        )
    for warning in found.warnings:
        say(f"note: {warning}")


def _recut_text(found: Any) -> str:
    if found is None:
        return ""
    return f"cut again with the tools really displaced: {found.points} points differ from the result by {found.largest * 1e3:.3f} um at most\n"


def _write(folder: Path, scenario: Any, found: Any, content: dict[str, Any]) -> None:
    from vcmm.console.documents import json_text
    from vcmm.console.files import write_files
    from vcmm.console.terminal import say
    from vcmm.pages.cut import cut_page
    from vcmm.tables.cut import surface_csv

    texts = {
        "cut.json": json_text(content),
        "surface.csv": surface_csv(found),
        "report.html": cut_page(scenario, found),
    }
    write_files(folder, texts)
    if found.blank is not None:
        from vcmm.cutting.solid import write_stl
        from vcmm.machining.turned_blank import TurnedBlank, write_turned_stl

        if isinstance(found.blank, TurnedBlank):
            write_turned_stl(found.blank.after, folder / "stock.stl")
        else:
            write_stl(found.blank.after, folder / "stock.stl")
    say(f"wrote {folder}/report.html, cut.json, surface.csv{', stock.stl' if found.blank else ''}")
