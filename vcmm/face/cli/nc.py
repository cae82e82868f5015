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
        Cycle time by the time law, by mode and by tool; the set-up must name a machine. About 0.1 ms per move.
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
    loaded = _load_setup(setup) if setup else None
    if program.is_dir():
        from vcmm.face.cli.nc_folder import folder_job

        return folder_job(program, dialect, _level(loaded, strict), json, out)
    if json and loaded is None and not (time or plot or write_setup):
        from vcmm.show.console.program_document import json_job

        return json_job(program, dialect, _level(None, strict))
    read = _read(program, dialect, loaded, strict)
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


def _level(setup: Any, strict: bool) -> Any:
    from dataclasses import replace

    from vcmm.program.setup import Setup

    return replace(setup or Setup(), strict=strict)


def _print_json(program: Path, setup: Path | None, loaded: Any, read: Any, path: Any) -> None:
    from vcmm.show.console.program_document import MoveFile, print_read, time_json

    files = [program] + ([setup] if setup else [])
    machine = _machine(loaded)
    with MoveFile(loaded, "".join(machine.axes) if machine else "ABC") as moves:
        moves.take(read.moves)
        print_read(read, moves, files, {"time": time_json(path)} if path is not None else {})


def _page(program: Path, read: Any, setup: Any, out: Path | None, path: Any = None) -> list[Path]:
    """The page of --plot."""
    from vcmm.program.reading import read_bytes
    from vcmm.program.summary import summary
    from vcmm.show.console.files import write_text
    from vcmm.show.pages.program import program_page

    machine = _machine(setup)
    html = program_page(program.name, read, summary(read.moves, setup), read_bytes(program), machine, path)
    return [write_text((out or Path()) / f"{program.stem}.html", html)]


def _machine(setup: Any) -> Any:
    """The machine that a set-up names; None without one, and where its file is missing."""
    from vcmm.core.text import is_file
    from vcmm.files.own.machine import load_machine

    there = setup is not None and setup.machine is not None and is_file(Path(setup.machine))
    return load_machine(setup.machine) if there else None


def _write_setup(program: Path, read: Any, file: Path) -> Path:
    """The file of --write-setup; one that is there is not written over."""
    from vcmm.core.errors import UsageError
    from vcmm.files.own.blank_setup import blank_setup
    from vcmm.show.console.files import write_text

    if file.exists():
        raise UsageError(f"{file} is there already; name another file with --write-setup")
    return write_text(file, blank_setup(read, program.name))


def _read(program: Path, dialect: str | None, setup: Any, strict: bool) -> Any:
    """The program, with remarks on whether it is sensible on the machine of the set-up."""
    from dataclasses import replace

    from vcmm.program.interpret import read_program
    from vcmm.program.moves import Remark
    from vcmm.program.sensible import remarks_on

    read = read_program(program, dialect, _level(setup, strict))
    if setup is None:
        return read
    machine = _machine(setup)
    said = list(remarks_on(read, setup, machine))
    if machine is not None and read.moves:
        from vcmm.shop.motion.tool_centre import orient_moves

        moves, singular = orient_moves(read.moves, machine, str(program))
        read, said = replace(read, moves=moves), [*said, *singular]
    if setup.machine and machine is None:
        said.append(Remark(1, 1, f"{setup.machine} does not exist: travels are not looked at"))
    return replace(read, warnings=(*read.warnings, *said))


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
