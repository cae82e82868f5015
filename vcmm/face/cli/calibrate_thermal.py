"""vcmm calibrate --thermal: effects of temperatures on the tip, added to a machine file."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

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
        asked = [load_recording(path, given.machine)[0] for path in self.request.test]
        for one in asked:
            warm_readings(one, given.machine)  # refused before anything is written
        return ThermalInput(given, asked)

    def run(self, loaded: ThermalInput, report: Progress) -> ThermalTerms:
        given, wanted = loaded.calibration, self.request
        if wanted.machine is None:
            raise UsageError("--thermal adds to a machine file; name it with --machine machine.toml")
        found = thermal_model(given.recordings, given.machine, self.sensors)
        written_terms(found)  # refused before anything is written
        if wanted.out is not None:
            files = [f.name for f in wanted.files]
            write_text(wanted.out, thermal_text(found, given.machine, wanted.machine, wanted.out, files))
            say(f"wrote {wanted.out}")
        if self.report is not None:
            write_text(
                self.report, thermal_page(found, given.machine, term_rows(found, written_terms(found)))
            )
            say(f"wrote {self.report}")
        return ThermalTerms(found, wanted.tests(), _nets(loaded.tests, given, list(found.trained)))

    def record(self, loaded: ThermalInput, result: ThermalTerms) -> Record:
        found, tests, nets = result
        rows, out = term_rows(found, written_terms(found)), self.request.out
        body = {
            "machine": None if out is None else str(out),
            "terms": records(TERMS, rows),
            **_figures(found),
        }
        body |= {"tests": [t | {"net_rms": n} for t, n in zip(records(TESTS, tests), nets)]}
        return Record(body, self.request.read())

    def show(self, loaded: ThermalInput, result: ThermalTerms) -> None:
        found, tests, nets = result
        rows = term_rows(found, written_terms(found))
        show_answers(thermal_answers(found, len(rows)))
        show_table(terms(rows))
        _show(found)
        if tests:
            show_table(independent_tests(tests))
        for test, left in zip(tests, nets):
            print(f"a net from the same sensors leaves {left:.3f} µm of {test.name} (compared, not written)")


def _nets(asked: Sequence[Recording], given: CalibrationInput, sensors: list[str]) -> list[float]:
    """Return the residuals in um of a net from the same sensors for every test."""
    return [net_left(given.recordings, one, given.machine, sensors) * 1e3 for one in asked]


def _figures(found: ThermalModel) -> dict[str, Any]:
    before, after = found.held_out
    return {
        "rms_before_um": found.before * 1e3,
        "rms_after_um": found.after * 1e3,
        "held_out": {"rms_before_um": before * 1e3, "rms_after_um": after * 1e3},
        "outliers": found.outliers,
        "trained_degC": {s: list(r) for s, r in found.trained.items()},
        "not_used": found.unused,
    }


def _show(found: ThermalModel) -> None:
    before, after = found.held_out
    print(f"all readings: {found.before * 1e3:.2f} -> {found.after * 1e3:.2f} µm rms")
    print(f"blocks of time predicted from the others: {before * 1e3:.2f} -> {after * 1e3:.2f} µm rms")
    if found.outliers:
        print(f"{found.outliers} single readings stand out from their neighbours and were left out")
    for sensor, why in found.unused.items():
        print(f"not used: {sensor}: {why}")
