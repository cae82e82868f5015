"""vcmm measure: one virtual measurement, of a part that is given or is cut first."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter

from vcmm.face.cli.options import Seed


def measure_command(
    scenario: Path,
    *,
    seed: Seed | None = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
) -> int:
    """Measure the part once, virtually: errors at their estimates, or one draw with --seed.

    With a [cut] table the part is cut first, by the same draw of its machine tool, and then inspected.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1).
    seed
        Draw everything that is uncertain once with this seed; without it all errors are at their estimates.
    json
        Print one JSON document.
    out
        Folder for measure.json and points.csv.
    """
    from vcmm.face.api import measure
    from vcmm.files.own.cut_scenario import load_cut
    from vcmm.files.own.library import cuts
    from vcmm.files.own.scenario import load_scenario
    from vcmm.show.console.complaints import about
    from vcmm.show.console.documents import document, json_text, print_json, sources
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import say, show_answers, show_table
    from vcmm.show.tables.answers_parts import measured_answers
    from vcmm.show.tables.measured_points import measure_json, points_csv, values

    folder = output_folder(out) if out else None
    loaded = load_cut(scenario) if cuts(scenario) else load_scenario(scenario)
    with about(scenario):
        measured = measure(loaded, seed)
    content = document(
        "vcmm.measure/1",
        measure_json(measured),
        seed=seed,
        files=sources(scenario),
        warnings=measured.warnings,
    )
    if folder:
        write_files(folder, {"measure.json": json_text(content), "points.csv": points_csv(measured)})
        say(f"wrote {folder}/measure.json, points.csv")
    if json:
        print_json(content)
    else:
        show_answers(measured_answers(measured))
        show_table(values(measured))
    return 0
