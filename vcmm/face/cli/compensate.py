"""vcmm compensate: a program, measured points or a control's table corrected for the known errors of the machine."""

from __future__ import annotations

import difflib
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any, NamedTuple

from cyclopts import Parameter

from vcmm.compensation.job import compensate
from vcmm.compensation.offsets import OffsetOnly, best_offsets
from vcmm.compensation.result import CompensatedProgram
from vcmm.compensation.source import read_source, write_source
from vcmm.compensation.surface import SurfaceErrors, surface_errors
from vcmm.core.errors import UsageError, choose_from
from vcmm.core.machine import Machine
from vcmm.core.units import quantity
from vcmm.face.bodies import compensation_json
from vcmm.face.cli.options import Decimals, InputFile, Json
from vcmm.face.cli.proof import in_rounds, refuse_worse
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.face.programs import setup_and_machine
from vcmm.files.own.cut_scenario import load_cut
from vcmm.program.setup import Setup
from vcmm.shop.machining.proof import CutProof
from vcmm.show.console.terminal import say, say_warnings, show_answers, show_table
from vcmm.show.tables.answers_machine import compensation_answers
from vcmm.show.tables.compensation import (
    before_and_after,
    departure_json,
    departures,
    pointings,
    proof_text,
    shifts,
    shifts_json,
)
from vcmm.task.measuring.cut_scenario import CutScenario


def compensate_command(
    program: InputFile, *, setup: InputFile | None = None, dialect: str | None = None, tolerance: str = "1 um", decimals: Decimals = None,
    set_on: str = "this machine", carry: Annotated[bool, Parameter(name="--carry-rounding")] = True, growth: float = 20.0,
    inline: float = 200.0, orientation: bool = False, out: Path | None = None, offset_only: bool = False, diff: bool = False,
    points: InputFile | None = None, surface: bool = False, table: str | None = None, plot: bool = False, json: Json = False,
) -> int:  # fmt: skip
    """Rewrite an NC program so that the machine with its known errors cuts the part right.

    Other forms: MACHINE --points measured.csv, MACHINE --table FORMAT. The part of a scenario is cut and inspected: exit code 1 where the tolerance is not met.

    Parameters
    ----------
    program
        NC program, or a cutting scenario (it names the program); with --points or --table a machine file.
    setup
        Set-up file (setup/1): machine, work offsets, tools, and what the control itself compensates.
    dialect
        How the program is written; default: that of the set-up file, else guessed.
    tolerance
        Largest departure that may be left, beside the rounding of the last decimal.
    decimals
        Decimals of the new numbers (default: those of the program, at least 0.001 mm or 0.0001 inch).
    set_on
        Where the work offset was set: "this machine" (its error there is subtracted) or "elsewhere".
    carry
        Carry the rounding error along chains of short blocks; --no-carry-rounding rounds every number by itself.
    growth
        How many times as many blocks there may be before the tolerance is relaxed.
    inline
        Most blocks for each line of the program when subprograms and loops are written out; 0 refuses such programs.
    orientation
        Correct the angles (or directions) of the tool too, in programs that lead its tip (G43.4, G43.5, TRAORI, M128).
    out
        File (for --table: folder) of the result; default: PROGRAM-compensated in the current folder.
    offset_only
        Only the best shift of each work offset, what can be done without a new program; nothing is written.
    diff
        Print the changes as a unified diff.
    points
        Measured points (columns as in recordings): indicated to corrected.
    surface
        Correct the finished surface of a cutting scenario, not only the path: what bends, wears or lags.
    plot
        Also write a page beside the result: the path before and after, coloured by what is off, with a slider along it.
    table
        Table for a control: isg, linuxcnc, heidenhain, sinumerik or fanuc.
    json
        Print one JSON document.
    """
    given_options = {"--surface": surface, "--orientation": orientation, "--plot": plot, "--diff": diff}
    _only_a_program(given_options, {"--offset-only": offset_only, "--points": points, "--table": table})
    if points is not None or table is not None:
        return _machine_form(program, points, table, out, json)
    made_for = _MadeFor(setup, dialect, set_on)
    if offset_only:
        return run_job(OffsetJob(program, made_for), Flags(json))
    options = _Options(
        tolerance,
        decimals,
        carry=carry,
        growth=growth,
        inline=inline,
        orientation=orientation,
        surface=surface,
    )
    return run_job(CompensateJob(program, made_for, options, out, diff, plot), Flags(json))


def _only_a_program(options: dict[str, bool], forms: dict[str, object]) -> None:
    """Raises UsageError for options that only a rewritten program has, with a form that writes none."""
    form = next((name for name, given in forms.items() if given), None)
    named = ", ".join(name for name, on in options.items() if on)
    if form is not None and named:
        raise UsageError(
            f"{named} with {form}: that form rewrites no program, so there is nothing to do it to; take {form} away, or {named}"
        )


def _machine_form(machine: Path, points: Path | None, table: str | None, out: Path | None, json: bool) -> int:
    """Return one of the two forms that take a machine. Raises UsageError where both are requested."""
    from vcmm.face.cli.compensate_machine import PointsJob, TableJob

    if points is not None and table is not None:
        raise UsageError("--points and --table exclude each other; give one of them")
    if points is not None:
        return run_job(PointsJob(machine, points, out or Path(f"{points.stem}-corrected.csv")), Flags(json))
    folder = out or Path(f"{machine.stem}-{table}")
    return run_job(TableJob(machine, str(table), folder), Flags(json, folder))


class _MadeFor(NamedTuple):
    """Statements of the command line about the place of a program: set-up file, dialect, place where the work offset was set."""

    setup: Path | None
    dialect: str | None
    set_on: str


class _Options(NamedTuple):
    """Options of the command line for the rewriting."""

    tolerance: str
    decimals: int | None
    carry: bool
    growth: float
    inline: float
    orientation: bool
    surface: bool


@dataclass(frozen=True)
class GivenProgram:
    """A program, its set-up, and the statements of a cutting scenario about both. read: the files so far."""

    program: Path
    setup: Setup | Path
    read: list[Path]
    dialect: str | None
    set_here: bool
    machine: Machine | None = None
    constants: Any = None
    scenario: CutScenario | None = None


def _load_program(program: Path, made_for: _MadeFor) -> GivenProgram:
    """Raises UsageError: no set-up is known, or --set-on is none of its two words."""
    setup, dialect, set_on = made_for
    if set_on not in ("this machine", "elsewhere"):
        raise UsageError(f'--set-on "{set_on}".{choose_from(set_on, ["this machine", "elsewhere"])}')
    here = set_on == "this machine"
    if setup is not None:
        return GivenProgram(program, setup, [program, setup], dialect, here)
    if program.suffix != ".toml":
        raise UsageError(
            "the machine's position must be known: name a set-up file with --setup setup.toml (machine, work offsets, tools)"
        )
    return rewritable(program, dialect, here)


def rewritable(path: Path, dialect: str | None = None, here: bool = True) -> GivenProgram:
    """Return the program of a cutting scenario; here: its work offset was set on its machine, unless the scenario states otherwise."""
    scenario = load_cut(path)
    return GivenProgram(
        scenario.program,
        replace(scenario.setup, set_at=scenario.set_at, set_as_cut=scenario.set_as_cut),
        [path, scenario.program],
        dialect or scenario.dialect,
        here and scenario.set_here,
        machine=scenario.machine,
        constants=scenario.constants,
        scenario=scenario,
    )


class Rewritten(NamedTuple):
    """The new program, and its part when it is cut."""

    program: CompensatedProgram
    proof: CutProof


@dataclass(frozen=True)
class CompensateJob(Job[GivenProgram, Rewritten]):
    """A program rewritten. out: its file; None: named after the program. diff, plot: further output."""

    program: Path
    made_for: _MadeFor
    options: _Options
    out: Path | None
    diff: bool
    plot: bool
    schema = "vcmm.compensation/1"

    def load(self) -> GivenProgram:
        return _load_program(self.program, self.made_for)

    def target(self, given: GivenProgram) -> Path:
        return self.out or Path(f"{given.program.stem}-compensated{given.program.suffix}")

    def run(self, loaded: GivenProgram, report: Progress) -> Rewritten:
        """Raises UsageError where the result would lie over the program, ModelLimit where its part is worse."""
        given, o = loaded, self.options
        tolerance = quantity(o.tolerance, "length", "--tolerance", "1 um")
        surface = _surface(given) if o.surface else None
        target = self.target(given)
        if target.exists() and given.program.exists() and target.samefile(given.program):
            raise UsageError(f"{target} is the program itself; choose another file with --out")

        def make(of_surface: SurfaceErrors | None) -> CompensatedProgram:
            made = compensate(
                given.program, *setup_and_machine(given.setup, given.machine), dialect=given.dialect, set_here=given.set_here,
                constants=given.constants, progress=report, follow=self.plot, surface=of_surface, tolerance=tolerance,
                decimals=o.decimals, carry=o.carry, growth=o.growth, inline=o.inline, orientation=o.orientation,
            )  # fmt: skip
            report("cutting the new program, and inspecting it", 0.9)
            return made

        made, proof = in_rounds(given.scenario, surface, given.program.suffix, tolerance, make)
        refuse_worse(given.program, proof)
        return Rewritten(made, proof)

    def record(self, loaded: GivenProgram, result: Rewritten) -> Record:
        body = compensation_json(result.program, self.target(loaded), result.proof)
        return Record(body, loaded.read, warnings=result.program.warnings)

    def export(self, loaded: GivenProgram, result: Rewritten, content: dict[str, Any]) -> None:
        """Write the program, and the page of --plot beside it."""
        target = self.target(loaded)
        write_source(target, result.program.data)
        say(f"wrote {target}")
        if self.plot:
            from vcmm.show.pages.path import compensation_page
            from vcmm.show.report import write

            page = target.with_suffix(".html")
            write(page, compensation_page(result.program, loaded.program, result.proof))
            say(f"wrote {page}")

    def exit_code(self, loaded: GivenProgram, result: Rewritten) -> int:
        met = result.program.is_met if result.proof.after is None else result.proof.is_met
        return 0 if met else 1

    def show(self, loaded: GivenProgram, result: Rewritten) -> None:
        _show(result.program, result.proof)
        if self.diff:
            _show_diff(loaded.program, self.target(loaded), result.program)


def _surface(given: GivenProgram) -> SurfaceErrors | None:
    """Return the departure of the finished surface beside its path; None where there is none."""
    if given.scenario is None:
        raise UsageError(
            "--surface needs to know part, stock and tools: name a cutting scenario (vcmm compensate block.toml --surface), not program and set-up"
        )
    return surface_errors(given.scenario)


@dataclass(frozen=True)
class OffsetJob(Job[GivenProgram, OffsetOnly]):
    """--offset-only: nothing is written."""

    program: Path
    made_for: _MadeFor
    schema = "vcmm.compensation/1"

    def load(self) -> GivenProgram:
        return _load_program(self.program, self.made_for)

    def run(self, loaded: GivenProgram, report: Progress) -> OffsetOnly:
        return best_offsets(
            loaded.program, *setup_and_machine(loaded.setup, loaded.machine), dialect=loaded.dialect, set_here=loaded.set_here, constants=loaded.constants,
        )  # fmt: skip

    def record(self, loaded: GivenProgram, result: OffsetOnly) -> Record:
        body = {
            "program": result.name, "dialect": result.dialect, "machine": result.machine, "file": None,
            "deviation": {"before": departure_json(result.before), "offset_only": departure_json(result.offset_only)},
            "offset_shift_mm": shifts_json(result),
        }  # fmt: skip
        return Record(body, loaded.read, warnings=result.warnings)

    def show(self, loaded: GivenProgram, result: OffsetOnly) -> None:
        rows = [("as programmed", result.before), ("work offsets shifted", result.offset_only)]
        show_table(departures(result, rows))
        show_table(shifts(result))
        say_warnings(result.warnings)


def _show(result: CompensatedProgram, proof: CutProof) -> None:
    show_answers(compensation_answers(result, proof))
    if proof.after is not None:
        print(proof_text(proof))
    show_table(departures(result, before_and_after(result)))
    if result.orientation is not None:
        show_table(pointings(result.orientation))
    show_table(shifts(result))
    r, b = result.rounding, result.blocks
    print(
        f"path, tolerance {result.tolerance_used * 1e3:g} µm: {'met everywhere' if result.is_met else 'NOT met everywhere'} (rounding to {r.step:g} mm: "
        f"up to {r.largest * 1e3:.2f} µm, {r.share:.0%} of the mean square that is left)\n"
        f"blocks with motion: {b.before} before, {b.after} after (x {b.growth:.2f}), {b.changes} changed, {b.additions} added; "
        f"at most {b.rate_after:.1f} blocks/s (was {b.rate_before:.1f}), line {b.rate_line}"
    )
    if proof.after is None:
        print(proof_text(proof))
    say_warnings(result.warnings)


def _show_diff(program: Path, target: Path, result: CompensatedProgram) -> None:
    old = [line for line, _ in read_source(program).lines]
    new = result.text.replace("\r\n", "\n").replace("\r", "\n").rstrip("\n").split("\n")
    for line in difflib.unified_diff(old, new, str(program), str(target), lineterm="", n=1):
        print(line)
