"""vcmm check: read a file and everything it names; report errors, or a summary of the content."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

import numpy as np

from vcmm.core.errors import DataError, did_you_mean
from vcmm.core.inputs import Input
from vcmm.core.machine import Machine
from vcmm.face.cli.options import InputFile, Json
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.files.own.certificate import stated_certificate
from vcmm.files.own.library import cuts
from vcmm.files.own.machine import load_machine, load_machine_of
from vcmm.files.problems import Problems, misspelt
from vcmm.files.toml import read_toml
from vcmm.program.setup import Setup
from vcmm.show.console.complaints import about
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import show_table
from vcmm.show.tables.table import listing

if TYPE_CHECKING:
    from vcmm.task.measuring.cut_scenario import CutScenario
    from vcmm.task.measuring.scenario import Scenario
    from vcmm.task.measuring.task import Task

FILE_KINDS = ("scenario", "machine", "setup", "recording")


def check_command(file: InputFile, *, json: Json = False, out: Path | None = None) -> int:
    """Check a machine, scenario, set-up or recording file: all problems at once, each with file, line and fix.

    Exit code 1: the file is right, but with its program part or tool would be spoilt.

    Parameters
    ----------
    file
        Machine (machine/1), scenario (scenario/1), set-up (setup/1) or recording (recording/1) file.
    json
        Print one JSON document.
    out
        Folder for check.json.
    """
    return run_job(CheckJob(file), Flags(json, out))


Row = list[str]  # what it is, and how it was understood


class CheckedFile(NamedTuple):
    """Summary of a file; losses: remarks after which part or tool would be spoilt."""

    rows: list[Row]
    losses: list[str]


@dataclass(frozen=True)
class CheckJob(Job[str, CheckedFile]):
    """One file and everything that it names, read. Loaded: its kind."""

    file: Path
    schema = "vcmm.check/1"

    def load(self) -> str:
        head = read_toml(self.file)
        kind = str(head.data.get("vcmm", "")).split("/")[0]
        if kind in FILE_KINDS:
            return kind
        hint = did_you_mean(kind, FILE_KINDS) if kind else misspelt("vcmm", head.data)
        raise DataError(
            f'{head.where(("vcmm",))}: the first line must be vcmm = "scenario/1", "machine/1", "setup/1" or "recording/1".{hint}'
        )

    def run(self, loaded: str, report: Progress) -> CheckedFile:
        read = {
            "machine": _machine_rows,
            "scenario": _scenario_rows,
            "setup": _setup_rows,
            "recording": _recording_rows,
        }
        rows = read[loaded](self.file)
        return CheckedFile(rows, [text for name, text in rows if name.startswith("remark ") and spoils(text)])

    def record(self, loaded: str, result: CheckedFile) -> Record:
        body = {
            "file": str(self.file), "kind": loaded, "understood": dict(result.rows), "spoilt": result.losses,
        }  # fmt: skip
        return Record(body, sources(self.file))

    def texts(self, loaded: str, result: CheckedFile, content: str, folder: Path) -> dict[str, str]:
        return {"check.json": content}

    def exit_code(self, loaded: str, result: CheckedFile) -> int:
        return int(bool(result.losses))

    def show(self, loaded: str, result: CheckedFile) -> None:
        lost = [["spoilt", text] for text in result.losses]
        title = f"the file is right, the program is not: {len(lost)} remarks" if lost else "no problems found"
        rows = [*lost, *result.rows]
        show_table(listing(f"{self.file}: {title}", ["", "understood as"], rows, words=(0, 1)))


SPOILS = ("itself gouges", "would break", "the shank of tool")  # in a remark: part or tool are lost


def spoils(remark: str) -> bool:
    """Return whether a remark on a program implies that the part or the tool would not survive it."""
    return any(words in remark for words in SPOILS)


def _machine_rows(file: Path) -> list[Row]:
    machine = load_machine(file)
    lines = [[f"remark {i}", text] for i, text in enumerate(machine.remarks, 1)]
    return _describe_machine(machine) + _certificate_rows(file, machine) + lines


def _certificate_rows(file: Path, machine: Machine) -> list[Row]:
    """Return how often a machine as this file describes it passes the test of the certificate that it states."""
    certificate = stated_certificate(file)
    if certificate is None:
        return []
    from vcmm.learn.calibration.acceptance import predict_figures

    if any(i.evidence == certificate.words() for i in machine.inputs):
        return [["certificate", f"{certificate.words()}; the errors are drawn from it"]]
    rows = []
    for test in ("10360-2", "230-2"):
        if limits := certificate.limits(test):
            for figure in predict_figures(machine, test, limits, trials=400):
                if figure.p_pass is not None:
                    doubt = "" if figure.p_pass >= 0.5 else ": errors or certificate are wrong"
                    rows.append(
                        [
                            f"certificate {figure.name}",
                            f"kept in {figure.p_pass:.0%} of drawn machines{doubt}",
                        ]
                    )
    return rows


def _describe_machine(machine: Machine) -> list[Row]:
    rows = [["machine", f"{machine.name} ({machine.kind}), structure {machine.chain.structure}"]]
    for letter, axis in machine.axes.items():
        scale, unit = (57.29577951308232, "deg") if axis.rotary else (1.0, "mm")
        ends = f"{axis.travel[0] * scale:g} to {axis.travel[1] * scale:g} {unit}"
        rows.append([f"axis {letter}", f"travel {'endless' if axis.is_endless else ends}"])
    names: dict[str, list[str]] = {}
    for effect in machine.effects:
        names.setdefault(effect.name, []).append(effect.where)
    rows += [
        [f"effect {name}", " ".join(w for w in where if w) or "whole machine"]
        for name, where in names.items()
    ]
    rows += [[f"input {i.id}", f"{_law(i)}, redraw {i.redraw}"] for i in machine.inputs]
    return rows


def _law(quantity: Input) -> str:
    name = str(getattr(quantity.law, "name", type(quantity.law).__name__))
    if not np.isfinite(quantity.law.u).all():
        name += " (u is infinite for nu <= 2; the coverage interval is given)"
    return name


def _setup_rows(file: Path) -> list[Row]:
    from vcmm.files.own.setup import load_setup

    setup = load_setup(file)
    problems = Problems(read_toml(file))
    named = setup.machine
    machine = problems.attempt(("machine",), lambda: load_machine(named)) if named else None
    problems.raise_if_any()
    rows = _describe_machine(machine) if machine else []
    rows.append(["dialect", setup.dialect or "guessed from the program"])
    return rows + _tool_rows(setup)


def _tool_rows(setup: Setup) -> list[Row]:
    """Return the work offsets and tools of a set-up."""
    rows = []
    for name, point in setup.offsets.items():
        rows.append([f"offset {name}", "work zero at " + " ".join(f"{v:g}" for v in point) + " mm"])
    for number, tool in setup.tools.items():
        if tool.shape == "turning":
            nose = (
                "nose radius not stated" if not tool.nose_radius else f"nose radius {tool.nose_radius:g} mm"
            )
            text = f"turning, {nose}, orientation {tool.orientation}, offsets X {tool.offset_x:g} mm (radius), Z {tool.length:g} mm"
            rows.append([f"tool {number}", text])
            continue
        size = "diameter not stated" if tool.diameter is None else f"diameter {tool.diameter:g} mm"
        rows.append([f"tool {number}", f"{tool.shape}, length {tool.length:g} mm, {size}"])
    return rows


def _reversal_rows(file: Path) -> list[Row]:
    from vcmm.files.own.reversal import load_reversal

    reversal_file = load_reversal(file)
    rows = [["reversal", f"{reversal_file.kind}, {reversal_file.error} of axis {reversal_file.axis}"]]
    rows += [
        [f"turns {g.setup} {g.probe}".rstrip(), f"{len(g.coefficients)} whole, {g.incomplete} left out"]
        for g in reversal_file.groups
    ]
    return rows + [
        [f"scan {s.setup}", f"{len(s.place)} readings, {s.place.min():g} to {s.place.max():g} mm"]
        for s in reversal_file.scans
    ]


def _recording_rows(file: Path) -> list[Row]:
    """Return the observed quantities, and questions that a diagnosis cannot answer from them."""
    from vcmm.files.own.instruments import load_certificate
    from vcmm.files.own.recording import load_recording
    from vcmm.files.own.reversal import is_reversal
    from vcmm.task.response.observe import left_out

    if is_reversal(file):
        return _reversal_rows(file)
    recording, machine = load_recording(file)
    load_certificate(file, recording)
    counted = {name: len(set(words)) for name, words in recording.run.labels.items()}
    rows = [
        [
            "recording",
            f"{recording.kind}, {recording.m} observations, {'indicated - true' if recording.measuring else 'actual - commanded'}",
        ],
        ["labels", ", ".join(f"{name}: {k}" for name, k in sorted(counted.items())) or "none"],
        ["columns", ", ".join(sorted(recording.run.columns))],
        ["logs", ", ".join(sorted(recording.run.series)) or "none"],
        [
            "nuisance",
            ", ".join(_per(a, b, counted) for a, b in recording.nuisance.items()) or "none",
        ],
    ]
    if recording.missing:
        rows.append(["not in the file", ", ".join(recording.missing)])
    rows += [
        [f"effect {name}", f"cannot show: no {', '.join(c)}"] for name, c in left_out(recording, machine)
    ]
    return rows + _describe_machine(machine)


def _per(word: str, label: str, counted: dict[str, int]) -> str:
    absent = label not in ("", "run") and label not in counted
    return f"{word} for all rows (no column {label})" if absent else f"{word} per {label or 'recording'}"


def _scenario_rows(file: Path) -> list[Row]:
    return _cutting_rows(file) if cuts(file) else _measuring_rows(file)


def _cutting_rows(file: Path) -> list[Row]:
    """Return everything short of the uncertainty: program read and timed, tools swept, every feature reached by a cutter."""
    from vcmm.files.own.cut_scenario import load_cut
    from vcmm.shop.machining.job import finished_part
    from vcmm.shop.machining.preparation import remarks, set_up

    scenario = load_cut(file)
    with about(file):
        shop = set_up(scenario)
        task, world, notes = finished_part(shop)
        world.errors(), world.influences()
    minutes, seconds = divmod(shop.seconds, 60)
    rows = [["scenario", scenario.name], *_describe_machine(scenario.machine)]
    rows += [
        [
            "program",
            f"{scenario.program.name}: {len(shop.program.moves)} moves, {minutes:.0f} min {seconds:.0f} s",
        ]
    ]
    rows += _tool_rows(scenario.setup)
    rows += [
        [
            "inspection",
            f"{scenario.inspection.kind}, {task.touches.run.n} points, all cut and within the travels",
        ]
    ]
    return (
        rows
        + _known_rows(scenario, task)
        + [[f"remark {i}", w] for i, w in enumerate(dict.fromkeys((*remarks(shop), *notes)), 1)]
    )


def _known_rows(scenario: Scenario | CutScenario, task: Task) -> list[Row]:
    """Return the features, characteristics, and the inputs that are not the machine's."""
    rows = [[f"feature {n}", f.kind] for n, f in scenario.part.features.items()]
    rows += [[f"characteristic {c.name}", c.type] for c in scenario.part.characteristics]
    inputs = scenario.machine.inputs
    return rows + [[f"input {i.id}", f"{_law(i)}, redraw {i.redraw}"] for i in task.inputs if i not in inputs]


def _measuring_rows(file: Path) -> list[Row]:
    from vcmm.answer.evaluation.checks import remarks
    from vcmm.files.own.scenario import load_scenario

    scenario = load_scenario(file)
    with about(file):
        task = scenario.task()
        refused = _evaluate(task)
    rows = [["scenario", scenario.name], *_describe_machine(scenario.machine)]
    rows += _certificate_rows(file, load_machine_of(file))
    touches = f"{task.touches.run.n} touches in {len(scenario.plan.steps)} steps, all within the travels"
    rows += [["plan", touches], *_known_rows(scenario, task)]
    warnings = (*remarks(scenario), *refused)
    rows += [[f"remark {i}", text] for i, text in enumerate(warnings, 1)]
    return rows


def _evaluate(task: Task) -> list[str]:
    """Prepare the job as `uncertainty` does; evaluate every effect, input, fit and characteristic once. Remarks name data that only
    `uncertainty` lacks."""
    from vcmm.answer.evaluation.linear import prepare_model
    from vcmm.task.measuring.task import evaluate_all, fit_features, measured_points

    errors = task.machine.indication_error(task.touches.run)
    evaluate_all(task, fit_features(task, measured_points(task, errors)))
    if task.part.characteristics and task.inputs:
        prepare_model(task)
        return []
    missing = "characteristics" if task.inputs else "inputs (nothing is uncertain)"
    return [f"measure works, uncertainty and place do not: the scenario has no {missing}"]
