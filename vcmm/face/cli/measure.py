"""vcmm measure: one virtual measurement, of a given part or of one that is cut first."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING

from vcmm.answer.evaluation.virtual_measurement import Measurement
from vcmm.face.api import measure
from vcmm.face.cli.options import InputFile, Json, Seed
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.files.own.library import cuts
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import show_answers, show_table
from vcmm.show.tables.answers_parts import measured_answers
from vcmm.show.tables.measured_points import measure_json, points_csv, values
from vcmm.task.measuring.scenario import Scenario

if TYPE_CHECKING:
    from vcmm.task.measuring.cut_scenario import CutScenario


def measure_command(
    scenario: InputFile,
    *,
    seed: Seed | None = None,
    json: Json = False,
    out: Path | None = None,
) -> int:
    """Measure the part once, virtually: errors at their estimates, or one draw with --seed.

    With a [cut] table the part is cut first, by the same draw of its machine tool, and then inspected.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1).
    seed
        Draw everything that is uncertain once with this seed; without it all errors are at their estimates.
    json
        Print one JSON document.
    out
        Folder for measure.json and points.csv.
    """
    return run_job(MeasureJob(scenario, seed), Flags(json, out))


@dataclass(frozen=True)
class MeasureJob(Job["Scenario | CutScenario", Measurement]):
    """One virtual measurement."""

    scenario: Path
    seed: int | None
    schema = "vcmm.measure/1"

    @property
    def place(self) -> tuple[Path, str]:
        return self.scenario, ""

    def load(self) -> Scenario | CutScenario:
        if cuts(self.scenario):
            from vcmm.files.own.cut_scenario import load_cut

            return load_cut(self.scenario)
        from vcmm.files.own.scenario import load_scenario

        return load_scenario(self.scenario)

    def run(self, loaded: Scenario | CutScenario, report: Progress) -> Measurement:
        return measure(loaded, self.seed)

    def record(self, loaded: Scenario | CutScenario, result: Measurement) -> Record:
        return Record(measure_json(result), sources(self.scenario), self.seed, result.warnings)

    def texts(
        self, loaded: Scenario | CutScenario, result: Measurement, content: str, folder: Path
    ) -> dict[str, str]:
        return {"measure.json": content, "points.csv": points_csv(result)}

    def show(self, loaded: Scenario | CutScenario, result: Measurement) -> None:
        show_answers(measured_answers(result))
        show_table(values(result))
