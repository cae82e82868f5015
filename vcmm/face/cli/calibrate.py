"""vcmm calibrate: the errors of a machine from readings of instruments on it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from tempfile import TemporaryDirectory
from typing import Annotated, Any, NamedTuple

from cyclopts import Parameter

from vcmm.core.errors import UsageError, VcmmError
from vcmm.core.machine import Machine
from vcmm.core.units import quantity
from vcmm.face.bodies import calibration_json
from vcmm.face.cli.calibrate_given import CalibrationFiles, CalibrationInput
from vcmm.face.cli.options import InputFile, InputName, Json, Seed
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.files.learned.calibrated_machine import machine_texts, residual_texts
from vcmm.files.own.machine import load_machine
from vcmm.files.own.pose_recordings import is_poses
from vcmm.learn.calibration.acceptance import predict_figures, without_rounding
from vcmm.learn.calibration.cross_validation import PredictedPositions, compare_interpolations
from vcmm.learn.calibration.interpolation import interpolation_of
from vcmm.learn.calibration.job import calibrate
from vcmm.learn.calibration.result import Calibration, rms
from vcmm.learn.calibration.verification import IndependentTest
from vcmm.show.console.files import output_folder, write_files, write_text
from vcmm.show.console.terminal import say, say_warnings, show_answers, show_table
from vcmm.show.tables.answers_machine import calibration_answers
from vcmm.show.tables.calibration import HELD_OUT, TESTS, errors, independent_tests, interpolations
from vcmm.show.tables.table import records


def calibrate_command(
    *recordings: InputName, structure: str | None = None, machine: InputFile | None = None, errors: str = "", growth: str | None = None,
    months: float = 1.0, design: InputFile | None = None, simulate: InputFile | None = None, seed: Seed = 0, interpolation: str = "spline",
    compare_interpolations: bool = False, thermal: bool = False, sensors: str = "", nodes: bool = False,
    test: Annotated[list[InputFile] | None, Parameter(name="--test", negative=())] = None, residual: Path | None = None,
    report: Path | None = None, json: Json = False, out: Path | None = None,
) -> int:  # fmt: skip
    """Find the errors of a machine, with their joint covariance, from recordings of any instruments in any mixture.

    Parameters
    ----------
    recordings
        Recording files (recording/1). Files with [reversal] are separated by themselves (docs/reversal.md).
    structure
        Structure of the machine, such as "w b Y X Z t"; not needed with --machine.
    machine
        Machine file that holds what is known already: it is the prior of a recalibration.
    errors
        Errors to look for, such as "EXX EYX C0Y"; all others are then taken as zero. Default: all of the axes that moved.
    growth
        With --machine: by how much errors may change in a month, such as "0.5 um" (u; rotations: over 1 m).
    months
        Since the machine file was found; growth is a random walk, so that 4 months are twice one.
    design
        Plan of set-ups (design/1): says beforehand what they identify and how well, and the cheapest ones that do.
    interpolation
        spline, "gaussian process" (gp), polynomial, table, or a net such as "i-(2i+1)-o" (net).
    compare_interpolations
        Hold out every third position of each line and say how each interpolation predicts it; nothing is written.
    thermal
        Fit effects of temperatures instead: terms of the sensors in the recordings, added to the file of --machine.
    nodes
        Find the scatter of approaches at the nodes of a grid instead, from LaserTracer lengths by four stations or more: a residual field.
    sensors
        With --thermal: the only sensors to look at, such as "spindle air".
    test
        A recording that the calibration does not use (a diagonal, another artefact): what the written file predicts of it.
    residual
        Machine file of the machine with the errors found compensated: the remaining errors, with their uncertainty.
    simulate
        Plan of set-ups (design/1): writes what they would read on the machine of --machine, as recordings in the folder --out.
    seed
        Seed of what is simulated.
    report
        File for the HTML report.
    json
        Print one JSON document.
    out
        Machine file to write; its error table and covariance are written beside it. With --design: folder for design.json.
    """
    wanted = CalibrationFiles(list(recordings), structure, machine, out, test or [])
    if design is not None:
        from vcmm.face.cli.calibrate_design import design_job

        return run_job(design_job(design), Flags(json, out))
    if simulate is not None:
        from vcmm.face.cli.calibrate_simulate import SimulateJob

        return run_job(SimulateJob(simulate, machine, out, seed), Flags(json))
    given: dict[str, Any] = {
        "machine": machine, "errors": errors, "interpolation": interpolation, "thermal": thermal, "sensors": sensors,
        "test": test, "residual": residual, "report": report, "growth": growth, "nodes": nodes,
    }  # fmt: skip
    wanted.check_recordings()
    special = _special(wanted, given | {"interpolation": interpolation != "spline"}, compare_interpolations)
    if special is not None:
        return run_job(special, Flags(json))
    names = errors.replace(",", " ").split()
    calibration_options = CalibrationOptions(names, interpolation, _growth(growth, months, machine))
    return run_job(CalibrateJob(wanted, calibration_options, residual, report), Flags(json))


def _special(wanted: CalibrationFiles, given: dict[str, Any], compare: bool) -> Job[Any, Any] | None:
    """Return the jobs besides a calibration: reversals, the comparison of interpolations, temperatures. given: options of the command."""

    def rest(names: str) -> dict[str, Any]:
        return {name: given[name] for name in names.split()}

    errors, sensors = (given[key].replace(",", " ").split() for key in ("errors", "sensors"))
    turned = wanted.reversals()
    if turned and len(turned) == len(wanted.files) and given["machine"] is None:
        from vcmm.face.cli.calibrate_reversal import ReversalJob

        wanted.without("a reversal", **rest("test residual thermal sensors interpolation growth nodes"))
        others = any(given[name] for name in ("errors", "report"))
        return ReversalJob(wanted.files, wanted.structure, wanted.out, others)
    if turned:
        wanted.without("a reversal", **rest("thermal sensors nodes"), compare_interpolations=compare)
    if any(is_poses(path) for path in wanted.files):
        from vcmm.face.cli.calibrate_arm import ArmJob

        idle = rest("errors interpolation growth thermal sensors nodes residual report")
        wanted.without("a calibration from poses", **idle, compare_interpolations=compare)
        return ArmJob(wanted)
    wanted.check(given["thermal"], given["sensors"], compare)
    if given["nodes"]:
        from vcmm.face.cli.calibrate_nodes import NodesJob

        idle = rest("test residual errors interpolation growth thermal report")
        wanted.without("--nodes", **idle, compare_interpolations=compare)
        return NodesJob(wanted)
    if compare:
        wanted.without("--compare-interpolations", **rest("interpolation residual report growth"))
        return InterpolationsJob(wanted, errors)
    if given["thermal"]:
        from vcmm.face.cli.calibrate_thermal import ThermalJob

        wanted.without("--thermal", **rest("errors interpolation residual growth"))
        return ThermalJob(wanted, sensors, given["report"])
    return None


@dataclass(frozen=True)
class CalibrationOptions:
    """Names of the errors to look for, the interpolation, and by how much (mm) errors may have grown."""

    only: list[str]
    interpolation: str
    growth: float


def _growth(text: str | None, months: float, machine: Path | None) -> float:
    """Return u in mm by which errors have changed since the machine file was made. Raises UsageError."""
    if text is None:
        return 0.0
    rate = quantity(text, "length", "--growth", "0.5 um")
    if machine is None or not (rate > 0 and 0 < months < 1e4):
        raise UsageError(
            f'--growth "{text}" --months {months:g}: a length above zero per month, months above zero, and a machine file with --machine'
        )
    return float(rate * months**0.5)


class Calibrated(NamedTuple):
    """Result of a calibration, and the predictions of the written machine file for the recordings of --test."""

    calibration: Calibration
    tests: list[IndependentTest]


@dataclass(frozen=True)
class CalibrateJob(Job[CalibrationInput, Calibrated]):
    """A calibration. The machine files are written while it runs: predictions come from the written files."""

    request: CalibrationFiles
    options: CalibrationOptions
    residual: Path | None
    report: Path | None
    schema = "vcmm.calibration/1"

    def check(self) -> None:
        """Raises UsageError where the interpolation is none, Environment where a file cannot be written."""
        interpolation_of(self.options.interpolation)
        for target in (self.request.out, self.residual):
            if target is not None:
                output_folder(target.parent)

    def load(self) -> CalibrationInput:
        return self.request.load()

    def run(self, loaded: CalibrationInput, report: Progress) -> Calibrated:
        calibration = calibrate(
            loaded.recordings,
            loaded.machine,
            loaded.certificates,
            self.options.only,
            report,
            interpolation=interpolation_of(self.options.interpolation),
            growth=self.options.growth,
            correlated=loaded.covariances,
        )
        self._write(calibration)
        return Calibrated(calibration, self.request.tests())

    def _write(self, calibration: Calibration) -> None:
        out, machine_file, files = (
            self.request.out,
            self.request.machine,
            [f.name for f in self.request.files],
        )
        texts = {}
        if out is not None:
            texts[out] = machine_texts(calibration, out, files, machine_file)
        if self.residual is not None:
            switched_on = f"{out.stem}_errors.csv" if out is not None else "this calibration"
            texts[self.residual] = residual_texts(
                calibration, self.residual, files, machine_file, switched_on
            )
        for target, written in texts.items():
            write_files(target.parent, written)
            say(f"wrote {target}, {target.stem}_errors.csv, {target.stem}_covariance.csv")

    def record(self, loaded: CalibrationInput, result: Calibrated) -> Record:
        body = calibration_json(result.calibration, self.request.out) | {
            "tests": records(TESTS, result.tests)
        }
        return Record(body, self.request.read(), warnings=result.calibration.warnings)

    def export(self, loaded: CalibrationInput, result: Calibrated, content: dict[str, Any]) -> None:
        """Write the page of --report."""
        if self.report is None:
            return
        from vcmm.show.pages.calibration import calibration_page

        machine = _calibrated_machine(result.calibration, self.request)
        figures = [] if machine is None else without_rounding(predict_figures(machine, "230-2"))[0]
        write_text(self.report, calibration_page(result.calibration, figures, self.request.read()))
        say(f"wrote {self.report}")

    def show(self, loaded: CalibrationInput, result: Calibrated) -> None:
        _show(result.calibration)
        if result.tests:
            show_table(independent_tests(result.tests))


def _calibrated_machine(calibration: Calibration, wanted: CalibrationFiles) -> Machine | None:
    """Return the calibrated machine, as it is written and read again; None where the file is incomplete by itself."""
    if wanted.out is not None:
        return load_machine(wanted.out)
    with TemporaryDirectory() as folder:
        target = Path(folder) / "calibrated.toml"
        try:
            write_files(
                target.parent,
                machine_texts(calibration, target, [f.name for f in wanted.files], wanted.machine),
            )
            return load_machine(target)
        except VcmmError:
            return None


def _show(calibration: Calibration) -> None:
    show_answers(calibration_answers(calibration))
    show_table(errors(calibration))
    print(
        f"residuals: {rms(calibration.residual) * 1e3:.3f} µm rms; condition {calibration.identified.condition:.3g}"
    )
    for radius in calibration.probe_radii():
        print(
            f"{radius['input']}: surfaces read {radius['value_um']:+.2f} ± {2 * radius['u_um']:.2g} µm further out (k = 2): ball and size less pre-travel"
        )
    for c in calibration.identified.combinations:
        print(f"not identified: {c.text}")
    say_warnings(calibration.warnings)


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
