"""The two forms of vcmm compensate that take a machine: corrected points, and tables for a control."""

from __future__ import annotations

from pathlib import Path


def machine_form(machine: Path, points: Path | None, table: str | None, out: Path | None, json: bool) -> int:
    """One of the two. Raises UsageError where both are asked for."""
    from vcmm.core.errors import UsageError

    if points is not None and table is not None:
        raise UsageError("--points and --table exclude each other; give one of them")
    return points_form(machine, points, out, json) if points else table_form(machine, str(table), out, json)


def points_form(machine: Path, points: Path, out: Path | None, json: bool) -> int:
    """MACHINE --points measured.csv: indicated to corrected points."""
    from vcmm.compensation.points import corrected_points
    from vcmm.face.cli.field import rows_of
    from vcmm.files.columns import read_positions
    from vcmm.files.foreign.compensation_tables import without_scatter
    from vcmm.files.own.machine import load_machine
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.files import write_text
    from vcmm.show.console.terminal import say
    from vcmm.show.tables.compensation import points_csv
    from vcmm.task.response.logs import with_logs

    loaded = without_scatter(load_machine(machine))
    run = with_logs(read_positions(points, loaded.chain.letters))
    with rows_of(machine, points):
        found = corrected_points(loaded, run)
    target = out or Path(f"{points.stem}-corrected.csv")
    write_text(target, points_csv(found))
    say(f"wrote {target}")
    largest = max((float((e**2).sum() ** 0.5) for e in found.error), default=0.0)
    if json:
        body = {
            "machine": loaded.name, "points": len(found.error), "file": str(target), "max_um": largest * 1e3,
            "corrected_mm": found.corrected.tolist(), "error_mm": found.error.tolist(),
        }  # fmt: skip
        print_json(document("vcmm.compensated-points/1", body, files=[*sources(machine), points]))
    else:
        print(f"{len(found.error)} points of {loaded.name}: errors up to {largest * 1e3:.2f} µm taken off")
    return 0


def table_form(machine: Path, form: str, out: Path | None, json: bool) -> int:
    """MACHINE --table FORMAT: tables for a control, in the folder --out (default: the current one)."""
    from vcmm.files.foreign.compensation_tables import control_tables
    from vcmm.files.own.machine import load_machine
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.files import write_files
    from vcmm.show.console.terminal import say

    loaded = load_machine(machine)
    found = control_tables(loaded, form)
    written = write_files(out or Path(f"{machine.stem}-{form}"), found.files)
    if json:
        body = {
            "machine": loaded.name,
            "format": form,
            "files": [str(p) for p in written],
            "left_out": list(found.left_out),
        }
        print_json(document("vcmm.compensation-table/1", body, files=sources(machine)))
        return 0
    for path in written:
        print(path)
    for text in found.left_out:
        say(f"note: {text}")
    return 0
