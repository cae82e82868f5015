"""vcmm calibrate fit | design | program | simulate | thermal | nodes | face | compare: each with the options it has, and no others.

Without such a word `vcmm calibrate` takes all options at once, as before (`--design`, `--thermal` ...).
"""

from __future__ import annotations

from collections.abc import Callable
from pathlib import Path
from typing import Annotated, Literal

from cyclopts import App, Parameter

from vcmm.face.cli.calibrate import calibrate_command
from vcmm.face.cli.options import Decimals, InputFile, Json, Seed
from vcmm.face.job import Flags, run_job

Tests = Annotated[list[InputFile] | None, Parameter(name="--test", negative=())]


def fit_command(
    *recordings: InputFile,
    structure: str | None = None,
    machine: InputFile | None = None,
    errors: str = "",
    growth: str | None = None,
    months: float = 1.0,
    interpolation: str = "spline",
    test: Tests = None,
    residual: Path | None = None,
    report: Path | None = None,
    json: Json = False,
    out: Path | None = None,
) -> int:
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
    interpolation
        spline, "gaussian process" (gp), polynomial, table, or a net such as "i-(2i+1)-o" (net).
    test
        A recording that the calibration does not use (a diagonal, another artefact): what the written file predicts of it.
    residual
        Machine file of the machine with the errors found compensated: the remaining errors, with their uncertainty.
    report
        File for the HTML report.
    json
        Print one JSON document.
    out
        Machine file to write; its error table and covariance are written beside it.
    """
    return calibrate_command(
        *recordings, structure=structure, machine=machine, errors=errors, growth=growth, months=months,
        interpolation=interpolation, test=test, residual=residual, report=report, json=json, out=out,
    )  # fmt: skip


def design_command(plan: InputFile, *, json: Json = False, out: Path | None = None) -> int:
    """Say beforehand what planned set-ups identify and how well, and the cheapest ones that do.

    Exit code 1: even all set-ups, or all poses, leave a combination open.

    Parameters
    ----------
    plan
        Plan of set-ups (design/1).
    json
        Print one JSON document.
    out
        Folder for design.json.
    """
    return calibrate_command(design=plan, json=json, out=out)


def program_command(
    plan: InputFile,
    *,
    control: Literal["fanuc", "haas", "sinumerik", "heidenhain"],
    tool: int = 20,
    json: Json = False,
    out: Path,
) -> int:
    """Write the touches of a plan as a program of the control, with the recording file for its log.

    Parameters
    ----------
    plan
        Plan (design/1) with one set-up of a "touch probe"; with a budget the best rotary positions within it, else all.
    control
        Whose macros: fanuc and haas (G65 P9811), sinumerik (CYCLE978), heidenhain (TCH PROBE 427).
    tool
        Number of the probe in the tool table.
    json
        Print one JSON document.
    out
        Folder for the program, touch.toml and setup.toml.
    """
    from vcmm.face.cli.calibrate_program import ProgramJob

    return run_job(ProgramJob(plan, control, out, tool), Flags(json, out))


def simulate_command(
    plan: InputFile,
    *,
    machine: InputFile | None = None,
    seed: Seed = 0,
    json: Json = False,
    out: Path | None = None,
) -> int:
    """Write what planned set-ups would read on a machine, as recordings.

    Parameters
    ----------
    plan
        Plan of set-ups (design/1).
    machine
        Machine file: the truth that the instruments read.
    seed
        Seed of what is simulated.
    json
        Print one JSON document.
    out
        Folder for the recordings.
    """
    return calibrate_command(simulate=plan, machine=machine, seed=seed, json=json, out=out)


def thermal_command(
    *recordings: InputFile,
    machine: InputFile | None = None,
    sensors: str = "",
    test: Tests = None,
    report: Path | None = None,
    json: Json = False,
    out: Path | None = None,
) -> int:
    """Fit effects of temperatures: terms of the sensors in the recordings, added to a machine file.

    Parameters
    ----------
    recordings
        Recording files (recording/1) with columns of temperatures.
    machine
        Machine file that the terms are added to.
    sensors
        The only sensors to look at, such as "spindle air". Default: all.
    test
        A recording that the fit does not use: what the written file predicts of it.
    report
        File for the HTML report: temperatures and drift over time, before and after.
    json
        Print one JSON document.
    out
        Machine file to write.
    """
    return calibrate_command(
        *recordings,
        machine=machine,
        thermal=True,
        sensors=sensors,
        test=test,
        report=report,
        json=json,
        out=out,
    )


def nodes_command(
    *recordings: InputFile,
    structure: str | None = None,
    machine: InputFile | None = None,
    json: Json = False,
    out: Path | None = None,
) -> int:
    """Find the scatter of approaches at the nodes of a grid, from LaserTracer lengths by four stations or more: a residual field.

    Parameters
    ----------
    recordings
        Recording files (recording/1) of kind length.
    structure
        Structure of the machine, such as "w b Y X Z t"; not needed with --machine.
    machine
        Machine file that holds what is known already.
    json
        Print one JSON document.
    out
        Machine file to write.
    """
    return calibrate_command(
        *recordings, structure=structure, machine=machine, nodes=True, json=json, out=out
    )


def face_command(
    scan: InputFile,
    *,
    machine: InputFile | None = None,
    program: InputFile | None = None,
    setup: InputFile | None = None,
    lines: str = "",
    tolerance: str = "1 um",
    decimals: Decimals = None,
    json: Json = False,
    out: Path | None = None,
) -> int:
    """Map a turned or milled face from a spiral or raster scan on the machine that made it, and correct the program that cut it.

    Parameters
    ----------
    scan
        Scan of the face (scan/1): its kind, and the CSV of its readings.
    machine
        Machine file of the machine that scanned: its errors are taken off the readings.
    program
        NC program that cut the face: it is written again, corrected for the map.
    setup
        Set-up file (setup/1) of that program.
    lines
        Lines of the program that cut the face, such as "12-20". Default: every feed move that passes over the scanned area.
    tolerance
        Largest departure from the corrected path that may be left, beside the rounding of the last decimal.
    decimals
        Decimals of the new numbers (default: those of the program, at least 0.001 mm or 0.0001 inch).
    json
        Print one JSON document.
    out
        Folder for face.html, face.json, map.csv, profile.csv and the corrected program.
    """
    from vcmm.face.cli.calibrate_face import FaceJob, FaceProgram

    cut_by = FaceProgram(program, setup, lines, tolerance, decimals)
    return run_job(FaceJob(scan, machine, cut_by, out), Flags(json, out))


def compare_command(
    *recordings: InputFile,
    structure: str | None = None,
    machine: InputFile | None = None,
    errors: str = "",
    json: Json = False,
) -> int:
    """Hold out every third position of each line and say how each interpolation predicts it; nothing is written.

    Parameters
    ----------
    recordings
        Recording files (recording/1).
    structure
        Structure of the machine, such as "w b Y X Z t"; not needed with --machine.
    machine
        Machine file that holds what is known already.
    errors
        Errors to look for, such as "EXX EYX C0Y". Default: all of the axes that moved.
    json
        Print one JSON document.
    """
    return calibrate_command(
        *recordings,
        structure=structure,
        machine=machine,
        errors=errors,
        compare_interpolations=True,
        json=json,
    )


JOBS: dict[str, Callable[..., int]] = {
    "fit": fit_command,
    "design": design_command,
    "program": program_command,
    "simulate": simulate_command,
    "thermal": thermal_command,
    "nodes": nodes_command,
    "face": face_command,
    "compare": compare_command,
}

app = App(
    name="calibrate", help="Find the errors of a machine from recordings of instruments; plan the set-ups."
)
app.default(calibrate_command)
for _name, _command in JOBS.items():
    app.command(_command, name=_name)
