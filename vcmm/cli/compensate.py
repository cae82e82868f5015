"""vcmm compensate: a program, measured points or a control's table with the known errors of the machine taken out."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter


def compensate_command(
    program: Path, *, setup: Path | None = None, dialect: str | None = None, tolerance: str = "1 um", decimals: int | None = None,
    set_on: str = "this machine", carry: Annotated[bool, Parameter(name="--carry-rounding")] = True, growth: float = 20.0,
    inline: float = 200.0, out: Path | None = None, offset_only: bool = False, diff: bool = False, points: Path | None = None,
    table: str | None = None, json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:  # fmt: skip
    """Rewrite an NC program so that the machine with its known errors cuts the part right.

    Other forms: MACHINE --points measured.csv, MACHINE --table FORMAT. Exit code 1: the tolerance is not met everywhere.

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
    out
        File (for --table: folder) of the result; default: PROGRAM-compensated in the current folder.
    offset_only
        Only the best shift of each work offset, what can be done without a new program; nothing is written.
    diff
        Print the changes as a unified diff.
    points
        Measured points (columns as in recordings): indicated to corrected.
    table
        Table for a control: isg, linuxcnc or heidenhain.
    json
        Print one JSON document.
    """
    if points is not None or table is not None:
        from vcmm.cli.compensate_machine import machine_form

        return machine_form(program, points, table, out, json)
    return _program(
        program, setup, dialect, tolerance=tolerance, decimals=decimals, set_on=set_on, carry=carry, growth=growth, inline=inline, out=out, offset_only=offset_only, diff=diff, json=json
    )  # fmt: skip


def _program(
    program: Path, setup: Path | None, dialect: str | None, tolerance: str, decimals: int | None, set_on: str,
    carry: bool, growth: float, inline: float, out: Path | None, offset_only: bool, diff: bool, json: bool,
) -> int:  # fmt: skip
    from vcmm.compensating.job import compensate
    from vcmm.compensating.source import write_source
    from vcmm.console.documents import document, print_json
    from vcmm.console.terminal import progress, say
    from vcmm.core.errors import UsageError, choose_from
    from vcmm.core.units import quantity

    machine: Any = None
    constants: Any = None
    given: Any = setup
    here = set_on == "this machine"
    files = [program] + ([setup] if setup else [])
    if setup is None and program.suffix == ".toml":
        from vcmm.files.cut_scenario import load_cut

        scenario = load_cut(program)
        program, given, machine, constants = (
            scenario.program,
            replace(scenario.setup, set_at=scenario.set_at),
            scenario.machine,
            scenario.constants,
        )
        here, dialect, files = here and scenario.set_here, dialect or scenario.dialect, [*files, program]
    if given is None:
        raise UsageError(
            "the machine's position must be known: name a set-up file with --setup setup.toml (machine, work offsets, tools)"
        )
    if set_on not in ("this machine", "elsewhere"):
        raise UsageError(f'--set-on "{set_on}".{choose_from(set_on, ["this machine", "elsewhere"])}')
    limit = quantity(tolerance, "length", "--tolerance", "1 um")
    target = out or Path(f"{program.stem}-compensated{program.suffix}")
    if target.exists() and program.exists() and target.samefile(program):
        raise UsageError(f"{target} is the program itself; choose another file with --out")
    if offset_only:
        return _offsets(
            program,
            given,
            machine,
            dialect=dialect,
            set_here=here,
            constants=constants,
            files=files,
            json=json,
        )
    with progress() as report:
        found = compensate(
            program, given, machine, dialect=dialect, tolerance=limit, decimals=decimals, set_here=here,
            carry=carry, growth=growth, inline=inline, constants=constants, progress=report,
        )  # fmt: skip
    write_source(target, found.data)
    say(f"wrote {target}")
    if json:
        body = compensation_json(found, target)
        print_json(document("vcmm.compensation/1", body, files=files, warnings=found.warnings))
    else:
        _show(found)
        if diff:
            _show_diff(program, target, found)
    return 0 if found.met else 1


def _offsets(
    program: Path, setup: Any, machine: Any, dialect: str | None, set_here: bool, constants: Any, files: list[Path], json: bool
) -> int:  # fmt: skip
    """--offset-only: nothing is written."""
    from vcmm.compensating.offsets import best_offsets
    from vcmm.console.documents import document, print_json
    from vcmm.console.terminal import say, show_table
    from vcmm.tables.compensated import departure_json, departures, shifts, shifts_json

    found = best_offsets(program, setup, machine, dialect=dialect, set_here=set_here, constants=constants)
    if json:
        body = {
            "program": found.name, "dialect": found.dialect, "machine": found.machine, "file": None,
            "deviation": {"before": departure_json(found.before), "offset_only": departure_json(found.offset_only)},
            "offset_shift_mm": shifts_json(found),
        }  # fmt: skip
        print_json(document("vcmm.compensation/1", body, files=files, warnings=found.warnings))
        return 0
    show_table(
        departures(found, [("as programmed", found.before), ("work offsets shifted", found.offset_only)])
    )
    show_table(shifts(found))
    for warning in found.warnings:
        say(f"note: {warning}")
    return 0


def compensation_json(found: Any, target: Path) -> dict[str, Any]:
    """The body of the JSON document; lengths in um, as people say them."""

    from vcmm.tables.compensated import departure_json, shifts_json

    r, b = found.rounding, found.blocks
    return {
        "program": found.name, "dialect": found.dialect, "machine": found.machine, "file": str(target),
        "tolerance_um": found.tolerance * 1e3, "tolerance_used_um": found.used * 1e3, "met": found.met,
        "deviation": {
            "before": departure_json(found.before), "offset_only": departure_json(found.offset_only), "after": departure_json(found.after),
            "before_with_dynamic": departure_json(found.whole[0]) if found.whole else None,
            "after_with_dynamic": departure_json(found.whole[1]) if found.whole else None,
        },
        "offset_shift_mm": shifts_json(found),
        "rounding": {"step_mm": r.step, "max_um": r.largest * 1e3, "rms_um": r.rms * 1e3, "share": r.share},
        "blocks": {
            "before": b.before, "after": b.after, "growth": b.growth, "changed": b.changed, "added": b.added,
            "rate_before_1_s": b.rate_before, "rate_after_1_s": b.rate_after, "rate_line": b.rate_line,
        },
        "hash": found.digest,
    }  # fmt: skip


def _show(found: Any) -> None:
    from vcmm.console.terminal import say, show_table
    from vcmm.tables.compensated import before_and_after, departures, shifts

    show_table(departures(found, before_and_after(found)))
    show_table(shifts(found))
    r, b = found.rounding, found.blocks
    print(
        f"tolerance {found.used * 1e3:g} um: {'met everywhere' if found.met else 'NOT met everywhere'} (rounding to {r.step:g} mm: "
        f"up to {r.largest * 1e3:.2f} um, {r.share:.0%} of the mean square that is left)\n"
        f"blocks with motion: {b.before} before, {b.after} after (x {b.growth:.2f}), {b.changed} changed, {b.added} added; "
        f"at most {b.rate_after:.1f} blocks/s (was {b.rate_before:.1f}), line {b.rate_line}"
    )
    for warning in found.warnings:
        say(f"note: {warning}")


def _show_diff(program: Path, target: Path, found: Any) -> None:
    import difflib

    from vcmm.compensating.source import read_source

    old = [line for line, _ in read_source(program).lines]
    new = found.text.replace("\r\n", "\n").replace("\r", "\n").rstrip("\n").split("\n")
    for line in difflib.unified_diff(old, new, str(program), str(target), lineterm="", n=1):
        print(line)
