"""vcmm cut --measured: the part against its prediction, covariates of the difference, and the recording for diagnose."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vcmm.answer.inference.given_points import GivenPoints
from vcmm.face.job import Progress
from vcmm.files.columns import run_columns
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording_writer import save_recording
from vcmm.files.own.setup import load_setup
from vcmm.files.toml import read_toml
from vcmm.shop.machining.measured_part import MeasuredCut, measured_cut
from vcmm.shop.machining.part_recording import part_recording
from vcmm.show.console.complaints import about
from vcmm.show.console.terminal import say, say_warnings, show_answers, show_table
from vcmm.show.tables import cut as tables
from vcmm.show.tables.answers_parts import cut_answers
from vcmm.task.measuring.cut_scenario import CutScenario


@dataclass(frozen=True, eq=False)
class CameBack:
    """Output for the terminal and for the document."""

    cut: MeasuredCut
    recording: Path | None
    warnings: tuple[str, ...]

    @property
    def json(self) -> dict[str, Any]:
        return tables.measured_json(self.cut) | {
            "recording": None if self.recording is None else str(self.recording)
        }

    def show(self) -> None:
        show_answers(cut_answers(self.cut))
        show_table(tables.prediction_table(self.cut))
        if self.cut.mismatch:
            show_table(tables.mismatch(self.cut))
        else:
            print("the measured part is as predicted: no feature, line or covariate departs from it")
        print(f"scatter of a measured point: {self.cut.scatter * 1e3:.2f} µm")
        say_warnings(self.warnings)


def came_back(
    scenario: Path,
    loaded: CutScenario,
    given: tuple[GivenPoints, float | None],
    in_machine: bool,
    seed: int | None,
    folder: Path,
    report: Progress,
) -> CameBack:
    """Compare, and write the recording into a folder."""
    points, u = given
    with about(scenario, "cut"):
        report("comparing the measured part", 0.0)
        cut = measured_cut(loaded, points, in_machine=in_machine, u_point=u, seed=seed)
    machine, why = machine_file(scenario)
    if machine is None:
        return CameBack(cut, None, (*cut.notes, why))
    path = folder / f"{scenario.stem}-measured.toml"
    _write(path, cut, machine)
    say(f"wrote {path}")
    return CameBack(cut, path, tuple(cut.notes))


def machine_file(scenario: Path) -> tuple[Path | None, str]:
    """Return the machine file that a scenario names, itself or in its set-up; else why there is none."""
    data = read_toml(scenario).data
    named = data.get("machine")
    if isinstance(named, str):
        return (scenario.parent / named).resolve(), ""
    if named is None:
        machine = load_setup(scenario.parent / data["cut"]["setup"]).machine
        return (None if machine is None else machine.resolve()), "no machine is named"
    return None, "the machine is inside the scenario: no recording is written; give it a file of its own"


def _write(path: Path, cut: MeasuredCut, machine: Path) -> None:
    recording = part_recording(path.stem, cut, load_machine(machine), frozenset(run_columns()))
    save_recording(recording, path, str(machine), apart=True)
