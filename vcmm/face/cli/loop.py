"""vcmm loop: from the part that came back measured to the program of the next one, proved by a cut."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import TYPE_CHECKING, Annotated, Any, Literal

from cyclopts import Parameter

from vcmm.face.cli.options import Decimals, Seed

if TYPE_CHECKING:
    from vcmm.face.cli.loop_findings import LoopFindings


def loop_command(
    scenario: Path, *, measured: Path, frame: Literal["part", "machine"] = "part", u_point: str = "", seed: Seed = 0,
    tolerance: str = "1 um", decimals: Decimals = None, surface: bool = True, out: Path | None = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:  # fmt: skip
    """Cut, compare with the measured part, diagnose, compensate, and prove by a cut what the next part will be.

    Exit code 1: the next part is not within the tolerance, or would be worse and is refused.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1) with a [cut] table; its machine stands in a file of its own.
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
    from vcmm.face.cli.cut import measured_points
    from vcmm.face.cli.loop_findings import diagnose_cut
    from vcmm.show.console.documents import document, json_text, print_json, sources
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import say, say_warnings, show_answers
    from vcmm.show.pages.diagnosis import sentences
    from vcmm.show.tables.answers_parts import loop_answers
    from vcmm.show.tables.loops import loop_json, loop_text

    given = measured_points(measured, u_point)
    folder = output_folder(out or Path(f"{scenario.stem}-next"))
    found = diagnose_cut(scenario, given, frame == "machine", seed, folder)
    result = _next(
        found,
        scenario,
        folder,
        _LoopRequest(tolerance, decimals, surface),
        is_stated=given[1] is not None,
    )
    files = [*sources(scenario), measured]
    content = document("vcmm.loop/1", loop_json(result), seed=seed, files=files, warnings=result.warnings)
    write_files(folder, {"loop.json": json_text(content)})
    if json:
        print_json(content)
    else:
        show_answers(loop_answers(result))
        for line in loop_text(result, sentences(result.diagnosis)):
            print(line)
        say_warnings(result.warnings)
    say(f"wrote {folder}/" + ", ".join([*result.written, "loop.json"]))
    return 0 if result.met else 1


LEAST_SHARE = 1e-3  # of parts that hold no more than the scatter of their points, told all the same
LEAST_SCATTER = 1e-5  # mm: below it points are given without any


@dataclass(frozen=True)
class _LoopRequest:
    tolerance: str
    decimals: int | None
    surface: bool


@dataclass(frozen=True, eq=False)
class Loop:
    """What the loop came to; proof: of the program that was written or refused, None where none was made."""

    cut: Any
    diagnosis: Any
    machine: Path | None  # with what was found; None where nothing was added
    program: Path | None
    proof: Any
    after: Any  # values of the characteristics of the next part
    refused: str
    warnings: tuple[str, ...]
    written: tuple[str, ...]
    stated: bool  # how well a point was measured
    rest: Any  # (n,) mm: what the machine file with what was found leaves of the measured points
    held_out: Any = None  # the proof in passes held out of what was found; None where nothing was

    @property
    def left(self) -> str:
        """What of the measured part has no cause in the machine file, in words; "" where nothing is open."""
        d = self.diagnosis
        if not self.stated and d.fit.noise > self.proof.allowed:
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
        """What of the measured part lies within what is uncertain of setting up, in words; "" where it is no more than the scatter of points."""
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
    def met(self) -> bool:
        """The next part is within what is allowed, and nothing of the measured one is open."""
        return bool(self.proof.met and not (self.refused or self.left or self.setting))


def _next(found: LoopFindings, scenario: Path, folder: Path, wanted: _LoopRequest, is_stated: bool) -> Loop:
    """The program of the next part: compensated, cut on the machine with what was found, and written where it is no worse."""
    from vcmm.compensation.job import compensate
    from vcmm.compensation.source import write_source
    from vcmm.core.units import quantity
    from vcmm.face.cli.compensate import rewritable
    from vcmm.face.cli.proof import in_rounds
    from vcmm.shop.machining.job import measure_cut
    from vcmm.shop.machining.measured_part import left_of

    written = found.written
    given = rewritable(folder / "next.toml" if found.improved else scenario)
    allowed = quantity(wanted.tolerance, "length", "--tolerance", "1 um")
    surface, notes = _surface(given.scenario, wanted.surface)

    def make(of_surface: Any) -> Any:
        return compensate(
            given.program, given.setup, given.machine, dialect=given.dialect, set_here=given.set_here, constants=given.constants,
            tolerance=allowed, decimals=wanted.decimals, surface=of_surface,
        )  # fmt: skip

    made, proof = in_rounds(given.scenario, surface, given.program.suffix, allowed, make)
    program, refused, after = folder / f"{given.program.stem}-next{given.program.suffix}", proof.worse, None
    if proof.after is None:
        refused = f"the next part cannot be inspected: {proof.reason}"
    if not refused:
        write_source(program, made.data)
        written = (*written, program.name)
        after = measure_cut(replace(given.scenario, program=program))
    return Loop(
        cut=found.cut.cut, diagnosis=found.diagnosis, machine=found.machine if found.improved else None,
        program=None if refused else program, proof=proof, after=after, refused=refused,
        warnings=tuple(dict.fromkeys((*found.cut.warnings, *notes, *made.warnings))), written=written, stated=is_stated, rest=left_of(found.cut.cut, found.rest), held_out=found.held_out,
    )  # fmt: skip


def _surface(scenario: Any, wanted: bool) -> tuple[Any, tuple[str, ...]]:
    """What the finished surface departs by beside the path; where that cannot be corrected, why."""
    from vcmm.compensation.surface import surface_errors
    from vcmm.core.errors import UsageError

    if not wanted:
        return None, ()
    try:
        return surface_errors(scenario), ()
    except UsageError as error:
        return None, (f"the path alone is corrected: {error}",)
