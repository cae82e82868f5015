"""vcmm diagnose A B ...: several recordings of one machine, what is common and what is each one's own."""

from __future__ import annotations

from collections.abc import Callable, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

WRITTEN, READ = "write the machine file", "read the machine file back"
STEP_COMPARE = "compare the machine file that was written with the recording"


@dataclass(frozen=True)
class SeveralRequest:
    """What the command line asks for."""

    machine: Path | None
    seed: int
    effects: Sequence[Any]
    report: Path | None
    json: bool
    out: Path | None


def diagnose_files(files: Sequence[Path], wanted: SeveralRequest, show: Callable[[Any], None]) -> int:
    """Diagnose recordings together, print and write what was asked for. Raises UsageError where they name two machines.

    show: prints a diagnosis.
    """
    from vcmm.learn.diagnosis.later import Attempt
    from vcmm.learn.diagnosis.several import diagnose_several
    from vcmm.show.console.complaints import about
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.terminal import progress

    recordings, known, original = read_all(files, wanted.machine)
    with progress() as show_progress, about(files[0]):
        found = diagnose_several(
            recordings, known, seed=wanted.seed, extra_effects=wanted.effects, progress=show_progress
        )
    attempt = Attempt.none()
    texts: dict[str, str] = {}
    if wanted.out:
        texts = attempt(WRITTEN, lambda: _write_common(found, known, original, wanted.out), {})
        together, texts = read_back(wanted.out, texts, files, found.together, attempt)
        found = replace(found, together=together)
    page = ""
    if wanted.out or wanted.report:
        page = attempt("draw the report", lambda: _page(found, known), "")
    failed = (*found.together.failed, *attempt.failures)
    found = replace(found, together=replace(found.together, failed=failed))
    inputs = [p for f in files for p in sources(f)] + ([wanted.machine] if wanted.machine else [])
    body = _body(found, wanted.out if texts else None)
    warnings = (*found.together.warnings, *left_out(found))
    content = document(
        "vcmm.diagnosis/1", body, seed=wanted.seed, files=list(dict.fromkeys(inputs)), warnings=warnings
    )
    if wanted.json:
        print_json(content)
    else:
        show(found.together)
        _show_each(found)
    _write(page, content, texts, wanted)
    attempt.raise_bugs()
    return 0


def read_all(files: Sequence[Path], machine: Path | None) -> tuple[list[Any], Any, Path | None]:
    """The recordings with names of their own, their machine, and its file where it has one."""
    from vcmm.core.errors import UsageError
    from vcmm.files.own.machine import load_machine
    from vcmm.files.own.recording import load_recording, machine_of
    from vcmm.learn.diagnosis.very_long import few_enough

    if machine is None:
        named = {machine_of(f)[1] for f in files}
        if len(named) > 1:
            who = ", ".join(f"{f}: {machine_of(f)[0] or 'within the file'}" for f in files)
            raise UsageError(
                f"the recordings name machines that differ ({who}); one machine is diagnosed at a time: say which with --machine"
            )
    first, known = load_recording(files[0], load_machine(machine) if machine else None, gaps=True)
    recordings = [few_enough(first)]
    del first
    recordings += [few_enough(load_recording(f, known, gaps=True)[0]) for f in files[1:]]
    if len({r.name for r in recordings}) < len(recordings):
        recordings = [replace(r, name=str(f)) for r, f in zip(recordings, files)]
    return recordings, known, machine or machine_of(files[0])[0]


def read_back(
    folder: Path, improved: dict[str, str], files: Sequence[Path], diagnosis: Any, attempt: Any
) -> tuple[Any, dict[str, str]]:
    """The diagnosis with the rms that the machine file leaves of recordings, once it is written and read again; and the texts,
    none where the file cannot be read: it is taken away then.
    """
    from vcmm.files.own.machine import load_machine
    from vcmm.files.own.recording import load_recording
    from vcmm.learn.diagnosis.very_long import few_enough, few_together
    from vcmm.learn.diagnosis.written_fit import rms_left
    from vcmm.show.console.files import output_folder, write_files

    def written() -> Any:
        write_files(output_folder(folder), improved)
        return load_machine(folder / "machine.toml")

    def left(machine: Any) -> float:
        recordings = [few_enough(load_recording(f, machine, gaps=True)[0]) for f in files]
        return rms_left(few_together(recordings), machine)

    if not improved:
        return diagnosis, improved
    machine = attempt(READ, written, None)
    if machine is None:
        for name in improved:
            (folder / name).unlink(missing_ok=True)
        return diagnosis, {}
    after = attempt(STEP_COMPARE, lambda: left(machine), diagnosis.fit.after)
    return replace(diagnosis, fit=replace(diagnosis.fit, after=after)), improved


def left_out(found: Any) -> list[str]:
    """Columns that not all recordings have, in words."""
    return [
        f"the column {column} is missing in {', '.join(who)}, so all recordings are looked at without it"
        for column, who in found.left_out.items()
    ]


def _body(found: Any, folder: Path | None) -> dict[str, Any]:
    from vcmm.learn.diagnosis.result import diagnosis_json
    from vcmm.learn.diagnosis.several import several_json

    body = {k: v for k, v in diagnosis_json(found.together).items() if k != "schema"}
    return body | several_json(found) | {"improved_machine": str(folder / "machine.toml") if folder else None}


def _write_common(found: Any, known: Any, original: Path | None, out: Path | None) -> dict[str, str]:
    """machine.toml with what is common; empty where there is nothing to write."""
    from vcmm.files.learned.improved_machine import improved_machine
    from vcmm.files.learned.renewed_tables import name_tables, renewed_files
    from vcmm.learn.diagnosis.acceptance import anew, answers_to_write

    answers, source = found.together.answer, found.recording.name
    new = anew(answers)
    if out is None or original is None or (new is None and not answers_to_write(answers)):
        return {}
    text = improved_machine(original, out / "machine.toml", known, answers, source)
    if new is None:
        return {"machine.toml": text}
    return {"machine.toml": name_tables(text, source), **renewed_files(original, known, new, source)}


def _page(found: Any, known: Any) -> str:
    from vcmm.show.pages.diagnosis import diagnosis_page

    return diagnosis_page(found.recording, known, found.together, found)


def _write(page: str, content: dict[str, Any], texts: dict[str, str], wanted: SeveralRequest) -> None:
    from vcmm.show.console.documents import json_text
    from vcmm.show.console.files import output_folder, write_files, write_text
    from vcmm.show.console.terminal import say

    if wanted.report and page:
        write_text(wanted.report, page)
        say(f"wrote {wanted.report}")
    if wanted.out:
        report = {"report.html": page} if page else {}
        all_texts = {"diagnosis.json": json_text(content), **report, **texts}
        write_files(output_folder(wanted.out), all_texts)
        say(f"wrote {wanted.out}/" + ", ".join(all_texts))


def _show_each(found: Any) -> None:
    from vcmm.show.console.terminal import say, show_table
    from vcmm.show.tables.several import by_itself, sizes

    if found.shared:
        show_table(sizes(found))
    show_table(by_itself(found))
    for text in left_out(found):
        say(f"note: {text}")
