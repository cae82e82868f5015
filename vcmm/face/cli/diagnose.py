"""vcmm diagnose: find the effects in a recording that the machine file lacks."""

from __future__ import annotations

import importlib
import sys
from collections.abc import Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, NamedTuple

from cyclopts import Parameter

from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError, VcmmError
from vcmm.core.machine import Machine
from vcmm.face.cli.diagnose_written import (
    WRITTEN,
    diagnosis_texts,
    improved_files,
    read_back,
    report_sentences,
    show_diagnosis,
    write_report,
)
from vcmm.face.cli.options import Cluster, InputFile, InputPath, Json, Seed, Shard, Workers
from vcmm.face.job import Flags, Job, Progress, Record, run_job, run_shared, sharing_of
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording, recording_file
from vcmm.learn.diagnosis.job import diagnose
from vcmm.learn.diagnosis.result import Diagnosis, diagnosis_json
from vcmm.learn.diagnosis.result_parts import Attempt
from vcmm.learn.diagnosis.thinning import limit_observations
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import say
from vcmm.show.pages.diagnosis import diagnosis_page, without_pictures
from vcmm.task.response.recording import Recording


def diagnose_command(
    recordings: list[InputPath],
    *,
    machine: InputFile | None = None,
    seed: Seed = 0,
    effect: Annotated[list[str] | None, Parameter(name="--effect", negative=())] = None,
    report: Path | None = None,
    workers: Workers = None,
    cluster: Cluster = None,
    shard: Shard = None,
    json: Json = False,
    out: Path | None = None,
) -> int:
    """Say what physics was left out: ranked, with parameters, rivals, held-out improvement and what to measure next.

    Exit code 70: of a folder, where a recording met a fault of ours; the others are in the table.

    Parameters
    ----------
    recordings
        Recording files (recording/1), or the tables that they name. Several are of one machine, and diagnosed together: what is common, what each one's own. A folder: every recording in it by itself, and what changed from one to the next.
    machine
        Machine file to use instead of the one that the recording names.
    seed
        Seed of the null recordings that set the false-alarm threshold.
    effect
        A further effect class of your own, as module:Class; may be repeated.
    report
        File for the HTML report.
    workers
        Processes that share the recordings of a folder; the document does not depend on it.
    cluster
        Address of a Dask scheduler whose workers share them, such as tcp://scheduler:8786.
    shard
        Diagnose one part of a folder only, such as 2/8, for a batch queue; `vcmm merge` puts all parts together.
    json
        Print one JSON document.
    out
        Folder for report.html, diagnosis.json and, when something was found, machine.toml; of a folder also recordings.csv and changes.csv.
    """
    flags = Flags(json, out)
    if any(path.is_dir() for path in recordings):
        from vcmm.face.cli.diagnose_folder import DiagnoseFolderJob

        if effect or report:
            raise UsageError("--effect and --report are for single recordings; a folder has --out")
        if len(recordings) > 1:
            raise UsageError("a folder is diagnosed by itself: name one folder, or recordings")
        sharing = sharing_of(workers, cluster, shard, keep=True)
        return run_shared(DiagnoseFolderJob(recordings[0], seed, machine, sharing=sharing), flags)
    if any(word is not None for word in (workers, cluster, shard)):
        raise UsageError("--workers, --cluster and --shard share the recordings of a folder; name one")
    extra = [_own_class(word) for word in effect or ()]
    files = [recording_file(path) for path in recordings]
    if len(files) == 1:
        return run_job(DiagnoseJob(files[0], machine, seed, extra, report, out), flags)
    from vcmm.face.cli.diagnose_several import DiagnoseSeveralJob

    return run_job(DiagnoseSeveralJob(tuple(files), machine, seed, extra, report, out), flags)


class Diagnosed(NamedTuple):
    """Result of a diagnosis. machine_files: file name -> text of the machine file; page: the report, "" where none is requested; attempt: the error
    after the names were found, which the answer names."""

    diagnosis: Diagnosis
    machine_files: dict[str, str]
    page: str
    attempt: Attempt


@dataclass(frozen=True)
class DiagnoseJob(Job[tuple[Recording, Machine], Diagnosed]):
    """One recording. folder: of --out, where the machine file is written and read again; report: file of --report."""

    recording: Path
    machine: Path | None
    seed: int
    effects: Sequence[type[Effect]]
    report: Path | None
    folder: Path | None
    schema, names_files_last = "vcmm.diagnosis/1", True

    @property
    def place(self) -> tuple[Path, str]:
        return self.recording, ""

    def load(self) -> tuple[Recording, Machine]:
        machine = load_machine(self.machine) if self.machine else None
        recording, machine_of_file = load_recording(self.recording, machine, gaps=True)
        return limit_observations(recording), machine_of_file  # the rest need not be kept

    def run(self, loaded: tuple[Recording, Machine], report: Progress) -> Diagnosed:
        """Diagnose the recording; an error after the names are found is named in the answer, which is given nevertheless."""
        recording, machine = loaded
        diagnosis = diagnose(recording, machine, seed=self.seed, extra_effects=self.effects, progress=report)
        diagnosis = _fitted_before(diagnosis, machine, self.recording.name)
        attempt = Attempt.none()
        improved: dict[str, str] = {}
        if folder := self.folder:
            improved = attempt(
                WRITTEN, lambda: improved_files(folder, self.recording, self.machine, machine, diagnosis), {}
            )
            diagnosis, improved = read_back(folder, improved, [self.recording], diagnosis, attempt)
        page = ""
        if folder or self.report:
            page = attempt("draw the report", lambda: _page(recording, machine, diagnosis), "")
        diagnosis = replace(diagnosis, failures=(*diagnosis.failures, *attempt.failures))
        return Diagnosed(diagnosis, improved, page, attempt)

    def record(self, loaded: tuple[Recording, Machine], result: Diagnosed) -> Record:
        body = {k: v for k, v in diagnosis_json(result.diagnosis).items() if k != "schema"}
        written = self.folder is not None and result.machine_files
        body["improved_machine"] = str(self.folder / "machine.toml") if self.folder and written else None
        files = sources(self.recording) + ([self.machine] if self.machine else [])
        return Record(body, files, self.seed, result.diagnosis.warnings)

    def texts(
        self, loaded: tuple[Recording, Machine], result: Diagnosed, content: str, folder: Path
    ) -> dict[str, str]:
        return diagnosis_texts(content, result.page, result.machine_files)

    def export(
        self, loaded: tuple[Recording, Machine], result: Diagnosed, content: dict[str, object]
    ) -> None:
        write_report(self.report, result.page)

    def show(self, loaded: tuple[Recording, Machine], result: Diagnosed) -> None:
        show_diagnosis(result.diagnosis)

    def notes(self, loaded: tuple[Recording, Machine], result: Diagnosed) -> Iterator[str]:
        return report_sentences(self.report, result.page)

    def finish(self, loaded: tuple[Recording, Machine], result: Diagnosed) -> None:
        result.attempt.raise_bugs()


def _page(recording: Recording, machine: Machine, diagnosis: Diagnosis) -> str:
    """Return the report; where a picture cannot be drawn, a page with the reason: numbers and files do not depend on it."""
    try:
        return diagnosis_page(recording, machine, diagnosis)
    except VcmmError as error:
        say(f"note: the report has no pictures: {error}")
        return without_pictures(recording, diagnosis, str(error))


def _fitted_before(diagnosis: Diagnosis, machine: Machine, recording: str) -> Diagnosis:
    """Return the diagnosis with a warning where the machine was made from this very recording."""
    if not any(i.evidence.startswith(f"diagnosed from {recording}") for i in machine.inputs):
        return diagnosis
    remark = (
        f"the machine holds what an earlier diagnosis of {recording} found: what is found now is fitted to the same rows a"
        " second time, and a verdict is worth less than the first one; judge the machine on another recording"
    )
    return replace(diagnosis, warnings=(*diagnosis.warnings, remark))


def _own_class(word: str) -> type[Effect]:
    """Return the class of module:Class. Raises UsageError naming what is missing."""
    module, _, name = word.partition(":")
    sys.path.insert(0, str(Path.cwd()))
    try:
        own_class = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise UsageError(
            f'--effect "{word}" cannot be imported ({error}); write module:Class, for example my_effects:Wobble'
        ) from None
    finally:
        sys.path.pop(0)
    if not (isinstance(own_class, type) and issubclass(own_class, Effect)):
        raise UsageError(f'--effect "{word}" is no vcmm.Effect class')
    return own_class
