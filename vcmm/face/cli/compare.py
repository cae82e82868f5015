"""vcmm compare: simulation against recording for any machine files, side by side."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NamedTuple

from cyclopts import Parameter

from vcmm.face.cli.options import InputFile, Json, Seed
from vcmm.face.comparing import compare_files
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.files.own.recording import recording_file
from vcmm.learn.diagnosis.comparison import Comparison, comparison_json
from vcmm.show.console.terminal import say_warnings, show_answers, show_table
from vcmm.show.tables.answers import compare_answers
from vcmm.show.tables.comparison import short_names, tables


def compare_command(
    recordings: list[InputFile],
    *,
    machine: Annotated[list[InputFile] | None, Parameter(name="--machine", negative=())] = None,
    seed: Seed = 0,
    json: Json = False,
    out: Path | None = None,
) -> int:
    """Show what each machine file leaves of the recordings: rows as they are, nuisance refitted, nothing clipped or named.

    Parameters
    ----------
    recordings
        Recording files (recording/1), one or several; or the tables (CSV) that they name.
    machine
        A machine file to compare; may be repeated. The recording's own machine is listed first.
    seed
        Seed of the simulated noise behind the p values.
    json
        Print one JSON document.
    out
        Folder for report.html and compare.json.
    """
    return run_job(CompareJob(recordings, machine or [], seed), Flags(json, out))


class ComparedMachines(NamedTuple):
    """A row for each machine file, omitted data in words, and all files that were read."""

    rows: list[Comparison]
    warnings: list[str]
    files: list[Path]


@dataclass(frozen=True)
class CompareJob(Job[list[Path], ComparedMachines]):
    """Residuals of recordings under machine files. Files are read by the comparison, for each machine anew."""

    recordings: list[Path]
    machines: list[Path]
    seed: int
    schema = "vcmm.compare/1"

    def load(self) -> list[Path]:
        return [recording_file(path) for path in self.recordings]

    def run(self, loaded: list[Path], report: Progress) -> ComparedMachines:
        return ComparedMachines(*compare_files(loaded, self.machines, self.seed))

    def record(self, loaded: list[Path], result: ComparedMachines) -> Record:
        return Record(comparison_json(result.rows), result.files, self.seed, result.warnings)

    def texts(
        self, loaded: list[Path], result: ComparedMachines, content: str, folder: Path
    ) -> dict[str, str]:
        from vcmm.show.pages.compare import compare_page

        return {"compare.json": content, "report.html": compare_page(result.rows)}

    def show(self, loaded: list[Path], result: ComparedMachines) -> None:
        show_answers(compare_answers(result.rows, short_names([c.file for c in result.rows])))
        for table in tables(result.rows):
            show_table(table)
        say_warnings(result.warnings)
