"""vcmm loop: from the measured part to the program of the next one, proved by a cut."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Literal, NamedTuple

from vcmm.answer.evaluation.virtual_measurement import Measurement
from vcmm.answer.inference.given_points import GivenPoints
from vcmm.compensation.job import compensate
from vcmm.compensation.result import CompensatedProgram
from vcmm.compensation.source import write_source
from vcmm.compensation.surface import SurfaceErrors, surface_errors
from vcmm.core.errors import UsageError
from vcmm.core.run import Array
from vcmm.core.units import quantity
from vcmm.face.cli.compensate import rewritable
from vcmm.face.cli.cut import measured_points
from vcmm.face.cli.loop_findings import LoopFindings, diagnose_cut
from vcmm.face.cli.options import Decimals, InputFile, Json, Seed
from vcmm.face.cli.proof import in_rounds
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.face.programs import setup_and_machine
from vcmm.learn.diagnosis.result import Diagnosis
from vcmm.shop.machining.held_out import HeldOutProof
from vcmm.shop.machining.job import measure_cut
from vcmm.shop.machining.measured_part import MeasuredCut, left_of
from vcmm.shop.machining.proof import CutProof
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import say_warnings, show_answers
from vcmm.show.pages.diagnosis import sentences
from vcmm.show.tables.answers_machine import loop_answers
from vcmm.show.tables.loops import loop_json, loop_text
from vcmm.task.measuring.cut_scenario import CutScenario


def loop_command(
    scenario: InputFile, *, measured: InputFile, frame: Literal["part", "machine"] = "part", u_point: str = "", seed: Seed = 0,
    tolerance: str = "1 um", decimals: Decimals = None, surface: bool = True, out: Path | None = None,
    json: Json = False,
) -> int:  # fmt: skip
    """Cut, compare with the measured part, diagnose, compensate, and prove by a cut what the next part will be.

    Exit code 1: the next part is not within the tolerance, would be worse and is refused, or something of the measured part is open.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1) with a [cut] table; its machine is in a file of its own.
    measured
        The part as it came back, points.csv (as of vcmm cut --measured).
    frame
        Of the measured points: the drawing frame (after alignment) or the machine frame.
    u_point
        Standard uncertainty of a measured point, for example "0.5 um"; default: found from the points.
    seed
        Seed of the null recordings of the diagnosis.
    tolerance
        Largest departure of a point of the next part that is allowed, beside the rounding of the last decimal.
    decimals
        Decimals of the new numbers (default: those of the program, at least 0.001 mm or 0.0001 inch).
    surface
        Correct the finished surface too (milling with the rotary axes at rest); --no-surface corrects the path alone.
    out
        Folder for recording, machine file, scenario and program of the next part, and loop.json; default: SCENARIO-next in the current folder.
    json
        Print one JSON document.
    """
    folder = out or Path(f"{scenario.stem}-next")
    points = MeasuredPart(measured, u_point, frame == "machine")
    job = LoopJob(scenario, points, seed, _LoopRequest(tolerance, decimals, surface), folder)
    return run_job(job, Flags(json, folder))


class MeasuredPart(NamedTuple):
    """The file of the measured points, u of one as text, whether they are in the machine frame."""

    file: Path
    u_point: str
    in_machine: bool


Points = tuple[GivenPoints, float | None]  # and u of one in mm


LEAST_SHARE = 1e-3  # of parts that hold no more than the scatter of their points, told all the same
LEAST_SCATTER = 1e-5  # mm: below it points are given without any


@dataclass(frozen=True)
class _LoopRequest:
    tolerance: str
    decimals: int | None
    surface: bool


@dataclass(frozen=True, eq=False)
class Loop:
    """Result of the loop; proof: of the program that was written or refused, None where none was made."""

    cut: MeasuredCut
    diagnosis: Diagnosis
    machine: Path | None  # with what was found; None where nothing was added
    program: Path | None
    proof: CutProof
    after: Measurement | None  # values of the characteristics of the next part
    refusal: str
    warnings: tuple[str, ...]
    output_files: tuple[str, ...]
    stated: bool  # how well a point was measured
    rest: Array  # (n,) mm: what the machine file with what was found leaves of the measured points
    held_out: HeldOutProof | None = (
        None  # the proof in passes held out of what was found; None where nothing was
    )

    @property
    def open_words(self) -> str:
        """The part of the measured deviations without a cause in the machine file, in words; "" where there is none."""
        d = self.diagnosis
        if not self.stated and d.fit.noise > self.proof.limit:
            return (
                f"the points scatter by {d.fit.noise * 1e3:.2f} µm about what is explained, and --u-point does not say that the measuring does; if it is the part, "
                "the next one will have it again"
            )
        if d.verdict == "nothing missing" or (d.verdict == "explained" and self.machine is not None):
            return ""
        return (
            f"the machine file leaves {d.fit.after * 1e3:.2f} µm rms of the measured part, whose points scatter by {d.fit.noise * 1e3:.2f} µm; the next part will "
            "have that again, and no cut of this machine file shows it"
        )

    @property
    def setting(self) -> str:
        """The part of the measured deviations within the uncertainty of setting up, in words; "" where it is no more than the scatter of points."""
        from scipy.stats import chi2

        n, scatter = len(self.rest), max(self.cut.scatter, LEAST_SCATTER)
        if float(self.rest @ self.rest) <= scatter**2 * float(chi2.ppf(1.0 - LEAST_SHARE, n)):
            return ""
        size = abs(self.rest) * 1e3
        return (
            f"{size.max():.2f} µm at most and {size.mean():.2f} µm in the mean of the measured part lie within what is uncertain of tools, zeros and machine, so they are no finding: the "
            "next part will have them again unless tools and zero are set anew"
        )

    @property
    def is_met(self) -> bool:
        """Whether the next part is within the allowed departure, and nothing of the measured one is open."""
        return bool(self.proof.is_met and not (self.refusal or self.open_words or self.setting))


@dataclass(frozen=True)
class LoopJob(Job[Points, Loop]):
    """Go from a measured part to the program of the next one. The machine file and the recording are written while the diagnosis goes on,
    as each is read again."""

    scenario: Path
    measured: MeasuredPart
    seed: int
    request: _LoopRequest
    folder: Path
    schema, names_files_last = "vcmm.loop/1", True

    def load(self) -> Points:
        return measured_points(self.measured.file, self.measured.u_point)

    def run(self, loaded: Points, report: Progress) -> Loop:
        findings = diagnose_cut(
            self.scenario, loaded, self.measured.in_machine, self.seed, self.folder, report
        )
        return _next(findings, self.scenario, self.folder, self.request, is_stated=loaded[1] is not None)

    def record(self, loaded: Points, result: Loop) -> Record:
        files = [*sources(self.scenario), self.measured.file]
        return Record(loop_json(result), files, self.seed, result.warnings)

    def texts(self, loaded: Points, result: Loop, content: str, folder: Path) -> dict[str, str]:
        return {"loop.json": content}

    def files_sentence(self, loaded: Points, result: Loop, folder: Path, names: Sequence[str]) -> str:
        return f"wrote {folder}/" + ", ".join([*result.output_files, *names])

    def exit_code(self, loaded: Points, result: Loop) -> int:
        return 0 if result.is_met else 1

    def show(self, loaded: Points, result: Loop) -> None:
        show_answers(loop_answers(result))
        for line in loop_text(result, sentences(result.diagnosis)):
            print(line)
        say_warnings(result.warnings)


def _next(
    findings: LoopFindings, scenario: Path, folder: Path, wanted: _LoopRequest, is_stated: bool
) -> Loop:
    """Return the program of the next part: compensated, cut on the improved machine, and written where it is no worse."""
    written = findings.output_files
    given = rewritable(folder / "next.toml" if findings.is_improved else scenario)
    cut = given.scenario
    assert cut is not None  # `rewritable` has read one
    allowed = quantity(wanted.tolerance, "length", "--tolerance", "1 um")
    surface, notes = _surface(cut, wanted.surface)

    def make(of_surface: SurfaceErrors | None) -> CompensatedProgram:
        return compensate(
            given.program, *setup_and_machine(given.setup, given.machine), dialect=given.dialect, set_here=given.set_here, constants=given.constants,
            tolerance=allowed, decimals=wanted.decimals, surface=of_surface,
        )  # fmt: skip

    made, proof = in_rounds(cut, surface, given.program.suffix, allowed, make)
    program, refused, after = folder / f"{given.program.stem}-next{given.program.suffix}", proof.worse, None
    if proof.after is None:
        refused = f"the next part cannot be inspected: {proof.reason}"
    if not refused:
        write_source(program, made.data)
        written = (*written, program.name)
        after = measure_cut(replace(cut, program=program))
    return Loop(
        cut=findings.cut.cut, diagnosis=findings.diagnosis, machine=findings.machine if findings.is_improved else None,
        program=None if refused else program, proof=proof, after=after, refusal=refused,
        warnings=tuple(dict.fromkeys((*findings.cut.warnings, *notes, *made.warnings))), output_files=written, stated=is_stated, rest=left_of(findings.cut.cut, findings.rest), held_out=findings.held_out,
    )  # fmt: skip


def _surface(scenario: CutScenario, wanted: bool) -> tuple[SurfaceErrors | None, tuple[str, ...]]:
    """Return the departure of the finished surface beside the path; where that cannot be corrected, why."""
    if not wanted:
        return None, ()
    try:
        return surface_errors(scenario), ()
    except UsageError as error:
        return None, (f"the path alone is corrected: {error}",)
