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

    from vcmm.files.own.machine import load_machine
    from vcmm.files.own.recording import recording_file
    from vcmm.learn.diagnosis.comparison import comparison_json
    from vcmm.show.console.documents import document, json_text, print_json, sources
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import say, say_warnings

    folder = output_folder(out) if out else None
    recordings = [recording_file(path) for path in recordings]
    others = [(file, load_machine(file)) for file in machine or ()]
    rows = [_compare(recordings, None, None, seed)]
    rows += [_compare(recordings, file, known, seed) for file, known in others]
    inputs = [p for recording in recordings for p in sources(recording)]
    inputs += [p for file in machine or () for p in sources(file)]
    warnings, files = _left_out(rows), list(dict.fromkeys(inputs))
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


def _compare(recordings: list[Path], file: Path | None, machine: Any, seed: int) -> Any:
    """One machine (None: the one that each recording names) against all recordings."""
    from dataclasses import replace

    from vcmm.files.own.recording import load_recording
    from vcmm.learn.diagnosis.comparison import compare_machines
    from vcmm.show.console.complaints import about

    pairs = []
    for path in recordings:
        recording, known = load_recording(path, machine, gaps=True)
        pairs.append((replace(recording, name=str(path)) if len(recordings) > 1 else recording, known))
    with about(recordings[0]):
        return compare_machines(str(file) if file else _machine_name(recordings), pairs, seed)


def _left_out(rows: list[Any]) -> list[str]:
    """What of the recordings was set aside, and what they have no columns for, in words."""
    aside = dict.fromkeys(note for row in rows for part in row.parts for note in part.recording.notes)
    return [*aside] + [
        f"{row.file}: {name} is not predicted, the recording lacks a column that it needs"
        for row in rows
        for name in sorted({n for part in row.parts for n in part.left_out})
    ]


def _machine_name(recordings: list[Path]) -> str:
    """Name of the machine file that the recordings name."""
    from vcmm.files.toml import read_toml

    named = [read_toml(path).data.get("machine") for path in recordings]
    beside = [str(p.parent / n) if isinstance(n, str) else str(p) for p, n in zip(recordings, named)]
    return ", ".join(dict.fromkeys(beside))


def _show(rows: list[Any]) -> None:
    from vcmm.show.console.terminal import show_answers, show_table
    from vcmm.show.tables.answers import compare_answers
    from vcmm.show.tables.comparison import short_names, tables

    show_answers(compare_answers(rows, short_names([c.file for c in rows])))
    for table in tables(rows):
        show_table(table)
