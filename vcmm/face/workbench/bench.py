"""One task of the workbench: previews at once, long work one at a time, cancelled when a knob moves on or by the user.

The scenario file with the knobs turned, as text to be saved: its owner's comments and layout stay.

The other jobs of the workbench: measure and place the task that is open, and what dropped files ask for.

What is dropped lies in an empty folder of its own, and every reader is confined to it (`vcmm.core.confinement`).
"""

from __future__ import annotations

import re
import threading
from collections.abc import Mapping
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

from vcmm.answer.evaluation.one_line import answer
from vcmm.core.blocks import Progress
from vcmm.core.confinement import confine
from vcmm.core.errors import UsageError, VcmmError, choose_from
from vcmm.core.text import read_text
from vcmm.face import api
from vcmm.face.workbench.live import preview
from vcmm.face.workbench.sweep import pictures, sweep
from vcmm.files.own.placement_writer import number_text, placed_text
from vcmm.files.own.scenario import turned_knobs
from vcmm.show.console.documents import document
from vcmm.show.pages.uncertainty import decision_chart, scenes
from vcmm.show.pages.view import task_in_machine
from vcmm.show.report.scene import figure_of
from vcmm.show.tables.uncertainty import uncertainty_json
from vcmm.task.measuring.knobs import POSE, knobs_of, with_knobs
from vcmm.task.measuring.scenario import Scenario

OPEN_TASK = ("measure", "place")
WITH_FILES = ("diagnose", "calibrate", "evaluate", "cut")
EVALUATIONS, SCANNED, TRIALS = 60, 20, 20_000  # of a placement: coarse enough for a page, and it says so
CUT = re.compile(rb"(?m)^\s*\[cut[\].]")
Answer = dict[str, Any]


def run_open(job: str, scenario: Scenario, progress: Progress) -> Answer:
    """Run a job on the open task: {"job", "said": sentences, "report": HTML or ""}. UsageError: no such job."""
    if job not in OPEN_TASK:
        raise UsageError(f'there is no job "{job[:40]}".{choose_from(job, (*OPEN_TASK, *WITH_FILES))}')
    if job == "measure":
        from vcmm.answer.evaluation.one_line import value_text

        measurement = api.measure(scenario)
        lines = [f"{v.name}: {value_text(v.value, v.unit)}, with all errors at their estimates" for v in measurement.values]  # fmt: skip
        return {"job": job, "said": [*lines, *measurement.warnings], "report": ""}
    from vcmm.show.pages.place import place_page

    placed = api.place(scenario, evaluations=EVALUATIONS, scanned=SCANNED, trials=TRIALS, progress=progress)
    note = f"A short search ({EVALUATIONS} evaluations); vcmm place looks longer."
    return {"job": job, "said": [note, *placed.warnings], "report": place_page(placed)}


def run_files(
    job: str, files: Mapping[str, bytes], folder: Path, scenario: Scenario | None, progress: Progress
) -> Answer:
    """Run a job with dropped files; job "" is the one that the files need. UsageError: not one job's files.

    files: by plain name (checked by the caller); folder: an empty one, in which they are read. scenario: the task that is open, which
    measured points and values belong to. What files name elsewhere on this machine is refused by the readers themselves.
    """
    job_name = job or job_of(files)
    if job_name not in WITH_FILES:
        raise UsageError(f'there is no job "{job_name[:40]}" with files.{choose_from(job_name, WITH_FILES)}')
    lay_out(files, folder)
    with confine(folder):
        try:
            return {"job": job_name, **_JOBS[job_name](files, folder, scenario, progress)}
        except VcmmError as error:
            problems = [p.replace(f"{folder}/", "") for p in getattr(error, "problems", (str(error),))]
            raise UsageError("\n".join(problems)) from None


def job_of(files: Mapping[str, bytes]) -> str:
    """Return which job a set of files is for: one recording, several, a scenario that cuts, or tables of measured points or values."""
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
    """Write the files to the folder. UsageError: a file and a folder of one name."""
    try:
        for name, content in files.items():
            (folder / name).parent.mkdir(parents=True, exist_ok=True)
            (folder / name).write_bytes(content)
    except OSError:
        raise UsageError("a file and a folder among the dropped ones have the same name") from None


def _of_kind(files: Mapping[str, bytes], word: bytes) -> list[str]:
    return [n for n in files if n.endswith(".toml") and word in files[n]]


def _only(files: Mapping[str, bytes], word: bytes, what: str) -> str:
    matching = _of_kind(files, word)
    if len(matching) != 1:
        raise UsageError(f"drop {what}; {len(matching)} are among the files")
    return matching[0]


def _diagnose(files: Mapping[str, bytes], folder: Path, _: Scenario | None, progress: Progress) -> Answer:
    from vcmm.files.own.recording import load_recording
    from vcmm.learn.diagnosis.job import diagnose
    from vcmm.show.pages.diagnosis import diagnosis_page, sentences

    head = _only(files, b"recording/", 'one recording (.toml with vcmm = "recording/1") and its tables')
    recording, machine = load_recording(folder / head)
    progress("diagnosing", 0.0)
    diagnosis = diagnose(recording, machine)
    progress("drawing the report", 0.9)
    answers = [{"effect": a.effect, "where": a.where, "probability": a.probability} for a in diagnosis.answer]
    report = diagnosis_page(recording, machine, diagnosis)
    return {
        "verdict": diagnosis.verdict,
        "said": list(sentences(diagnosis)),
        "answer": answers,
        "report": report,
    }


def _calibrate(files: Mapping[str, bytes], folder: Path, _: Scenario | None, progress: Progress) -> Answer:
    from vcmm.files.own.instruments import load_certificate
    from vcmm.files.own.machine import load_machine
    from vcmm.files.own.recording import load_recording
    from vcmm.learn.calibration.job import calibrate
    from vcmm.show.pages.calibration import calibration_page

    machine = load_machine(folder / _only(files, b"machine/", "one machine file with the recordings"))
    heads = [folder / n for n in _of_kind(files, b"recording/")]
    recordings = [load_recording(path, machine)[0] for path in heads]
    stated = {r.name: load_certificate(path, r) for path, r in zip(heads, recordings)}
    calibration = calibrate(recordings, machine, {n: c for n, c in stated.items() if c is not None}, progress=progress)  # fmt: skip
    missing = [c.text for c in calibration.identified.combinations]
    lines = [
        f"{len(calibration.identified.names)} errors identified from {len(recordings)} recordings.",
        *missing,
    ]
    return {"said": [*lines, *calibration.warnings], "report": calibration_page(calibration)}


def _evaluate(
    files: Mapping[str, bytes], folder: Path, scenario: Scenario | None, progress: Progress
) -> Answer:
    from vcmm.files.sheets import first_cells
    from vcmm.show.pages.uncertainty import uncertainty_page

    if scenario is None or len(files) != 1:
        raise UsageError(f"drop one table of measured points or values; {len(files)} are among the files")
    (name,) = files
    columns = first_cells(folder / name)
    given: dict[str, Any] = {"values" if "characteristic" in columns else "points": folder / name}
    parts = api.evaluate(scenario, **given, progress=progress)
    lines = [f"{p.part + ', ' if p.part else ''}{e.result.name}: {answer(e.result)}" for p in parts for e in p.characteristics]  # fmt: skip
    warnings = list(dict.fromkeys(w for p in parts for w in p.warnings))
    first = parts[0]
    whole = replace(
        first.uncertainty, characteristics=tuple(e.result for e in first.characteristics), warnings=first.warnings
    )  # fmt: skip
    report = uncertainty_page(scenario, whole) if len(parts) == 1 else ""
    return {"said": [*lines, *warnings], "report": report}


def _cut(files: Mapping[str, bytes], folder: Path, _: Scenario | None, progress: Progress) -> Answer:
    from vcmm.files.own.cut_scenario import load_cut
    from vcmm.shop.machining.job import cut
    from vcmm.show.pages.cut import cut_page

    heads = [n for n in _of_kind(files, b"scenario/") if CUT.search(files[n])]
    if len(heads) != 1:
        raise UsageError(f"drop one scenario with [cut] and all its files; {len(heads)} are among them")
    scenario = load_cut(folder / heads[0])
    cut_result = cut(scenario, progress=progress)
    lines = [f"{c.name}: {answer(c)}" for c in cut_result.characteristics]
    return {"said": [*lines, *cut_result.warnings], "report": cut_page(scenario, cut_result)}


_JOBS: dict[str, Any] = {"diagnose": _diagnose, "calibrate": _calibrate, "evaluate": _evaluate, "cut": _cut}


UNITS = {"room": " K"}  # knobs whose value in a file is a text with its unit


def saved_text(source: Path, scenario: Scenario, values: Mapping[str, float]) -> str:
    """Return the text of a scenario file like `source` with the knobs at `values`: pose in [pose], all else in [knobs].

    scenario: that of the file before its [knobs] are turned. To be kept in the folder of `source`, whose files it names. A knob that
    was not changed is not written. UsageError: knobs that do not exist or are out of range.
    """
    chosen = with_knobs(scenario, values)
    starts = {k.name: k.start for k in knobs_of(scenario)}
    moved = {n: float(v) for n, v in values.items() if abs(v - starts[n]) > 1e-12}
    text = read_text(source)
    if any(n in POSE for n in moved):
        pose = np.concatenate([chosen.pose.shift, chosen.pose.turns()])
        text = placed_text(source, source, pose)
    return _with_knobs_table(text, {n: v for n, v in moved.items() if n not in POSE})


def _with_knobs_table(text: str, turned: Mapping[str, float]) -> str:
    """Return the text with [knobs] as given, and without where nothing is turned."""
    import tomlkit

    document = tomlkit.parse(text.rstrip() + "\n")
    document.pop("knobs", None)
    document = tomlkit.parse(document.as_string().rstrip() + "\n")
    if turned:
        table = tomlkit.table()
        for name, value in turned.items():
            table[name] = _value(name, value)
        document.add(tomlkit.nl())
        document["knobs"] = table
    return str(document.as_string())


def _value(name: str, value: float) -> str | int | float:
    if name in UNITS:
        return f"{number_text(value, 9)}{UNITS[name]}"
    return round(value) if name == "touches" else value


Question = tuple[str, int]  # the page that asks, and which of its questions
MOST_PAGES = 100  # pages whose newest question is remembered


class GivenUp(Exception):
    """A newer question has come; the answer to this one is no longer wanted."""


class Bench:
    """The task, and the newest question of every open page. Answers are dictionaries of JSON."""

    def __init__(self, scenario: Scenario, source: Path | None = None) -> None:
        """source: the file of the scenario, whose [knobs] are not turned yet (`load_scenario(..., knobs=False)`)."""
        self.scenario, self.source = scenario, source
        self._turned = {} if source is None else turned_knobs(source)
        self._working = threading.Lock()
        self._asked = threading.Lock()
        self._newest: dict[str, int] = {}
        self._done: dict[str, tuple[str, float | None]] = {}

    def state(self) -> dict[str, Any]:
        """Name, knobs with their ranges, and where those stand that the file has turned."""
        knobs = [vars(k) | {"low": k.reach[0], "high": k.reach[1]} for k in knobs_of(self.scenario)]
        return {"name": self.scenario.name, "knobs": knobs, "turned": self._turned}

    def progress(self, page: str = "") -> dict[str, Any]:
        """Return the progress of the long work of a page, in words and as a share; empty where it has none."""
        text, share = self._done.get(page, ("", None))
        return {"text": text, "share": share}

    def cancel(self, page: str = "") -> dict[str, Any]:
        """Ends what a page has asked for: it answers GivenUp at its next step."""
        self._ask(page)
        return {"cancelled": True}

    def text_with_knobs(self, values: Mapping[str, Any]) -> dict[str, Any]:
        """Return the scenario file with the knobs at `values`, to be kept in the folder of the one that was opened."""
        if self.source is None:
            raise UsageError(
                "this task was not read from a file; vcmm serve SCENARIO opens one that can be saved"
            )
        stem = self.source.stem.removesuffix("-turned")
        return {"name": f"{stem}-turned.toml", "toml": saved_text(self.source, self.scenario, values)}

    def sweep(self, values: Mapping[str, Any], knob: str, page: str = "") -> dict[str, Any]:
        """Return U of every characteristic along one knob; other pages may ask between two of its steps."""
        mine = self._ask(page)

        def step(done: int, total: int) -> None:
            self._check_newest(mine)
            self._done[page] = (f"sweep, {done} of {total}", done / total)

        try:
            swept = sweep(self.scenario, values, knob, step)
            with self._working:
                return swept | {"pictures": pictures(self.scenario, swept)}
        finally:
            self._done.pop(page, None)

    def preview(self, values: Mapping[str, Any], page: str = "") -> dict[str, Any]:
        """Return figures and the part at its present place. UsageError: knobs that do not exist. GivenUp: the page has asked something
        newer meanwhile."""
        mine = self._ask(page)
        chosen = with_knobs(self.scenario, values)
        with self._working:
            self._check_newest(mine)
            figure = figure_of(task_in_machine(chosen.task()))[0]
            return preview(chosen, chosen.settings.seed) | {"figures": [figure]}

    def settle(self, values: Mapping[str, Any], page: str = "") -> dict[str, Any]:
        """Return the whole evaluation with its scenes. GivenUp as soon as the page has asked something newer."""
        mine = self._ask(page)
        chosen = with_knobs(self.scenario, values)

        def report(text: str, share: float | None) -> None:
            self._check_newest(mine)
            self._done[page] = (text, share)

        try:
            with self._working:
                self._check_newest(mine)
                result = api.uncertainty(chosen, progress=report)
                self._check_newest(mine)
                zones = [decision_chart(c) for c in result.characteristics]
        finally:
            self._done.pop(page, None)
        figures = [figure_of(items)[0] for items in scenes(result)]
        body = {"preview": False, **uncertainty_json(result), "figures": figures, "pictures": zones}
        return document("vcmm.uncertainty/1", body, seed=result.seed, files=[], warnings=result.warnings)

    def job(
        self, name: str, files: Mapping[str, bytes], folder: Path, values: Mapping[str, Any], page: str = ""
    ) -> dict[str, Any]:
        """Run another job: on the task with its knobs at `values`, or with dropped files. GivenUp when it is cancelled."""
        mine = self._ask(page)
        chosen = with_knobs(self.scenario, values)

        def report(text: str, share: float | None) -> None:
            self._check_newest(mine)
            self._done[page] = (text, share)

        try:
            with self._working:
                self._check_newest(mine)
                if files:
                    return run_files(name, files, folder, chosen, report)
                return run_open(name, chosen, report)
        finally:
            self._done.pop(page, None)

    def _ask(self, page: str = "") -> Question:
        with self._asked:
            number = self._newest.pop(page, 0) + 1
            self._newest[page] = number  # the last question is the newest
            if len(self._newest) > MOST_PAGES:
                del self._newest[next(iter(self._newest))]
            return page, number

    def _check_newest(self, question: Question) -> None:
        page, number = question
        if self._newest.get(page) != number:
            raise GivenUp


def diagnose_files(files: Mapping[str, bytes], folder: Path) -> dict[str, Any]:
    """Diagnose a dropped recording: its .toml and the tables that it names. Raises UsageError for other sets of files.

    files: by plain name (checked by the caller); folder: an empty one, in which they are read.
    """
    return run_files("diagnose", files, folder, None, lambda text, share: None)
