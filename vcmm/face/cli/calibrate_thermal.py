"""vcmm calibrate --thermal: effects of temperatures on the tip, added to a machine file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from vcmm.core.errors import UsageError
from vcmm.face.cli.calibrate_given import CalibrationFiles, CalibrationInput
from vcmm.face.job import Job, Progress, Record
from vcmm.files.learned.thermal_terms import thermal_text, written_terms
from vcmm.files.own.recording import load_recording
from vcmm.learn.calibration.thermal import ThermalModel, thermal_model
from vcmm.learn.calibration.thermal_net import net_left
from vcmm.learn.calibration.thermal_terms import warm_readings
from vcmm.learn.calibration.verification import IndependentTest
from vcmm.show.console.files import output_folder, write_text
from vcmm.show.console.terminal import say, show_answers, show_table
from vcmm.show.pages.thermal import thermal_page
from vcmm.show.tables.answers_runs import thermal_answers
from vcmm.show.tables.calibration import TESTS, independent_tests
from vcmm.show.tables.table import records
from vcmm.show.tables.thermal import TERMS, term_rows, terms
from vcmm.task.response.recording import Recording


class ThermalInput(NamedTuple):
    """Recordings and machine as of a calibration, and the recordings of --test."""

    calibration: CalibrationInput
    tests: list[Recording]


class ThermalTerms(NamedTuple):
    """The terms, and the predictions of the written file for --test; nets: residual in um of a net from the same sensors for each."""

    model: ThermalModel
    tests: list[IndependentTest]
    nets: list[float]


@dataclass(frozen=True)
class ThermalJob(Job[ThermalInput, ThermalTerms]):
    """The terms fitted and written: predictions come from the written file."""

    request: CalibrationFiles
    sensors: list[str]
    report: Path | None = None
    schema = "vcmm.thermal/1"

    def load(self) -> ThermalInput:
        given = self.request.load()
        for file in (self.request.out, self.report):
            if file is not None:
                output_folder(file.parent)
        tests = [load_recording(path, given.machine)[0] for path in self.request.test]
        for recording in tests:
            warm_readings(recording, given.machine)  # refused before anything is written
        return ThermalInput(given, tests)

    def run(self, loaded: ThermalInput, report: Progress) -> ThermalTerms:
        given, wanted = loaded.calibration, self.request
        if wanted.machine is None:
            raise UsageError("--thermal adds to a machine file; name it with --machine machine.toml")
        model = thermal_model(given.recordings, given.machine, self.sensors)
        written_terms(model)  # refused before anything is written
        if wanted.out is not None:
            files = [f.name for f in wanted.files]
            write_text(wanted.out, thermal_text(model, given.machine, wanted.machine, wanted.out, files))
            say(f"wrote {wanted.out}")
        if self.report is not None:
            write_text(
                self.report, thermal_page(model, given.machine, term_rows(model, written_terms(model)))
            )
            say(f"wrote {self.report}")
        return ThermalTerms(model, wanted.tests(), _nets(loaded.tests, given, list(model.trained)))

    def record(self, loaded: ThermalInput, result: ThermalTerms) -> Record:
        model, tests, nets = result
        rows, out = term_rows(model, written_terms(model)), self.request.out
        body = {
            "machine": None if out is None else str(out),
            "terms": records(TERMS, rows),
            **_figures(model),
        }
        body |= {"tests": [t | {"net_rms": n} for t, n in zip(records(TESTS, tests), nets)]}
        return Record(body, self.request.read())

    def show(self, loaded: ThermalInput, result: ThermalTerms) -> None:
        model, tests, nets = result
        rows = term_rows(model, written_terms(model))
        show_answers(thermal_answers(model, len(rows)))
        show_table(terms(rows))
        _show(model)
        if tests:
            show_table(independent_tests(tests))
        for test, left in zip(tests, nets):
            print(f"a net from the same sensors leaves {left:.3f} µm of {test.name} (compared, not written)")


def _nets(tests: Sequence[Recording], given: CalibrationInput, sensors: list[str]) -> list[float]:
    """Return the residuals in um of a net from the same sensors for every test."""
    return [net_left(given.recordings, recording, given.machine, sensors) * 1e3 for recording in tests]


def _figures(model: ThermalModel) -> dict[str, object]:
    before, after = model.held_out
    return {
        "rms_before_um": model.before * 1e3,
        "rms_after_um": model.after * 1e3,
        "held_out": {"rms_before_um": before * 1e3, "rms_after_um": after * 1e3},
        "outliers": model.outliers,
        "trained_degC": {s: list(r) for s, r in model.trained.items()},
        "not_used": model.unused_sensors,
    }


def _show(model: ThermalModel) -> None:
    before, after = model.held_out
    print(f"all readings: {model.before * 1e3:.2f} -> {model.after * 1e3:.2f} µm rms")
    print(f"blocks of time predicted from the others: {before * 1e3:.2f} -> {after * 1e3:.2f} µm rms")
    if model.outliers:
        print(f"{model.outliers} single readings stand out from their neighbours and were left out")
    for sensor, why in model.unused_sensors.items():
        print(f"not used: {sensor}: {why}")
