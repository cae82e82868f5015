"""vcmm diagnose A B ...: several recordings of one machine, with common effects and those of each recording."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import NamedTuple

from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.face.cli.diagnose_written import (
    WRITTEN,
    diagnosis_texts,
    read_back,
    report_sentences,
    show_diagnosis,
    write_report,
)
from vcmm.face.job import Job, Progress, Record
from vcmm.files.learned.improved_machine import improved_machine
from vcmm.files.learned.renewed_tables import name_tables, renewed_files
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording, machine_of
from vcmm.learn.diagnosis.result import diagnosis_json
from vcmm.learn.diagnosis.result_parts import Attempt
from vcmm.learn.diagnosis.several import Several, diagnose_several, several_json
from vcmm.learn.diagnosis.thinning import limit_observations
from vcmm.learn.diagnosis.written_machine import answers_to_write, tables_to_write
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import say, show_table
from vcmm.show.pages.diagnosis import diagnosis_page
from vcmm.show.tables.several import by_itself, sizes
from vcmm.task.response.recording import Recording


class Recordings(NamedTuple):
    """The recordings with names of their own, their machine, and its file where it has one."""

    recordings: list[Recording]
    machine: Machine
    file: Path | None


class DiagnosedTogether(NamedTuple):
    """Results as of one recording: findings, the machine file with the common effects, the report, the error after the names were found."""

    findings: Several
    machine_files: dict[str, str]
    page: str
    attempt: Attempt


@dataclass(frozen=True)
class DiagnoseSeveralJob(Job[Recordings, DiagnosedTogether]):
    """Recordings of one machine. folder: of --out, where the machine file is written and read again; report: file of --report."""

    recordings: tuple[Path, ...]
    machine: Path | None
    seed: int
    effects: Sequence[type[Effect]]
    report: Path | None
    folder: Path | None
    schema, names_files_last = "vcmm.diagnosis/1", True

    @property
    def place(self) -> tuple[Path, str]:
        return self.recordings[0], ""

    def load(self) -> Recordings:
        return read_all(self.recordings, self.machine)

    def run(self, loaded: Recordings, report: Progress) -> DiagnosedTogether:
        machine, original = loaded.machine, loaded.file
        several = diagnose_several(
            loaded.recordings, machine, seed=self.seed, extra_effects=self.effects, progress=report
        )
        attempt = Attempt.none()
        improved: dict[str, str] = {}
        if folder := self.folder:
            improved = attempt(WRITTEN, lambda: _common(several, machine, original, folder), {})
            together, improved = read_back(folder, improved, self.recordings, several.together, attempt)
            several = replace(several, together=together)
        page = ""
        if self.folder or self.report:
            page = attempt("draw the report", lambda: _page(several, machine), "")
        failed = (*several.together.failures, *attempt.failures)
        several = replace(several, together=replace(several.together, failures=failed))
        return DiagnosedTogether(several, improved, page, attempt)

    def record(self, loaded: Recordings, result: DiagnosedTogether) -> Record:
        several = result.findings
        inputs = [p for f in self.recordings for p in sources(f)] + ([self.machine] if self.machine else [])
        body = _body(several, self.folder if result.machine_files else None)
        warnings = (*several.together.warnings, *left_out(several))
        return Record(body, list(dict.fromkeys(inputs)), self.seed, warnings)

    def texts(
        self, loaded: Recordings, result: DiagnosedTogether, content: str, folder: Path
    ) -> dict[str, str]:
        return diagnosis_texts(content, result.page, result.machine_files)

    def export(self, loaded: Recordings, result: DiagnosedTogether, content: dict[str, object]) -> None:
        write_report(self.report, result.page)

    def show(self, loaded: Recordings, result: DiagnosedTogether) -> None:
        show_diagnosis(result.findings.together)
        _show_each(result.findings)

    def notes(self, loaded: Recordings, result: DiagnosedTogether) -> Iterator[str]:
        return report_sentences(self.report, result.page)

    def finish(self, loaded: Recordings, result: DiagnosedTogether) -> None:
        result.attempt.raise_bugs()


def read_all(files: Sequence[Path], machine: Path | None) -> Recordings:
    """Raises UsageError where they name two machines."""
    if machine is None:
        named = {machine_of(f)[1] for f in files}
        if len(named) > 1:
            who = ", ".join(f"{f}: {machine_of(f)[0] or 'within the file'}" for f in files)
            raise UsageError(
                f"the recordings name machines that differ ({who}); one machine is diagnosed at a time: say which with --machine"
            )
    first, machine_of_file = load_recording(files[0], load_machine(machine) if machine else None, gaps=True)
    recordings = [limit_observations(first)]
    del first
    recordings += [limit_observations(load_recording(f, machine_of_file, gaps=True)[0]) for f in files[1:]]
    if len({r.name for r in recordings}) < len(recordings):
        recordings = [replace(r, name=str(f)) for r, f in zip(recordings, files)]
    return Recordings(recordings, machine_of_file, machine or machine_of(files[0])[0])


def left_out(several: Several) -> list[str]:
    """Return the columns that not all recordings have, in words."""
    return [
        f"the column {column} is missing in {', '.join(who)}, so all recordings are looked at without it"
        for column, who in several.left_out.items()
    ]


def _body(several: Several, folder: Path | None) -> dict[str, object]:
    body = {k: v for k, v in diagnosis_json(several.together).items() if k != "schema"}
    return (
        body | several_json(several) | {"improved_machine": str(folder / "machine.toml") if folder else None}
    )


def _common(several: Several, machine: Machine, original: Path | None, out: Path) -> dict[str, str]:
    """Return machine.toml with the common effects; empty where there is nothing to write."""
    answers, source = several.together.answer, several.recording.name
    new = tables_to_write(answers)
    if original is None or (new is None and not answers_to_write(answers)):
        return {}
    text = improved_machine(original, out / "machine.toml", machine, answers, source)
    if new is None:
        return {"machine.toml": text}
    return {"machine.toml": name_tables(text, source), **renewed_files(original, machine, new, source)}


def _page(several: Several, machine: Machine) -> str:
    return diagnosis_page(several.recording, machine, several.together, several)


def _show_each(several: Several) -> None:
    if several.shared_answers:
        show_table(sizes(several))
    show_table(by_itself(several))
    for text in left_out(several):
        say(f"note: {text}")
