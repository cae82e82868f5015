"""vcmm calibrate --compare-interpolations: predictions of each for positions that were held out."""

from __future__ import annotations

from dataclasses import dataclass

from vcmm.face.cli.calibrate_given import CalibrationFiles, CalibrationInput
from vcmm.face.job import Job, Progress, Record
from vcmm.learn.calibration.cross_validation import PredictedPositions, compare_interpolations
from vcmm.show.console.terminal import show_table
from vcmm.show.tables.calibration import HELD_OUT, interpolations
from vcmm.show.tables.table import records


@dataclass(frozen=True)
class InterpolationsJob(Job[CalibrationInput, list[PredictedPositions]]):
    """Every interpolation fitted and scored."""

    request: CalibrationFiles
    only: list[str]
    schema = "vcmm.interpolations/1"

    def load(self) -> CalibrationInput:
        return self.request.load()

    def run(self, loaded: CalibrationInput, report: Progress) -> list[PredictedPositions]:
        return compare_interpolations(
            loaded.recordings, loaded.machine, loaded.certificates, self.only, report
        )

    def record(self, loaded: CalibrationInput, result: list[PredictedPositions]) -> Record:
        return Record({"interpolations": records(HELD_OUT, result)}, self.request.read(), 0)

    def show(self, loaded: CalibrationInput, result: list[PredictedPositions]) -> None:
        show_table(interpolations(result))
