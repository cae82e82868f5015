"""Jobs about machines and recordings as Python calls; the command line gives the same numbers."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import replace
from pathlib import Path
from typing import TYPE_CHECKING

from vcmm.core.blocks import Progress
from vcmm.core.effect import Effect
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.readable import ReadableRows
from vcmm.core.run import Array, Run
from vcmm.face import machine_readings
from vcmm.task.response.recording import Recording

if TYPE_CHECKING:
    from vcmm.compensation.result import CompensatedProgram
    from vcmm.compensation.surface import SurfaceErrors
    from vcmm.learn.calibration.result import Calibration
    from vcmm.learn.diagnosis.result import Diagnosis
    from vcmm.program.setup import Setup
    from vcmm.task.instruments.instrument import InstrumentCertificate
    from vcmm.task.response.volumetric import ErrorField


def field(
    machine: Machine | str | Path, run: Run | None = None, exact: bool = False, nodes: int = 5
) -> ErrorField:
    """Compute the volumetric error map: tip errors, actual - nominal, in workpiece axes.

    Parameters
    ----------
    machine
        A machine, or the path of its file.
    run
        Positions; without it a grid over the travels, rotary axes at zero, as far as every effect is known.
    exact
        Multiply the transforms instead of first order.
    nodes
        Nodes of the grid along each axis.

    Returns
    -------
    ErrorField
        `tip_error` (n, 3) mm at the rows of `run`, `u` of the same shape or None, body diagonals.

    Raises
    ------
    UsageError, ModelLimit
        Too few or too many nodes; a position outside the travels.
    """
    from vcmm.task.response.volumetric import field as map_errors

    loaded = _machine(machine)
    return replace(map_errors(loaded, run, exact, nodes), reading=machine_readings.field_reading(loaded))


def diagnose(
    recording: Recording | str | Path,
    machine: Machine | str | Path | None = None,
    *,
    seed: int = 0,
    extra_effects: Sequence[type[Effect]] = (),
    progress: Progress | None = None,
) -> Diagnosis:
    """Find the physics in a recording that the machine lacks: causes, rivals, held-out improvement, next measurement.

    Parameters
    ----------
    recording
        A recording, or the path of its file.
    machine
        The machine, or the path of its file; without it the one that the file of the recording names.
    seed
        Seed of the null recordings that set the false-alarm threshold.
    extra_effects
        Effect classes of your own, looked for beside the list.
    progress
        Called with what is done and its share, 0 to 1.

    Returns
    -------
    Diagnosis
        `verdict`, `found`, `candidates`, `fit`. Of more than 100 000 observations some are taken, with a note.

    Raises
    ------
    DataError, UsageError, ModelLimit
        A file is wrong; a recording in memory comes without its machine; rows lie outside the travels.
    """
    from vcmm.learn.diagnosis.job import diagnose as find_causes

    if isinstance(recording, Recording):
        if machine is None:
            raise UsageError(
                "a recording in memory does not name its machine: vcmm.diagnose(recording, machine)"
            )
        loaded = _machine(machine)
    else:
        from vcmm.files.own.recording import load_recording

        given = None if machine is None else _machine(machine)
        recording, loaded = load_recording(recording, given, gaps=True)
    diagnosis = find_causes(recording, loaded, seed=seed, extra_effects=extra_effects, progress=progress)
    return replace(diagnosis, reading=machine_readings.diagnosis_reading(recording, loaded))


def calibrate(
    recordings: Sequence[Recording],
    machine: Machine,
    certificates: Mapping[str, InstrumentCertificate] | None = None,
    only: Sequence[str] = (),
    progress: Progress = lambda text, share: None,
    growth: float = 0.0,
    interpolation: str = "spline",
    correlated: Mapping[str, Array] | None = None,
) -> Calibration:
    """Estimate the errors of a machine, with their joint covariance, from any mixture of recordings.

    Parameters
    ----------
    recordings
        What instruments read.
    machine
        Structure and axes, and what is known besides: its effects are the baseline.
    certificates
        Name of a recording -> its instrument.
    only
        Names of the errors to look for; the others are taken as zero, or stay as the machine has them.
    progress
        Called with what is done and its share, 0 to 1.
    growth
        u in mm by which every error of the machine may have changed since it was found (rotations: over 1 m); 0 leaves it to the readings.
    interpolation
        "spline", "gaussian process", "polynomial", "table" or a net.
    correlated
        Name of a recording -> covariance (m, m) mm^2 of its readings, where their noise is not independent.

    Returns
    -------
    Calibration
        The identified errors and their covariance, mm and rad; `figures()`, `band(name)`, `plot(name)`.

    Raises
    ------
    UsageError
        Nothing is identified (the combinations are named), or recordings contradict themselves.
    """
    from vcmm.learn.calibration.job import calibrate as find_errors

    calibration = find_errors(
        recordings,
        machine,
        certificates,
        only,
        progress,
        growth=growth,
        interpolation=interpolation,
        correlated=correlated,
    )
    return replace(calibration, reading=machine_readings.calibration_reading())


def compensate(
    program: str | Path,
    setup: str | Path | Setup,
    machine: Machine | None = None,
    *,
    dialect: str | None = None,
    tolerance: float = 1e-3,
    decimals: int | None = None,
    set_here: bool = True,
    carry: bool = True,
    growth: float = 20.0,
    constants: Mapping[str, float] | None = None,
    inline: float = 200.0,
    surface: SurfaceErrors | None = None,
    follow: bool = False,
    orientation: bool = False,
    progress: Progress | None = None,
) -> CompensatedProgram:
    """Rewrite an NC program so that the machine with its known errors cuts the part right.

    Parameters
    ----------
    program
        File of the program.
    setup
        Set-up, or the path of its file: machine, work offsets, tools.
    machine
        Instead of the machine of the set-up.
    dialect
        How the program is written; default: that of the set-up, else guessed.
    tolerance
        Largest departure that may be left, mm.
    decimals
        Decimals of the new numbers (default: those of the program).
    set_here
        The work offset was set on this machine, so that its error there is subtracted.
    carry
        Carry rounding errors along chains of short blocks; else every number is rounded by itself.
    growth
        How many times as many blocks there may be before the tolerance is relaxed.
    constants
        Columns of a run with one value, such as `temp_part_C`.
    inline
        Most blocks for each line of the program when subprograms and loops are written out; 0 refuses such programs.
    surface
        What the tool does to the finished surface beside its path, corrected as well.
    follow
        Keep both paths with their errors, which the report draws.
    orientation
        Correct angles and directions of the tool too, where the tip is led.
    progress
        Called with what is done and its share, 0 to 1.

    Returns
    -------
    CompensatedProgram
        `text` and `data` of the new program; departures before and after; `met`.

    Raises
    ------
    DataError, UsageError, ModelLimit
        Whatever cannot be rewritten for certain, with file and line.
    """
    from vcmm.compensation.job import compensate as rewrite
    from vcmm.face.programs import setup_and_machine

    compensated_program = rewrite(
        program,
        *setup_and_machine(setup, machine),
        dialect=dialect,
        tolerance=tolerance,
        decimals=decimals,
        set_here=set_here,
        carry=carry,
        growth=growth,
        constants=constants,
        inline=inline,
        surface=surface,
        follow=follow,
        orientation=orientation,
        progress=progress,
    )
    return replace(compensated_program, reading=machine_readings.compensation_reading(Path(program)))


def test(
    file: str | Path,
    *more: str | Path,
    iso: str,
    limits: Sequence[str] = (),
    seed: int = 0,
    trials: int = 1000,
) -> ReadableRows:
    """Return the figures of an acceptance test: predicted for a machine with uncertainty, or evaluated from recordings.

    Parameters
    ----------
    file
        Machine file, or a scenario with its machine: predict. Recording: evaluate.
    more
        Further recordings of the same test: axes, planes, diagonals.
    iso
        "230-2", "230-4", "230-6", "230-7" or "10360-2".
    limits
        Limits as the command writes them: "A = 8 um", "E0 = 1.9 um + L/300".
    seed
        Seed of the drawn machines.
    trials
        Number of drawn machines.

    Returns
    -------
    tuple of Figure
        `figures["A X"]` is one figure; values in um (urad for angles), p_pass where a limit is stated.

    Raises
    ------
    DataError, UsageError
        A file is wrong; the test is not known, or a limit names none of its figures.
    """
    from vcmm.face.acceptance import find_figures, table_of_figures

    files = [Path(file), *map(Path, more)]
    figures, warnings, _ = find_figures(files, iso, limits, seed, trials)
    reading = machine_readings.figures_reading(iso, table_of_figures(iso, figures), files, seed, warnings)
    return ReadableRows.of(figures, reading)


test.__test__ = False  # type: ignore[attr-defined]  # a verb, which pytest must not collect


def compare(
    recordings: str | Path | Sequence[str | Path], machines: Sequence[str | Path] = (), *, seed: int = 0
) -> ReadableRows:
    """Compare simulation and recording for any machine files: rows as they are, nuisance refitted, nothing clipped or named.

    Parameters
    ----------
    recordings
        Files of one or several recordings.
    machines
        Machine files to compare; the recording's own machine is listed first.
    seed
        Seed of the simulated noise behind the p values.

    Returns
    -------
    tuple of Comparison
        One for each machine file: `rms`, `chi2`, `dof`, residuals (mm, rad).

    Raises
    ------
    DataError, ModelLimit
        A file is wrong; rows lie outside the travels; angles stand beside lengths.
    """
    from vcmm.face.comparing import compare_files
    from vcmm.files.own.recording import recording_file

    named = [recordings] if isinstance(recordings, str | Path) else recordings
    files = [recording_file(Path(path)) for path in named]
    rows, warnings, read = compare_files(files, [Path(m) for m in machines], seed)
    return ReadableRows.of(rows, machine_readings.comparison_reading(read, seed, warnings))


def _machine(machine: Machine | str | Path) -> Machine:
    """Return a machine unchanged, or that of a file."""
    from vcmm.files.own.machine import load_machine

    return load_machine(machine) if isinstance(machine, str | Path) else machine
