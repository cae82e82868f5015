"""vcmm evaluate: measured points or values in; true values, decisions and budgets out."""

from __future__ import annotations

from collections.abc import Collection
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from vcmm.face.cli.options import Evidence, Require


def evaluate_command(
    scenario: Path,
    *,
    points: Path | None = None,
    values: Path | None = None,
    frame: Literal["part", "machine"] = "part",
    tip_centres: Annotated[bool, Parameter(name="--tip-centres", negative=())] = False,
    trials: int | None = None,
    seed: int | None = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
    export: Path | None = None,
    evidence: Evidence = None,
    compare: Annotated[bool, Parameter(name="--compare", negative=())] = False,
    cut: Path | None = None,
    require: Require = None,
) -> int:
    """Evaluate what was measured: values, intervals of the true values, decisions, budgets. Exit code 1: one does not conform.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1): machine, part, plan, what is known.
    points
        Measured points: feature,x_mm,y_mm,z_mm (nx,ny,nz, part, stylus; without feature: in the order of the plan), or a QIF file.
    values
        Measured values: characteristic,value_mm (deviation_um, value_deg; part).
    frame
        Where the points are: part, the drawing frame after alignment; machine, the axes of the machine.
    tip_centres
        The points are centres of the tip, not compensated for its radius.
    trials
        Monte Carlo trials (default: the scenario's).
    seed
        Seed of the random streams (default: the scenario's).
    json
        Print one JSON document.
    out
        Folder for evaluation.json, values.csv, a sheet per part, and of one part report.html and budget.csv.
    export
        File for another system, by its ending: .qif (QIF 3.0 with combinedUncertainty), .dfq (Q-DAS), .xml (results of a DCC).
    evidence
        Zip with all files, versions, seed, influences covered and the document; `vcmm rerun` runs it again and compares.
    compare
        Say also where the part departs from what was predicted when it was cut; the scenario holds [cut], or --cut names it.
    cut
        With --compare, of a scenario of the measurement: the scenario with the table [cut].
    require
        conforms: exit code 1 also where a characteristic is undecided, not only where one does not conform.
    """
    options = {
        "points": points, "values": values, "frame": None if values and frame == "part" else frame, "tip_centres": tip_centres,
        "trials": trials, "seed": seed,
    }  # fmt: skip
    places = Places(out, export, evidence, require)
    if compare or cut:
        from vcmm.face.cli.evaluate_compare import compare_with_cut

        return compare_with_cut(scenario, cut, options, json, places)
    return _run(scenario, options, json, places)


@dataclass(frozen=True)
class Places:
    """Where results go: a folder, a file for another system, a pack of evidence; and what is required of them."""

    out: Path | None
    export: Path | None
    evidence: Path | None
    require: str | None = None


def _run(scenario: Path, options: dict[str, Any], json: bool, places: Places) -> int:
    from vcmm.face.api import check_inputs, evaluate
    from vcmm.face.cli.evaluated_parts import show_parts
    from vcmm.face.cli.options import keep_evidence
    from vcmm.files.own.scenario import load_scenario
    from vcmm.show.console.complaints import about
    from vcmm.show.console.documents import print_json
    from vcmm.show.console.terminal import progress
    from vcmm.show.tables.evaluation import warnings_of_parts

    # before the scenario is read: no line of it is wrong
    given = options["points"], options["values"], options["frame"] or "part", options["tip_centres"]
    check_inputs(*given)
    folder = _places(places.out, places.export)
    loaded = load_scenario(scenario)
    measured = options["points"] or options["values"]
    with progress() as report, about(scenario):
        parts = evaluate(loaded, **(options | {"frame": options["frame"] or "part"}), progress=report)
    code = _code(parts, places.require)
    content = _document(parts, scenario, measured)
    if places.evidence:
        keep_evidence(places.evidence, ("evaluate", scenario, options), loaded.task(), content)
    if folder:
        _write(folder, loaded, parts, content, (scenario, measured))
    if places.export:
        _hand_over(places.export, loaded, content)
    print_json(content) if json else show_parts(parts, warnings_of_parts(parts))
    return code


def _code(parts: Any, require: str | None) -> int:
    from vcmm.face.cli.options import exit_code

    return exit_code((e.result for p in parts for e in p.characteristics), require)


def _places(out: Path | None, export: Path | None) -> Path | None:
    """The folder, made and writable, and the ending of the file: refused before any work."""
    from vcmm.files.foreign.export import check_ending
    from vcmm.show.console.files import output_folder

    if export:
        check_ending(export)
    return output_folder(out) if out else None


def _hand_over(export: Path, scenario: Any, content: dict[str, Any]) -> None:
    """The file for another system, from the document that is shown."""
    from vcmm.files.foreign.export import export_text
    from vcmm.show.console.files import output_folder, write_text
    from vcmm.show.console.terminal import say

    output_folder(export.parent)
    text, notes = export_text(export, scenario.name or "part", scenario.part, content)
    write_text(export, text)
    for note in notes:
        say(f"note: {note}")
    say(f"wrote {export}")


def _document(parts: Any, scenario: Path, measured: Path | None) -> dict[str, Any]:
    from vcmm.show.console.documents import document, sources
    from vcmm.show.tables.evaluation import evaluate_json, warnings_of_parts

    assert measured is not None
    return document(
        "vcmm.uncertainty/1",
        evaluate_json(parts),
        seed=parts[0].uncertainty.seed,
        files=[*sources(scenario), measured],
        warnings=warnings_of_parts(parts),
    )


def _write(folder: Path, scenario: Any, parts: Any, content: dict[str, Any], files: Any) -> None:
    from dataclasses import replace

    from vcmm.show.console.documents import json_text, sources
    from vcmm.show.console.files import write_files
    from vcmm.show.console.terminal import say
    from vcmm.show.pages.sheet import sheet_page
    from vcmm.show.pages.uncertainty import MEASURED, uncertainty_page
    from vcmm.show.tables.evaluation import values_csv
    from vcmm.show.tables.uncertainty import budget_csv

    texts = {"evaluation.json": json_text(content), "values.csv": values_csv(parts)}
    given = [*sources(files[0]), files[1]]
    if len(parts) == 1:
        whole = replace(
            parts[0].uncertainty,
            characteristics=tuple(e.result for e in parts[0].characteristics),
            warnings=parts[0].warnings,
        )
        texts |= {
            "report.html": uncertainty_page(scenario, whole, given, MEASURED),
            "budget.csv": budget_csv(whole),
        }
    for p in parts:
        texts[_sheet_name(p.part, texts)] = sheet_page(scenario, p, given)
    write_files(folder, texts)
    say(f"wrote {', '.join(f'{folder}/{name}' for name in texts)}")


def _sheet_name(part: str, taken: Collection[str]) -> str:
    """A plain file name for the sheet of a part; numbered where another part has it already (a/b and a?b)."""
    plain = "".join(c if c.isalnum() or c in "-_." else "_" for c in part)
    names = (
        f"sheet{f'-{plain}' if plain else ''}{f'-{n}' if n > 1 else ''}.html"
        for n in range(1, len(taken) + 2)
    )
    held = {name.lower() for name in taken}
    return next(name for name in names if name.lower() not in held)
