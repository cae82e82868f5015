"""vcmm test: figures of acceptance tests, predicted for a machine or evaluated from a recording."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, NamedTuple

from cyclopts import Parameter
from cyclopts.validators import Number

from vcmm.core.errors import UsageError
from vcmm.face.acceptance import find_figures, table_of_figures
from vcmm.face.cli.options import InputFile, Json, Seed
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.files.toml import read_toml
from vcmm.learn.calibration.acceptance import Figure
from vcmm.show.console.documents import sources
from vcmm.show.console.files import output_folder, write_text
from vcmm.show.console.terminal import say, show_answers, show_table
from vcmm.show.tables.answers_runs import acceptance_answers
from vcmm.show.tables.calibration import figure_columns
from vcmm.show.tables.table import records

DrawsOption = Annotated[
    int, Parameter(validator=Number(gte=40, lte=10**6))
]  # 40: one draw in either tail of 2.5 %


def test_command(
    file: InputFile,
    *more: InputFile,
    iso: str,
    limit: Annotated[list[str] | None, Parameter(name="--limit", negative=())] = None,
    seed: Seed = 0,
    trials: DrawsOption = 1000,
    report: Path | None = None, json: Json = False, out: Path | None = None,
) -> int:  # fmt: skip
    """Predict the figures of an acceptance test with uncertainty, or evaluate a recorded one.

    Exit code 1: a figure is more likely outside a stated --limit than within.

    Parameters
    ----------
    file
        Machine file (machine/1), or a scenario with its machine: predict. Recording file (recording/1): evaluate what was recorded (230-7: with [reversal]).
    more
        Further recordings of the same test: axes, planes, diagonals.
    iso
        The test: 230-2, 230-4, 230-6, 230-7 or 10360-2.
    limit
        A limit: "A = 8 um", "B X = 2 um", "E0 = 1.9 um + L/300" (L in mm gives um), "synchronous tilt B = 1 urad"; may be repeated.
    seed
        Seed of the drawn machines.
    trials
        Number of drawn machines.
    report
        File for the HTML report of recorded tests of 230-2 and 230-4: band charts, or traces of circles.
    json
        Print one JSON document.
    out
        Folder for test.json.
    """
    job = AcceptanceJob((file, *more), iso, tuple(limit or ()), seed, trials, report)
    return run_job(job, Flags(json, out))


class Figures(NamedTuple):
    """The figures of a test; from_certificate: the errors of the machine are sampled from its certificate."""

    figures: Sequence[Figure]
    warnings: list[str]
    from_certificate: bool


@dataclass(frozen=True)
class AcceptanceJob(Job[tuple[Path, ...], Figures]):
    """The figures of an acceptance test, predicted or evaluated, as its files are."""

    files: tuple[Path, ...]
    iso: str
    limits: tuple[str, ...]
    seed: int
    trials: int
    report: Path | None
    schema = "vcmm.test/1"

    def check(self) -> None:
        """Raise UsageError where --report has nothing to draw."""
        if self.report is None:
            return
        if self.iso not in ("230-2", "230-4") or not self.is_recorded():
            raise UsageError(
                "--report draws recorded tests of ISO 230-2 and 230-4; leave it out, or give recordings of them"
            )

    def is_recorded(self) -> bool:
        """Return whether every file is a recording, no machine."""
        return all(str(read_toml(f).data.get("vcmm", "")).startswith("recording/") for f in self.files)

    def load(self) -> tuple[Path, ...]:
        return self.files

    def run(self, loaded: tuple[Path, ...], report: Progress) -> Figures:
        return Figures(*find_figures(loaded, self.iso, self.limits, self.seed, self.trials))

    def record(self, loaded: tuple[Path, ...], result: Figures) -> Record:
        body = {"test": f"ISO {self.iso}", "figures": records(figure_columns(self.iso), result.figures)}
        return Record(body, [f for test in loaded for f in sources(test)], self.seed, result.warnings)

    def texts(self, loaded: tuple[Path, ...], result: Figures, content: str, folder: Path) -> dict[str, str]:
        return {"test.json": content}

    def export(self, loaded: tuple[Path, ...], result: Figures, content: dict[str, object]) -> None:
        """Write the page of --report."""
        if self.report is None:
            return
        from vcmm.files.own.recording import load_recording
        from vcmm.learn.calibration.deviations import RecordedTest
        from vcmm.show.pages.acceptance import acceptance_page

        output_folder(self.report.parent)
        tests = [RecordedTest(*load_recording(f)) for f in loaded]
        write_text(self.report, acceptance_page(tests, self.iso, result.figures, result.warnings))
        say(f"wrote {self.report}")

    def exit_code(self, loaded: tuple[Path, ...], result: Figures) -> int:
        failed = any(f.p_pass is not None and f.p_pass < 0.5 for f in result.figures)
        return int(failed and not result.from_certificate)

    def show(self, loaded: tuple[Path, ...], result: Figures) -> None:
        if self.iso != "230-7":  # whose table is no longer than an answer
            show_answers(acceptance_answers(result.figures, self.is_recorded()))
        show_table(table_of_figures(self.iso, result.figures))
        for warning in result.warnings:
            print(f"note: {warning}")
