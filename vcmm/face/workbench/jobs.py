"""The other jobs of the workbench: measure and place the task that is open, and what dropped files ask for.

What is dropped lies in an empty folder of its own, and every reader is confined to it (`vcmm.core.confinement`).
"""

from __future__ import annotations

import csv
import io
import re
from collections.abc import Callable, Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

from vcmm.answer.evaluation.one_line import answer
from vcmm.core.confinement import confine
from vcmm.core.errors import UsageError, VcmmError, choose_from
from vcmm.face import api
from vcmm.task.measuring.scenario import Scenario

OPEN_TASK = ("measure", "place")
WITH_FILES = ("diagnose", "calibrate", "evaluate", "cut")
EVALUATIONS, SCANNED, TRIALS = 60, 20, 20_000  # of a placement: coarse enough for a page, and it says so
CUT = re.compile(rb"(?m)^\s*\[cut[\].]")
Answer = dict[str, Any]
Progress = Callable[[str, float], None]


def run_open(job: str, scenario: Scenario, progress: Progress) -> Answer:
    """A job on the task that is open: {"job", "said": sentences, "report": HTML or ""}. UsageError: no such job."""
    if job not in OPEN_TASK:
        raise UsageError(f'there is no job "{job[:40]}".{choose_from(job, (*OPEN_TASK, *WITH_FILES))}')
    if job == "measure":
        from vcmm.answer.evaluation.one_line import value_text

        found = api.measure(scenario)
        said = [f"{v.name}: {value_text(v.value, v.unit)}, with all errors at their estimates" for v in found.values]  # fmt: skip
        return {"job": job, "said": [*said, *found.warnings], "report": ""}
    from vcmm.show.pages.place import place_page

    placed = api.place(scenario, evaluations=EVALUATIONS, scanned=SCANNED, trials=TRIALS, progress=progress)
    note = f"A short search ({EVALUATIONS} evaluations); vcmm place looks longer."
    return {"job": job, "said": [note, *placed.warnings], "report": place_page(placed)}


def run_files(
    job: str, files: Mapping[str, bytes], folder: Path, scenario: Scenario | None, progress: Progress
) -> Answer:
    """A job with dropped files; job "" is what they ask for themselves. UsageError: not one job's files.

    files: by plain name (checked by the caller); folder: an empty one, in which they are read. scenario: the task that is open, which
    measured points and values belong to. What files name elsewhere on this machine is refused by the readers themselves.
    """
    asked = job or job_of(files)
    if asked not in WITH_FILES:
        raise UsageError(f'there is no job "{asked[:40]}" with files.{choose_from(asked, WITH_FILES)}')
    lay_out(files, folder)
    with confine(folder):
        try:
            return {"job": asked, **_JOBS[asked](files, folder, scenario, progress)}
        except VcmmError as error:
            problems = [p.replace(f"{folder}/", "") for p in getattr(error, "problems", (str(error),))]
            raise UsageError("\n".join(problems)) from None


def job_of(files: Mapping[str, bytes]) -> str:
    """Which job a set of files is for: one recording, several, a scenario that cuts, or tables of measured points or values."""
    recordings = _of_kind(files, b"recording/")
    if recordings:
        return "diagnose" if len(recordings) == 1 else "calibrate"
    if any(CUT.search(files[n]) for n in _of_kind(files, b"scenario/")):
        return "cut"
    if files and all(n.endswith(".csv") for n in files):
        return "evaluate"
    raise UsageError(
        'drop one recording (.toml with vcmm = "recording/1") and its tables to diagnose it, several to calibrate with a machine file, a scenario with '
        "[cut] and all its files, or measured points or values (.csv) of the task that is open"
    )


def lay_out(files: Mapping[str, bytes], folder: Path) -> None:
    """The files in the folder. UsageError: a file and a folder of one name."""
    try:
        for name, content in files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
    except OSError:
        raise UsageError("a file and a folder among the dropped ones have the same name") from None


def _of_kind(files: Mapping[str, bytes], word: bytes) -> list[str]:
    return [n for n in files if n.endswith(".toml") and word in files[n]]


def _only(files: Mapping[str, bytes], word: bytes, what: str) -> str:
    found = _of_kind(files, word)
    if len(found) != 1:
        raise UsageError(f"drop {what}; {len(found)} are among the files")
    return found[0]


def _diagnose(files: Mapping[str, bytes], folder: Path, _: Scenario | None, progress: Progress) -> Answer:
    from vcmm.files.own.recording import load_recording
    from vcmm.learn.diagnosis.job import diagnose
    from vcmm.show.pages.diagnosis import diagnosis_page, sentences

    head = _only(files, b"recording/", 'one recording (.toml with vcmm = "recording/1") and its tables')
    recording, machine = load_recording(folder / head)
    progress("diagnosing", 0.0)
    found = diagnose(recording, machine)
    progress("drawing the report", 0.9)
    answers = [{"effect": a.effect, "where": a.where, "probability": a.probability} for a in found.answer]
    report = diagnosis_page(recording, machine, found)
    return {"verdict": found.verdict, "said": list(sentences(found)), "answer": answers, "report": report}


def _calibrate(files: Mapping[str, bytes], folder: Path, _: Scenario | None, progress: Progress) -> Answer:
    from vcmm.files.own.instruments import load_certificate
    from vcmm.files.own.machine import load_machine
    from vcmm.files.own.recording import load_recording
    from vcmm.learn.calibration.job import calibrate
    from vcmm.show.pages.calibration import calibration_page

    known = load_machine(folder / _only(files, b"machine/", "one machine file with the recordings"))
    heads = [folder / n for n in _of_kind(files, b"recording/")]
    recordings = [load_recording(path, known)[0] for path in heads]
    stated = {r.name: load_certificate(path, r) for path, r in zip(heads, recordings)}
    found = calibrate(recordings, known, {n: c for n, c in stated.items() if c is not None}, progress=progress)  # fmt: skip
    missing = [c.text for c in found.identified.combinations]
    said = [f"{len(found.identified.names)} errors identified from {len(recordings)} recordings.", *missing]
    return {"said": [*said, *found.warnings], "report": calibration_page(found)}


def _evaluate(
    files: Mapping[str, bytes], folder: Path, scenario: Scenario | None, progress: Progress
) -> Answer:
    from vcmm.show.pages.uncertainty import uncertainty_page

    if scenario is None or len(files) != 1:
        raise UsageError(f"drop one table of measured points or values; {len(files)} are among the files")
    ((name, content),) = files.items()
    columns = next(csv.reader(io.StringIO(content.decode("utf-8", "replace"))), [])
    given: dict[str, Any] = {"values" if "characteristic" in columns else "points": folder / name}
    parts = api.evaluate(scenario, **given, progress=progress)
    said = [f"{p.part + ', ' if p.part else ''}{e.result.name}: {answer(e.result)}" for p in parts for e in p.characteristics]  # fmt: skip
    warnings = list(dict.fromkeys(w for p in parts for w in p.warnings))
    first = parts[0]
    whole = replace(
        first.uncertainty, characteristics=tuple(e.result for e in first.characteristics), warnings=first.warnings
    )  # fmt: skip
    report = uncertainty_page(scenario, whole) if len(parts) == 1 else ""
    return {"said": [*said, *warnings], "report": report}


def _cut(files: Mapping[str, bytes], folder: Path, _: Scenario | None, progress: Progress) -> Answer:
    from vcmm.files.own.cut_scenario import load_cut
    from vcmm.shop.machining.job import cut
    from vcmm.show.pages.cut import cut_page

    heads = [n for n in _of_kind(files, b"scenario/") if CUT.search(files[n])]
    if len(heads) != 1:
        raise UsageError(f"drop one scenario with [cut] and all its files; {len(heads)} are among them")
    scenario = load_cut(folder / heads[0])
    found = cut(scenario, progress=progress)
    said = [f"{c.name}: {answer(c)}" for c in found.characteristics]
    return {"said": [*said, *found.warnings], "report": cut_page(scenario, found)}


_JOBS: dict[str, Any] = {"diagnose": _diagnose, "calibrate": _calibrate, "evaluate": _evaluate, "cut": _cut}
