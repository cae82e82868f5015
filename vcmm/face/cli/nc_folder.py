"""vcmm nc FOLDER: every program of a folder, what became of it, and why."""

from __future__ import annotations

from pathlib import Path
from typing import Any

FURTHER = (".i", ".arc", ".ptp", ".pim", ".iso", ".din", ".fan", ".cls", ".anc", ".dnc", ".g", ".ncc")


def programs_in(folder: Path) -> list[Path]:
    """Files whose name ends as those of programs do, in this folder and below it. Raises UsageError where there is none."""
    from vcmm.core.errors import UsageError
    from vcmm.program.search import ENDINGS

    endings = {*ENDINGS, *FURTHER} - {""}
    found = sorted(p for p in folder.rglob("*") if p.is_file() and p.suffix.lower() in endings)
    if not found:
        raise UsageError(
            f"{folder} holds no NC program: no file ends in {', '.join(sorted(endings))}; name another folder, or the file itself"
        )
    return found


def folder_job(folder: Path, dialect: str | None, setup: Any, json: bool, out: Path | None) -> int:
    """The table as text, JSON, CSV and page; exit code 0: that some are refused is the answer, not a failure."""
    from vcmm.show.console.documents import document, print_json
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import progress, say, show_table
    from vcmm.show.tables import program as tables
    from vcmm.show.tables.table import csv_text, records

    files = programs_in(folder)
    if out is not None:
        output_folder(out)
    rows = []
    with progress(not json) as bar:
        for k, path in enumerate(files):
            bar(path.name, k / len(files))
            rows.append(row_of(path, folder, dialect, setup))
    table = tables.folder(folder.name, rows)
    if out is not None:
        from vcmm.show.pages.program import folder_page

        written = write_files(
            out, {"programs.csv": csv_text(table), "programs.html": folder_page(folder.name, rows)}
        )
        if not json:
            say(f"wrote {', '.join(str(p) for p in written)}")
    if json:
        print_json(document("vcmm.nc/1", {}, files=files) | {"programs": records(tables.FOLDER, rows)})
        return 0
    show_table(table)
    show_table(tables.folder_counts(rows))
    if any(row.reason for row in rows):
        show_table(tables.folder_reasons(rows))
    return 0


def row_of(path: Path, folder: Path, dialect: str | None, setup: Any) -> Any:
    """One program. What cannot be read becomes a reason, so that the others are read all the same."""
    from vcmm.core.errors import DataError, VcmmError
    from vcmm.program.interpret import read_program
    from vcmm.program.reading import likely
    from vcmm.show.tables.program import FolderRow

    name = str(path.relative_to(folder))
    try:
        read = read_program(path, dialect, setup)
    except VcmmError as error:
        problems = error.problems if isinstance(error, DataError) else [str(error)]
        reason = problems[0].replace(str(path), name)
        return FolderRow(name, dialect or likely(path), 2, 0, 0, reason)
    return FolderRow(name, read.dialect, 0, len(read.moves), len(read.assumed), "")
