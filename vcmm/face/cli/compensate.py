"""vcmm compensate: a program, measured points or a control's table with the known errors of the machine taken out."""

from __future__ import annotations

from dataclasses import dataclass, replace
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from vcmm.face.cli.options import Decimals


def compensate_command(
    program: Path, *, setup: Path | None = None, dialect: str | None = None, tolerance: str = "1 um", decimals: Decimals = None,
    set_on: str = "this machine", carry: Annotated[bool, Parameter(name="--carry-rounding")] = True, growth: float = 20.0,
    inline: float = 200.0, orientation: bool = False, out: Path | None = None, offset_only: bool = False, diff: bool = False,
    points: Path | None = None, surface: bool = False, table: str | None = None, plot: bool = False, json: Annotated[bool, Parameter(name="--json")] = False,
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
    asked = {"--surface": surface, "--orientation": orientation, "--plot": plot, "--diff": diff}
    _only_a_program(asked, {"--offset-only": offset_only, "--points": points, "--table": table})
    if points is not None or table is not None:
        return _machine_form(program, points, table, out, json)
    given = _load_program(program, setup, dialect, set_on)
    if offset_only:
        return _offsets(given, json)
    options = {"tolerance": _length(tolerance), "decimals": decimals, "carry": carry, "growth": growth, "inline": inline,
        "orientation": orientation, "surface": _surface(given) if surface else None,
    }  # fmt: skip
    return _rewritten(given, out, options, (diff, plot), json)


def _only_a_program(options: dict[str, bool], forms: dict[str, object]) -> None:
    """Raises UsageError for options that only a rewritten program has, with a form that writes none."""
    from vcmm.core.errors import UsageError

    form = next((name for name, given in forms.items() if given), None)
    asked = ", ".join(name for name, on in options.items() if on)
    if form is not None and asked:
        raise UsageError(
            f"{asked} with {form}: that form rewrites no program, so there is nothing to do it to; take {form} away, or {asked}"
        )


@dataclass(frozen=True)
class _GivenProgram:
    """A program, the set-up it was made for, and what a cutting scenario says of both. read: the files so far."""

    program: Path
    setup: Any
    read: list[Path]
    dialect: str | None
    set_here: bool
    machine: Any = None
    constants: Any = None
    scenario: Any = None


def _load_program(program: Path, setup: Path | None, dialect: str | None, set_on: str) -> _GivenProgram:
    """Raises UsageError: no set-up is known, or --set-on is none of its two words."""
    from vcmm.core.errors import UsageError, choose_from

    if set_on not in ("this machine", "elsewhere"):
        raise UsageError(f'--set-on "{set_on}".{choose_from(set_on, ["this machine", "elsewhere"])}')
    here = set_on == "this machine"
    if setup is not None:
        return _GivenProgram(program, setup, [program, setup], dialect, here)
    if program.suffix != ".toml":
        raise UsageError(
            "the machine's position must be known: name a set-up file with --setup setup.toml (machine, work offsets, tools)"
        )
    return rewritable(program, dialect, here)


def rewritable(path: Path, dialect: str | None = None, here: bool = True) -> _GivenProgram:
    """The program of a cutting scenario; here: its work offset was set on its machine, where the scenario says nothing else."""
    from vcmm.files.own.cut_scenario import load_cut

    scenario = load_cut(path)
    return _GivenProgram(
        scenario.program,
        replace(scenario.setup, set_at=scenario.set_at, set_as_cut=scenario.set_as_cut),
        [path, scenario.program],
        dialect or scenario.dialect,
        here and scenario.set_here,
        machine=scenario.machine,
        constants=scenario.constants,
        scenario=scenario,
    )


def _machine_form(program: Path, points: Path | None, table: str | None, out: Path | None, json: bool) -> int:
    from vcmm.face.cli.compensate_machine import machine_form

    return machine_form(program, points, table, out, json)


def _length(tolerance: str) -> float:
    from vcmm.core.units import quantity

    return quantity(tolerance, "length", "--tolerance", "1 um")


def _surface(given: _GivenProgram) -> Any:
    """What the finished surface departs by beside its path; None where it does not."""
    from vcmm.compensation.surface import surface_errors
    from vcmm.core.errors import UsageError

    if given.scenario is None:
        raise UsageError(
            "--surface needs to know part, stock and tools: name a cutting scenario (vcmm compensate block.toml --surface), not program and set-up"
        )
    return surface_errors(given.scenario)


def _rewritten(
    given: _GivenProgram, out: Path | None, options: dict[str, Any], shown: tuple[bool, bool], json: bool
) -> int:
    """Rewrite the program. options: tolerance (mm), decimals, carry, growth, inline. shown: differences, page."""
    from vcmm.compensation.job import compensate
    from vcmm.compensation.source import write_source
    from vcmm.core.errors import UsageError
    from vcmm.face.cli.proof import in_rounds, refuse_worse
    from vcmm.show.console.documents import document, print_json
    from vcmm.show.console.terminal import progress, say

    program = given.program
    target = out or Path(f"{program.stem}-compensated{program.suffix}")
    if target.exists() and program.exists() and target.samefile(program):
        raise UsageError(f"{target} is the program itself; choose another file with --out")
    surface, others = options["surface"], {k: v for k, v in options.items() if k != "surface"}
    with progress() as report:

        def make(of_surface: Any) -> Any:
            made = compensate(
                program, given.setup, given.machine, dialect=given.dialect, set_here=given.set_here,
                constants=given.constants, progress=report, follow=shown[1], surface=of_surface, **others,
            )  # fmt: skip
            report("cutting the new program, and inspecting it", 0.9)
            return made

        result, proof = in_rounds(given.scenario, surface, program.suffix, options["tolerance"], make)
    refuse_worse(given.scenario, proof)
    write_source(target, result.data)
    say(f"wrote {target}")
    if shown[1]:
        _write_page(target.with_suffix(".html"), result, program, proof)
    if json:
        from vcmm.face.bodies import compensation_json

        body = compensation_json(result, target, proof)
        print_json(document("vcmm.compensation/1", body, files=given.read, warnings=result.warnings))
    else:
        _show(result, proof)
        if shown[0]:
            _show_diff(program, target, result)
    return 0 if (result.met if proof.after is None else proof.met) else 1


def _write_page(target: Path, result: Any, program: Path, proof: Any) -> None:
    from vcmm.show.console.terminal import say
    from vcmm.show.pages.path import compensation_page
    from vcmm.show.report import write

    write(target, compensation_page(result, program, proof))
    say(f"wrote {target}")


def _offsets(given: _GivenProgram, json: bool) -> int:
    """--offset-only: nothing is written."""
    from vcmm.compensation.offsets import best_offsets
    from vcmm.show.console.documents import document, print_json
    from vcmm.show.console.terminal import say_warnings, show_table
    from vcmm.show.tables.compensation import departure_json, departures, shifts, shifts_json

    result = best_offsets(
        given.program, given.setup, given.machine, dialect=given.dialect, set_here=given.set_here, constants=given.constants,
    )  # fmt: skip
    if json:
        body = {
            "program": result.name, "dialect": result.dialect, "machine": result.machine, "file": None,
            "deviation": {"before": departure_json(result.before), "offset_only": departure_json(result.offset_only)},
            "offset_shift_mm": shifts_json(result),
        }  # fmt: skip
        print_json(document("vcmm.compensation/1", body, files=given.read, warnings=result.warnings))
        return 0
    show_table(
        departures(result, [("as programmed", result.before), ("work offsets shifted", result.offset_only)])
    )
    show_table(shifts(result))
    say_warnings(result.warnings)
    return 0


def _show(result: Any, proof: Any) -> None:
    from vcmm.show.console.terminal import say_warnings, show_answers, show_table
    from vcmm.show.tables.answers_machine import compensation_answers
    from vcmm.show.tables.compensation import before_and_after, departures, pointings, shifts
    from vcmm.show.tables.proofs import proof_text

    show_answers(compensation_answers(result, proof))
    if proof.after is not None:
        print(proof_text(proof))
    show_table(departures(result, before_and_after(result)))
    if result.orientation is not None:
        show_table(pointings(result.orientation))
    show_table(shifts(result))
    r, b = result.rounding, result.blocks
    print(
        f"path, tolerance {result.used * 1e3:g} µm: {'met everywhere' if result.met else 'NOT met everywhere'} (rounding to {r.step:g} mm: "
        f"up to {r.largest * 1e3:.2f} µm, {r.share:.0%} of the mean square that is left)\n"
        f"blocks with motion: {b.before} before, {b.after} after (x {b.growth:.2f}), {b.changed} changed, {b.added} added; "
        f"at most {b.rate_after:.1f} blocks/s (was {b.rate_before:.1f}), line {b.rate_line}"
    )
    if proof.after is None:
        print(proof_text(proof))
    say_warnings(result.warnings)


def _show_diff(program: Path, target: Path, result: Any) -> None:
    import difflib

    from vcmm.compensation.source import read_source

    old = [line for line, _ in read_source(program).lines]
    new = result.text.replace("\r\n", "\n").replace("\r", "\n").rstrip("\n").split("\n")
    for line in difflib.unified_diff(old, new, str(program), str(target), lineterm="", n=1):
        print(line)
