"""Output of every diagnosis: the machine file with the findings, the report, the answer in words."""

from __future__ import annotations

from collections.abc import Iterator, Sequence
from dataclasses import replace
from pathlib import Path

from vcmm.core.machine import Machine
from vcmm.files.learned.improved_machine import (
    improved_machine,
    repaired_in_place,
    repaired_table,
    with_table,
)
from vcmm.files.learned.renewed_tables import name_tables, renewed_files
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.files.toml import read_toml
from vcmm.learn.diagnosis.result import Diagnosis
from vcmm.learn.diagnosis.result_parts import Attempt
from vcmm.learn.diagnosis.thinning import limit_observations, limit_together
from vcmm.learn.diagnosis.written_machine import answers_to_write, rms_under, tables_to_write, writing_remarks
from vcmm.show.console.files import output_folder, write_files, write_text
from vcmm.show.console.terminal import say, say_warnings, show_answers, show_table
from vcmm.show.pages.diagnosis import least_seen, sentences
from vcmm.show.tables.answers_machine import diagnosis_answers
from vcmm.show.tables.diagnosis import answers, folds, next_steps, transfers

WRITTEN, READ = "write the machine file", "read the machine file back"
STEP_COMPARE = "compare the machine file that was written with the recording"


def diagnosis_texts(content: str, page: str, improved: dict[str, str]) -> dict[str, str]:
    """Return file name -> text, of --out."""
    return {"diagnosis.json": content, **({"report.html": page} if page else {}), **improved}


def write_report(report: Path | None, page: str) -> None:
    """Write the file of --report, where there is a page."""
    if report and page:
        write_text(report, page)


def report_sentences(report: Path | None, page: str) -> Iterator[str]:
    """Yield the sentences about the file of --report."""
    if report and page:
        yield f"wrote {report}"


def read_back(
    folder: Path, improved: dict[str, str], files: Sequence[Path], diagnosis: Diagnosis, attempt: Attempt
) -> tuple[Diagnosis, dict[str, str]]:
    """Return the diagnosis with the rms that the machine file leaves of recordings, once it is written and read again; and the texts,
    none where the file cannot be read: it is removed then.
    """

    def write_and_load() -> Machine | None:
        write_files(output_folder(folder), improved)
        return load_machine(folder / "machine.toml")

    def residual_rms(machine: Machine) -> float:
        recordings = [limit_observations(load_recording(f, machine, gaps=True)[0]) for f in files]
        return rms_under(limit_together(recordings), machine)

    if not improved:
        return diagnosis, improved
    machine = attempt(READ, write_and_load, None)
    if machine is None:
        for name in improved:
            (folder / name).unlink(missing_ok=True)
        return diagnosis, {}
    after = attempt(STEP_COMPARE, lambda: residual_rms(machine), diagnosis.fit.after)
    return replace(diagnosis, fit=replace(diagnosis.fit, after=after)), improved


def improved_files(
    folder: Path, recording: Path, machine: Path | None, stated: Machine, diagnosis: Diagnosis
) -> dict[str, str]:
    """Return file name -> text of the improved machine and its corrected table; empty when nothing was found to write."""
    named = read_toml(recording).data.get("machine")
    original = machine or (recording.parent / named if isinstance(named, str) else None)
    if original is None:
        return {}
    mistake = diagnosis.mistake
    tables = repaired_table(original, stated, mistake, recording.name) if mistake is not None else {}
    new = tables_to_write(diagnosis.answer)
    edits = repaired_in_place(stated, mistake, recording.name) if mistake is not None and not tables else ""
    if not tables and not edits and new is None and not answers_to_write(diagnosis.answer):
        return {}
    text = improved_machine(original, folder / "machine.toml", stated, diagnosis.answer, recording.name)
    if new is not None:
        files = renewed_files(original, stated, new, recording.name)
        return {"machine.toml": name_tables(text, recording.name), **files}
    return {"machine.toml": with_table(text) if tables else text + edits, **tables}


def show_diagnosis(d: Diagnosis) -> None:
    """Show the diagnosis on the terminal."""
    if d.transfer:
        show_table(transfers(d))
    show_answers(diagnosis_answers(d))
    for sentence in sentences(d):
        print(sentence)
    print()
    for answered in answers(d):
        show_table(answered)
    show_table(folds(d))
    if d.next_measurement:
        show_table(next_steps(d))
    if d.answer:
        for note in writing_remarks(d.answer):
            say(f"note: {note}")
    if d.detectable:
        print(f"The least that would have shown, rms at the best place of each: {least_seen(d)}")
    if d.invisible:
        print(f"This recording could not have shown: {', '.join(d.invisible)}")
    if d.not_testable:
        print("Not testable here (a column is missing): " + ", ".join(sorted(d.not_testable)))
    say_warnings(d.warnings)
    for failure in d.failures:
        say(f"failed: {failure.step}: {failure.text}")
