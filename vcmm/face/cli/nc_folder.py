"""vcmm nc FOLDER: every program of a folder, its result, and why."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from vcmm.core.errors import DataError, UsageError, VcmmError
from vcmm.face.job import Job, Progress, Record
from vcmm.program.interpret import read_program
from vcmm.program.reading import likely
from vcmm.program.search import ENDINGS
from vcmm.program.setup import Setup
from vcmm.show.console.terminal import show_table
from vcmm.show.tables import program as tables
from vcmm.show.tables.program import FolderRow
from vcmm.show.tables.table import csv_text, records

FURTHER = (".i", ".arc", ".ptp", ".pim", ".iso", ".din", ".fan", ".cls", ".anc", ".dnc", ".g", ".ncc")


@dataclass(frozen=True)
class NcFolderJob(Job[list[Path], list[FolderRow]]):
    """Every program of a folder. Exit code 0: refused programs are part of the answer, no failure. quiet: --json was given."""

    folder: Path
    dialect: str | None
    setup: Setup
    quiet: bool
    schema = "vcmm.nc/1"

    def load(self) -> list[Path]:
        return programs_in(self.folder)

    def run(self, loaded: list[Path], report: Progress) -> list[FolderRow]:
        rows = []
        for k, path in enumerate(loaded):
            report(path.name, k / len(loaded))
            rows.append(row_of(path, self.folder, self.dialect, self.setup))
        return rows

    def record(self, loaded: list[Path], result: list[FolderRow]) -> Record:
        return Record({"programs": records(tables.FOLDER, result)}, loaded)

    def texts(
        self, loaded: list[Path], result: list[FolderRow], content: str, folder: Path
    ) -> dict[str, str]:
        from vcmm.show.pages.program import folder_page

        name = self.folder.name
        table = csv_text(tables.folder(name, result))
        return {"programs.csv": table, "programs.html": folder_page(name, result)}

    def files_sentence(
        self, loaded: list[Path], result: list[FolderRow], folder: Path, names: Sequence[str]
    ) -> str:
        return "" if self.quiet else f"wrote {', '.join(str(folder / name) for name in names)}"

    def show(self, loaded: list[Path], result: list[FolderRow]) -> None:
        show_table(tables.folder(self.folder.name, result))
        show_table(tables.folder_counts(result))
        if any(row.reason for row in result):
            show_table(tables.folder_reasons(result))


def programs_in(folder: Path) -> list[Path]:
    """Return the files whose name ends as those of programs do, in this folder and below it. Raises UsageError where there is none."""
    endings = {*ENDINGS, *FURTHER} - {""}
    programs = sorted(p for p in folder.rglob("*") if p.is_file() and p.suffix.lower() in endings)
    if not programs:
        raise UsageError(
            f"{folder} holds no NC program: no file ends in {', '.join(sorted(endings))}; name another folder, or the file itself"
        )
    return programs


def row_of(path: Path, folder: Path, dialect: str | None, setup: Setup) -> FolderRow:
    """Return the row of one program. One that cannot be read becomes a reason, so that the others are read nevertheless."""
    name = str(path.relative_to(folder))
    try:
        read = read_program(path, dialect, setup)
    except VcmmError as error:
        problems = error.problems if isinstance(error, DataError) else [str(error)]
        reason = problems[0].replace(str(path), name)
        return FolderRow(name, dialect or likely(path), 2, 0, 0, reason)
    return FolderRow(name, read.dialect, 0, len(read.moves), len(read.assumed), "")
