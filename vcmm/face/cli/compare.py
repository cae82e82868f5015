"""vcmm compare: simulation against recording for any machine files, side by side."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from vcmm.face.cli.options import Seed


def compare_command(
    recordings: list[Path],
    *,
    machine: Annotated[list[Path] | None, Parameter(name="--machine", negative=())] = None,
    seed: Seed = 0,
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
) -> int:
    """Show what each machine file leaves of the recordings: rows as they are, nuisance refitted, nothing clipped or named.

    Parameters
    ----------
    recordings
        Recording files (recording/1), one or several; or the tables (CSV) that they name.
    machine
        A machine file to compare; may be repeated. The recording's own machine stands first.
    seed
        Seed of the simulated noise behind the p values.
    json
        Print one JSON document.
    out
        Folder for report.html and compare.json.
    """

    from vcmm.face.comparing import compare_files
    from vcmm.files.own.recording import recording_file
    from vcmm.learn.diagnosis.comparison import comparison_json
    from vcmm.show.console.documents import document, json_text, print_json
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import say, say_warnings

    folder = output_folder(out) if out else None
    rows, warnings, files = compare_files([recording_file(path) for path in recordings], machine or (), seed)
    content = document("vcmm.compare/1", comparison_json(rows), seed=seed, files=files, warnings=warnings)
    if folder:
        from vcmm.show.pages.compare import compare_page

        text = json_text(content)
        write_files(folder, {"compare.json": text, "report.html": compare_page(rows)})
        say(f"wrote {folder}/compare.json, report.html")
    if json:
        print_json(content)
        return 0
    _show(rows)
    say_warnings(warnings)
    return 0


def _show(rows: list[Any]) -> None:
    from vcmm.show.console.terminal import show_answers, show_table
    from vcmm.show.tables.answers import compare_answers
    from vcmm.show.tables.comparison import short_names, tables

    show_answers(compare_answers(rows, short_names([c.file for c in rows])))
    for table in tables(rows):
        show_table(table)
