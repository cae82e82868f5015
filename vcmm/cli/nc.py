"""vcmm nc: what an NC program means."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter


def nc_command(
    program: Path,
    *,
    dialect: str | None = None,
    setup: Path | None = None,
    moves: bool = False,
    time: bool = False,
    json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:
    """What an NC program means: its moves as tool-tip positions, times, extents, remarks.

    Parameters
    ----------
    program
        NC program.
    dialect
        How it is written: fanuc, fanuc-lathe, linuxcnc ...; default: that of the set-up file, else guessed.
    setup
        Set-up file (setup/1): work offsets, tools, reference points. Without it: zero, and tools unknown.
    moves
        Print every move.
    time
        Cycle time by the time law, by mode and by tool; the set-up must name a machine. About 0.1 ms per move.
    json
        Print one JSON document.
    """
    from dataclasses import replace

    from vcmm.console.documents import document, print_json
    from vcmm.console.terminal import say
    from vcmm.core.text import is_file
    from vcmm.files.machine import load_machine
    from vcmm.files.setup import load_setup
    from vcmm.nc.interpret import read_program
    from vcmm.nc.moves import Remark
    from vcmm.nc.sensible import remarks_on
    from vcmm.nc.summary import summary

    loaded = load_setup(setup) if setup else None
    read = read_program(program, dialect, loaded)
    if loaded is not None:
        there = loaded.machine is not None and is_file(Path(loaded.machine))
        machine = load_machine(loaded.machine) if there and loaded.machine else None
        said = list(remarks_on(read.moves, loaded, machine))
        if loaded.machine and not there:
            said.append(Remark(1, 1, f"{loaded.machine} does not exist: travels are not looked at"))
        read = replace(read, warnings=(*read.warnings, *said))
    if read.dialect_reason and not json:
        say(f"dialect {read.dialect}: {read.dialect_reason}")
    total = summary(read.moves, loaded)
    path = _timed(read, loaded) if time else None
    if json:
        files = [program] + ([setup] if setup else [])
        body = nc_json(read, total) | ({"time": time_json(path)} if time else {})
        print_json(document("vcmm.nc/1", {}, files=files) | body)
    else:
        _show(program, read, total, moves)
        if time:
            _show_time(path)
    return 0


def _timed(read: Any, setup: Any) -> Any:
    """The motion of the program in time, on the machine of the set-up."""
    from vcmm.core.errors import UsageError
    from vcmm.files.machine import load_machine
    from vcmm.motion.toolpath import toolpath

    if setup is None or setup.machine is None:
        raise UsageError(
            '--time needs the machine: name a set-up with --setup, with machine = "mill.toml" in it'
        )
    return toolpath(read, load_machine(setup.machine), setup, step=1e9, chord=1e3)


def time_json(path: Any) -> dict[str, Any]:
    """Cycle time, by mode and by tool, and what had to be assumed."""
    return {
        "seconds": path.seconds, "by_mode": path.seconds_by("mode"), "by_tool": path.seconds_by("tool"),
        "assumptions": list(path.assumptions),
    }  # fmt: skip


def _show_time(path: Any) -> None:
    from vcmm.console.terminal import say, show_table
    from vcmm.tables.program import times

    show_table(times(path))
    for text in path.assumptions:
        say(f"note: assumed: {text}")


def nc_json(read: Any, total: Any) -> dict[str, Any]:
    """The body of the JSON document."""
    from vcmm.tables.program import move_json

    warnings = [{"line": w.line, "column": w.column, "text": w.text} for w in read.warnings]
    if read.dialect_reason:
        text = f"the dialect {read.dialect} was guessed: {read.dialect_reason}"
        warnings.insert(0, {"line": 1, "column": 1, "text": text})
    return {
        "dialect": read.dialect,
        "moves": [move_json(m) for m in read.moves],
        "summary": total.as_json(),
        "tools": {str(number): name for number, name in read.tools.items()},
        "warnings": warnings,
    }


def _show(program: Path, read: Any, total: Any, moves: bool) -> None:

    from vcmm.console.terminal import show_table
    from vcmm.tables import program as tables

    name = program.name
    if moves:
        show_table(tables.moves(name, read))
    show_table(tables.kinds(name, read, total))
    show_table(tables.extents(read, total))
    if read.warnings:
        show_table(tables.remarks(name, read))
