"""vcmm calibrate: the errors of a machine from what instruments read on it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from vcmm.face.cli.options import Seed


def calibrate_command(
    *recordings: Path, structure: str | None = None, machine: Path | None = None, errors: str = "", growth: str | None = None,
    months: float = 1.0, design: Path | None = None, simulate: Path | None = None, seed: Seed = 0, interpolation: str = "spline",
    compare_interpolations: bool = False, thermal: bool = False, sensors: str = "", nodes: bool = False,
    test: Annotated[list[Path] | None, Parameter(name="--test", negative=())] = None, residual: Path | None = None,
    report: Path | None = None, json: Annotated[bool, Parameter(name="--json")] = False, out: Path | None = None,
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
        Find what temperatures do instead: terms of the sensors in the recordings, added to the file of --machine.
    nodes
        Find the scatter of approaches at the nodes of a grid instead, from LaserTracer lengths by four stations or more: a residual field.
    sensors
        With --thermal: the only sensors to look at, such as "spindle air".
    test
        A recording that the calibration does not use (a diagonal, another artefact): what the written file predicts of it.
    residual
        Machine file of the machine with what was found compensated: what is left, with its uncertainty.
    simulate
        Plan of set-ups (design/1): writes what they would read on the machine of --machine, as recordings in the folder --out.
    seed
        Seed of what is simulated.
    report
        File for the HTML report.
    json
        Print one JSON document.
    out
        Machine file to write; its error table and covariance stand beside it.
    """
    from vcmm.face.cli.calibrate_given import CalibrationFiles

    wanted = CalibrationFiles(list(recordings), structure, machine, out, test or [])
    if design is not None or simulate is not None:
        return _plan(design, simulate, wanted, seed, json)
    given: dict[str, Any] = {
        "machine": machine, "errors": errors, "interpolation": interpolation, "thermal": thermal, "sensors": sensors,
        "test": test, "residual": residual, "report": report, "growth": growth, "nodes": nodes,
    }  # fmt: skip
    return _run(wanted, given, months, compare_interpolations, json)


def _run(wanted: Any, given: dict[str, Any], months: float, compare: bool, json: bool) -> int:
    """The calibration, or the job besides one that is asked for. given: options of the command."""
    wanted.check_recordings()
    kind = given["interpolation"]
    special = _special(wanted, given | {"interpolation": kind != "spline"}, compare, json)
    if special is None:
        names = given["errors"].replace(",", " ").split()
        asked = CalibrationOptions(names, kind, _growth(given["growth"], months, given["machine"]))
        _answer(_calibrate(wanted, asked, given["residual"]), wanted, given["report"], json)
    return special or 0


def _special(wanted: Any, given: dict[str, Any], compare: bool, json: bool) -> int | None:
    """The jobs besides a calibration: reversals, the comparison of interpolations, temperatures. given: options of the command."""

    def rest(names: str) -> dict[str, Any]:
        return {name: given[name] for name in names.split()}

    errors, sensors = (given[key].replace(",", " ").split() for key in ("errors", "sensors"))
    turned = wanted.reversals()
    if turned and len(turned) == len(wanted.files) and given["machine"] is None:
        from vcmm.face.cli.calibrate_reversal import reversal_command

        wanted.without("a reversal", **rest("test residual thermal sensors interpolation growth nodes"))
        others = [given[name] for name in ("errors", "report")]
        return reversal_command(wanted.files, wanted.structure, wanted.out, json, others)
    if turned:
        wanted.without("a reversal", **rest("thermal sensors nodes"), compare_interpolations=compare)
    wanted.check(given["thermal"], given["sensors"], compare)
    if given["nodes"]:
        from vcmm.face.cli.calibrate_nodes import nodes_command

        idle = rest("test residual errors interpolation growth thermal report")
        wanted.without("--nodes", **idle, compare_interpolations=compare)
        return nodes_command(wanted, json)
    if compare:
        from vcmm.face.cli.calibrate_compare import interpolations_command

        wanted.without("--compare-interpolations", **rest("interpolation residual report growth"))
        return interpolations_command(wanted, errors, json)
    if given["thermal"]:
        from vcmm.face.cli.calibrate_thermal import thermal_command

        wanted.without("--thermal", **rest("errors interpolation residual growth"))
        return thermal_command(wanted, sensors, json, given["report"])
    return None


def _plan(design: Path | None, simulate: Path | None, wanted: Any, seed: int, json: bool) -> int:
    """What planned set-ups identify, or what they would read."""
    if design is not None:
        from vcmm.face.cli.calibrate_design import design_command

        return design_command(design, json)
    from vcmm.face.cli.calibrate_simulate import simulate_command

    assert simulate is not None
    return simulate_command(simulate, wanted.machine, wanted.out, seed, json)


def _answer(found: Any, wanted: Any, report: Path | None, json: bool) -> None:
    """The document or the tables, and the report."""
    from vcmm.face.bodies import calibration_json
    from vcmm.show.console.documents import document, print_json
    from vcmm.show.console.terminal import show_table
    from vcmm.show.tables.calibration import TESTS, independent_tests
    from vcmm.show.tables.table import records

    tests = wanted.tests()
    if report is not None:
        _report(found, report, wanted)
    if json:
        body = calibration_json(found, wanted.out) | {"tests": records(TESTS, tests)}
        print_json(document("vcmm.calibration/1", body, files=wanted.read(), warnings=found.warnings))
        return
    _show(found)
    if tests:
        show_table(independent_tests(tests))


@dataclass(frozen=True)
class CalibrationOptions:
    """Names of the errors to look for, the interpolation, and by how much (mm) errors may have grown."""

    only: list[str]
    interpolation: str
    growth: float


def _growth(text: str | None, months: float, machine: Path | None) -> float:
    """u in mm of what errors have changed by since the machine file was found. Raises UsageError."""
    from vcmm.core.errors import UsageError
    from vcmm.core.units import quantity

    if text is None:
        return 0.0
    rate = quantity(text, "length", "--growth", "0.5 um")
    if machine is None or not (rate > 0 and 0 < months < 1e4):
        raise UsageError(
            f'--growth "{text}" --months {months:g}: a length above zero per month, months above zero, and a machine file with --machine'
        )
    return float(rate * months**0.5)


def _calibrate(wanted: Any, asked: CalibrationOptions, residual: Path | None) -> Any:
    """The calibration; its machine files are written where they shall be."""
    from vcmm.files.learned.calibrated_machine import machine_texts, residual_texts
    from vcmm.learn.calibration.interpolation import interpolation_of
    from vcmm.learn.calibration.job import calibrate
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import progress, say

    kind, out, files = interpolation_of(asked.interpolation), wanted.out, [f.name for f in wanted.files]
    for target in (out, residual):
        if target is not None:
            output_folder(target.parent)
    given = wanted.load()
    with progress() as show:
        found = calibrate(
            given.recordings,
            given.machine,
            given.certificates,
            asked.only,
            show,
            interpolation=kind,
            growth=asked.growth,
            correlated=given.correlated,
        )
    texts = {}
    if out is not None:
        texts[out] = machine_texts(found, out, files, wanted.machine)
    if residual is not None:
        switched_on = f"{out.stem}_errors.csv" if out is not None else "this calibration"
        texts[residual] = residual_texts(found, residual, files, wanted.machine, switched_on)
    for target, written in texts.items():
        write_files(target.parent, written)
        say(f"wrote {target}, {target.stem}_errors.csv, {target.stem}_covariance.csv")
    return found


def _report(found: Any, path: Path, wanted: Any) -> None:
    from vcmm.learn.calibration.acceptance import predict_figures, without_rounding
    from vcmm.show.console.files import write_text
    from vcmm.show.console.terminal import say
    from vcmm.show.pages.calibration import calibration_page

    machine = _calibrated_machine(found, wanted)
    figures = [] if machine is None else without_rounding(predict_figures(machine, "230-2"))[0]
    write_text(path, calibration_page(found, figures, wanted.read()))
    say(f"wrote {path}")


def _calibrated_machine(found: Any, wanted: Any) -> Any:
    """The machine with what was found, as it is written and read again; None where the file cannot stand by itself."""
    from tempfile import TemporaryDirectory

    from vcmm.core.errors import VcmmError
    from vcmm.files.learned.calibrated_machine import machine_texts
    from vcmm.files.own.machine import load_machine
    from vcmm.show.console.files import write_files

    if wanted.out is not None:
        return load_machine(wanted.out)
    with TemporaryDirectory() as folder:
        target = Path(folder) / "calibrated.toml"
        try:
            write_files(
                target.parent, machine_texts(found, target, [f.name for f in wanted.files], wanted.machine)
            )
            return load_machine(target)
        except VcmmError:
            return None


def _show(found: Any) -> None:
    from vcmm.learn.calibration.result import rms
    from vcmm.show.console.terminal import say_warnings, show_answers, show_table
    from vcmm.show.tables.answers_machine import calibration_answers
    from vcmm.show.tables.calibration import errors

    show_answers(calibration_answers(found))
    show_table(errors(found))
    print(f"residuals: {rms(found.residual) * 1e3:.3f} µm rms; condition {found.identified.condition:.3g}")
    for one in found.probe_radii():
        print(
            f"{one['input']}: surfaces read {one['value_um']:+.2f} ± {2 * one['u_um']:.2g} µm further out (k = 2): ball and size less pre-travel"
        )
    for c in found.identified.combinations:
        print(f"not identified: {c.text}")
    say_warnings(found.warnings)
