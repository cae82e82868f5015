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
    strict: bool = False,
    plot: bool = False,
    write_setup: Path | None = None,
    out: Path | None = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
) -> int:
    """What an NC program means: its moves as tool-tip positions, times, extents, remarks.

    Parameters
    ----------
    program
        NC program, or a folder: a table over all programs in it.
    dialect
        How it is written: fanuc, fanuc-lathe, linuxcnc ...; default: that of the set-up file, else guessed.
    setup
        Set-up file (setup/1): work offsets, tools, reference points. Without it: zero, and tools unknown.
    moves
        Print every move.
    time
        Cycle time by the time law, by mode and by tool; the set-up must name a machine. About 0.5 ms per move.
    strict
        Assume nothing: refuse what the program lacks and the machine would have in its memory.
    plot
        Write PROGRAM.html, beside where you are or in --out: the path by tool, with line and feed under the pointer.
    write_setup
        Write the set-up file that the program asks for, with blanks.
    out
        Folder for the page of --plot, or for programs.csv and programs.html of a folder.
    json
        Print one JSON document.
    """
    from vcmm.face.programs import at_level, understand_program

    loaded = _load_setup(setup) if setup else None
    if program.is_dir():
        from vcmm.face.cli.nc_folder import folder_job

        return folder_job(program, dialect, at_level(loaded, strict), json, out)
    if json and loaded is None and not (time or plot or write_setup):
        from vcmm.show.console.program_document import json_job

        return json_job(program, dialect, at_level(None, strict))
    read = understand_program(program, dialect, loaded, strict)
    path = _time_program(read, loaded) if time else None
    written = _page(program, read, loaded, out, path) if plot else []
    if write_setup is not None:
        written.append(_write_setup(program, read, write_setup))
    if json:
        _print_json(program, setup, loaded, read, path)
    else:
        _tell(program, read, loaded, moves, path, written)
    return 0


def _load_setup(setup: Path) -> Any:
    from vcmm.files.own.setup import load_setup

    return load_setup(setup)


def _tell(program: Path, read: Any, setup: Any, moves: bool, path: Any, written: list[Path]) -> None:
    """What a person reads."""
    from vcmm.program.summary import summary
    from vcmm.show.console.terminal import say

    if read.dialect_reason:
        say(f"dialect {read.dialect}: {read.dialect_reason}")
    _show(program, read, summary(read.moves, setup), moves, path)
    if path is not None:
        _show_time(path)
    for text in written:
        say(f"wrote {text}")


def _print_json(program: Path, setup: Path | None, loaded: Any, read: Any, path: Any) -> None:
    from vcmm.face.programs import machine_of
    from vcmm.show.console.program_document import MoveFile, print_read, time_json

    files = [program] + ([setup] if setup else [])
    machine = machine_of(loaded)
    with MoveFile(loaded, "".join(machine.axes) if machine else "ABC") as moves:
        moves.take(read.moves)
        print_read(read, moves, files, {"time": time_json(path)} if path is not None else {})


def _page(program: Path, read: Any, setup: Any, out: Path | None, path: Any = None) -> list[Path]:
    """The page of --plot."""
    from vcmm.face.programs import machine_of
    from vcmm.program.reading import read_bytes
    from vcmm.program.summary import summary
    from vcmm.show.console.files import write_text
    from vcmm.show.pages.program import program_page

    machine = machine_of(setup)
    html = program_page(program.name, read, summary(read.moves, setup), read_bytes(program), machine, path)
    return [write_text((out or Path()) / f"{program.stem}.html", html)]


def _write_setup(program: Path, read: Any, file: Path) -> Path:
    """The file of --write-setup; one that is there is not written over."""
    from vcmm.core.errors import UsageError
    from vcmm.files.own.blank_setup import blank_setup
    from vcmm.show.console.files import write_text

    if file.exists():
        raise UsageError(f"{file} is there already; name another file with --write-setup")
    return write_text(file, blank_setup(read, program.name))


def _time_program(read: Any, setup: Any) -> Any:
    """The motion of the program in time, on the machine of the set-up."""
    from vcmm.core.errors import UsageError
    from vcmm.files.own.machine import load_machine
    from vcmm.shop.motion.tool_centre import in_machine_axes
    from vcmm.shop.motion.toolpath import toolpath

    if setup is None or setup.machine is None:
        raise UsageError(
            '--time needs the machine: name a set-up with --setup, with machine = "mill.toml" in it'
        )
    machine = load_machine(setup.machine)
    moves, _ = in_machine_axes(read.moves, machine)
    return toolpath(moves, machine, setup, step=1e9, chord=1e3)


def _show_time(path: Any) -> None:
    from vcmm.show.console.terminal import say, show_table
    from vcmm.show.tables.program import times

    show_table(times(path))
    for text in path.assumptions:
        say(f"note: assumed: {text}")


def _show(program: Path, read: Any, total: Any, moves: bool, path: Any = None) -> None:
    from vcmm.show.console.terminal import show_answers, show_table
    from vcmm.show.tables import program as tables
    from vcmm.show.tables.answers_machine import program_answers

    name = program.name
    show_answers(program_answers(read, total, path))
    if read.unused:
        show_table(tables.unused_table(name, read))
    if moves:
        show_table(tables.moves(name, read))
    show_table(tables.kinds(name, read, total))
    show_table(tables.extents(read, total))
    if read.assumed:
        show_table(tables.assumption_table(name, read))
    remarks = tables.remarks(name, read)
    if remarks.rows:
        show_table(remarks)
