"""vcmm diagnose: what physics does this recording hold that the machine file lacks."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from vcmm.core.errors import UsageError
from vcmm.face.cli.options import Cluster, Seed, Shard, Workers


def diagnose_command(
    recordings: list[Path],
    *,
    machine: Path | None = None,
    seed: Seed = 0,
    effect: Annotated[list[str] | None, Parameter(name="--effect", negative=())] = None,
    report: Path | None = None,
    workers: Workers = None,
    cluster: Cluster = None,
    shard: Shard = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
) -> int:
    """Say what physics was left out: ranked, with parameters, rivals, held-out improvement and what to measure next.

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
    if any(path.is_dir() for path in recordings):
        if effect or report:
            raise UsageError("--effect and --report are for single recordings; a folder has --out")
        options = {"seed": seed, "machine": str(machine) if machine else None}
        return _folder(recordings, options, (workers, cluster, shard), json, out)
    if any(word is not None for word in (workers, cluster, shard)):
        raise UsageError("--workers, --cluster and --shard share the recordings of a folder; name one")
    from vcmm.face.cli.diagnose_several import SeveralRequest, diagnose_files
    from vcmm.files.own.recording import recording_file

    extra = [_own_class(word) for word in effect or ()]
    files, wanted = (
        [recording_file(path) for path in recordings],
        SeveralRequest(machine, seed, extra, report, json, out),
    )
    return _diagnose_file(files[0], wanted) if len(files) == 1 else diagnose_files(files, wanted, _show)


def _folder(
    folders: list[Path], options: dict[str, Any], shared: tuple[Any, ...], json: bool, out: Path | None
) -> int:
    """Every recording of one folder. shared: workers, cluster, shard. Raises UsageError for several."""
    from vcmm.face.cli.diagnose_folder import folder_job, shard_of_folder
    from vcmm.face.job import sharing_of

    if len(folders) > 1:
        raise UsageError("a folder is diagnosed by itself: name one folder, or recordings")
    workers, cluster, shard = shared
    sharing = sharing_of(workers, cluster, shard, keep=True)
    if sharing.share is None:
        return folder_job(folders[0], options, sharing, json, out)
    return shard_of_folder(folders[0], options, sharing, json, out)


def _diagnose_file(recording: Path, wanted: Any) -> int:
    """Diagnose one recording, print and write what was asked for. What fails after the names are found is named in the answer,
    which is printed all the same.
    """
    from dataclasses import replace

    from vcmm.face.cli.diagnose_several import WRITTEN, read_back
    from vcmm.files.own.machine import load_machine
    from vcmm.files.own.recording import load_recording
    from vcmm.learn.diagnosis.job import diagnose
    from vcmm.learn.diagnosis.later import Attempt
    from vcmm.learn.diagnosis.result import diagnosis_json
    from vcmm.learn.diagnosis.very_long import few_enough
    from vcmm.show.console.complaints import about
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.files import output_folder
    from vcmm.show.console.terminal import progress

    machine, seed = wanted.machine, wanted.seed
    folder = output_folder(wanted.out) if wanted.out else None
    found, known = load_recording(recording, load_machine(machine) if machine else None, gaps=True)
    found = few_enough(found)  # the rest need not be kept
    with progress() as show_progress, about(recording):
        diagnosis = diagnose(found, known, seed=seed, extra_effects=wanted.effects, progress=show_progress)
    diagnosis = _fitted_before(diagnosis, known, recording.name)
    attempt = Attempt.none()
    improved: dict[str, str] = {}
    if folder:
        improved = attempt(WRITTEN, lambda: improved_files(folder, recording, machine, known, diagnosis), {})
        diagnosis, improved = read_back(folder, improved, [recording], diagnosis, attempt)
    page = ""
    if folder or wanted.report:
        page = attempt("draw the report", lambda: _page(found, known, diagnosis), "")
    diagnosis = replace(diagnosis, failed=(*diagnosis.failed, *attempt.failures))
    body = {k: v for k, v in diagnosis_json(diagnosis).items() if k != "schema"}
    body["improved_machine"] = str(folder / "machine.toml") if folder and improved else None
    files = sources(recording) + ([machine] if machine else [])
    content = document("vcmm.diagnosis/1", body, seed=seed, files=files, warnings=diagnosis.warnings)
    if wanted.json:
        print_json(content)
    else:
        _show(diagnosis)
    _write(folder, wanted.report, page, content, improved)
    attempt.raise_bugs()
    return 0


def _page(found: Any, known: Any, diagnosis: Any) -> str:
    """The report; where a picture cannot be drawn, a page that says so: numbers and files do not depend on it."""
    from vcmm.core.errors import VcmmError
    from vcmm.show.console.terminal import say
    from vcmm.show.pages.diagnosis import diagnosis_page, without_pictures

    try:
        return diagnosis_page(found, known, diagnosis)
    except VcmmError as error:
        say(f"note: the report has no pictures: {error}")
        return without_pictures(found, diagnosis, str(error))


def _fitted_before(diagnosis: Any, known: Any, recording: str) -> Any:
    """The diagnosis with a warning where the machine was made from this very recording."""
    from dataclasses import replace

    if not any(i.evidence.startswith(f"diagnosed from {recording}") for i in known.inputs):
        return diagnosis
    said = (
        f"the machine holds what an earlier diagnosis of {recording} found: what is found now is fitted to the same rows a"
        " second time, and a verdict is worth less than the first one; judge the machine on another recording"
    )
    return replace(diagnosis, warnings=(*diagnosis.warnings, said))


def _own_class(word: str) -> Any:
    """module:Class to the class. Raises UsageError naming what is missing."""
    import importlib
    import sys

    from vcmm.core.effect import Effect
    from vcmm.core.errors import UsageError

    module, _, name = word.partition(":")
    sys.path.insert(0, str(Path.cwd()))
    try:
        found = getattr(importlib.import_module(module), name)
    except (ImportError, AttributeError, ValueError) as error:
        raise UsageError(
            f'--effect "{word}" cannot be imported ({error}); write module:Class, for example my_effects:Wobble'
        ) from None
    finally:
        sys.path.pop(0)
    if not (isinstance(found, type) and issubclass(found, Effect)):
        raise UsageError(f'--effect "{word}" is no vcmm.Effect class')
    return found


def improved_files(
    folder: Path, recording: Path, machine: Path | None, known: Any, diagnosis: Any
) -> dict[str, str]:
    """File name -> text of the improved machine and its corrected table; empty when nothing was found to write."""
    from vcmm.files.learned.improved_machine import (
        improved_machine,
        repaired_in_place,
        repaired_table,
        with_table,
    )
    from vcmm.files.learned.renewed_tables import name_tables, renewed_files
    from vcmm.files.toml import read_toml
    from vcmm.learn.diagnosis.acceptance import anew, answers_to_write

    named = read_toml(recording).data.get("machine")
    original = machine or (recording.parent / named if isinstance(named, str) else None)
    if original is None:
        return {}
    mistake = diagnosis.mistake
    tables = repaired_table(original, known, mistake, recording.name) if mistake is not None else {}
    new = anew(diagnosis.answer)
    edits = repaired_in_place(known, mistake, recording.name) if mistake is not None and not tables else ""
    if not tables and not edits and new is None and not answers_to_write(diagnosis.answer):
        return {}
    text = improved_machine(original, folder / "machine.toml", known, diagnosis.answer, recording.name)
    if new is not None:
        files = renewed_files(original, known, new, recording.name)
        return {"machine.toml": name_tables(text, recording.name), **files}
    return {"machine.toml": with_table(text) if tables else text + edits, **tables}


def _write(
    folder: Path | None, report: Path | None, page: str, content: dict[str, Any], improved: dict[str, str]
) -> None:
    from vcmm.show.console.documents import json_text
    from vcmm.show.console.files import write_files, write_text
    from vcmm.show.console.terminal import say

    if report and page:
        write_text(report, page)
        say(f"wrote {report}")
    if folder:
        texts = {"diagnosis.json": json_text(content)} | ({"report.html": page} if page else {})
        texts |= improved
        write_files(folder, texts)
        say(f"wrote {folder}/" + ", ".join(texts))


def _show(d: Any) -> None:
    """The diagnosis on the terminal."""
    from vcmm.learn.diagnosis.acceptance import notes
    from vcmm.show.console.terminal import say, say_warnings, show_answers, show_table
    from vcmm.show.pages.diagnosis import least_seen, sentences
    from vcmm.show.tables.answers_machine import diagnosis_answers
    from vcmm.show.tables.diagnosis import answers, folds, next_steps, transfers

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
        for note in notes(d.answer):
            say(f"note: {note}")
    if d.detectable:
        print(f"The least that would have shown, rms at the best place of each: {least_seen(d)}")
    if d.invisible:
        print(f"This recording could not have shown: {', '.join(d.invisible)}")
    if d.not_testable:
        print("Not testable here (a column is missing): " + ", ".join(sorted(d.not_testable)))
    say_warnings(d.warnings)
    for failure in d.failed:
        say(f"failed: {failure.step}: {failure.text}")
