"""vcmm nc: the meaning of an NC program."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, NamedTuple

from vcmm.core.errors import UsageError
from vcmm.face.cli.options import InputFile, InputPath, Json
from vcmm.face.job import Flags, Job, Progress, Record, compute, run_job
from vcmm.face.programs import at_level, machine_of, understand_program
from vcmm.program.moves import Program
from vcmm.program.reading import read_bytes
from vcmm.program.setup import Setup
from vcmm.program.summary import ProgramSummary, summary
from vcmm.show.console.files import write_text
from vcmm.show.console.terminal import say, show_answers, show_table

if TYPE_CHECKING:
    from vcmm.shop.motion.toolpath import Toolpath


def nc_command(
    program: InputPath,
    *,
    dialect: str | None = None,
    setup: InputFile | None = None,
    moves: bool = False,
    time: bool = False,
    strict: bool = False,
    plot: bool = False,
    write_setup: Path | None = None,
    out: Path | None = None,
    json: Json = False,
) -> int:
    """Read an NC program: its moves as tool-tip positions, times, extents, remarks.

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
    loaded = None
    if setup is not None:
        from vcmm.files.own.setup import load_setup

        loaded = load_setup(setup)
    if program.is_dir():
        from vcmm.face.cli.nc_folder import NcFolderJob

        return run_job(NcFolderJob(program, dialect, at_level(loaded, strict), json), Flags(json, out))
    if json and loaded is None and not (time or plot or write_setup):
        from vcmm.show.console.program_document import json_job

        return json_job(program, dialect, at_level(None, strict))
    job = NcJob(
        program, dialect, setup, loaded, strict=strict, moves=moves, time=time, plot=plot, write_setup=write_setup, folder=out
    )  # fmt: skip
    return job.print_stream() if json else run_job(job, Flags())


class UnderstoodProgram(NamedTuple):
    """The program, its motion in time where --time is given, and the files that were written."""

    read: Program
    path: Toolpath | None
    files: list[Path]


@dataclass(frozen=True)
class NcJob(Job["Setup | None", UnderstoodProgram]):
    """Meaning of one program. Its document is written move by move (`print_stream`), so that a program of a million lines need not be held
    twice; all else is as with every job. write_setup: the file of --write-setup; folder: of --out, for the page."""

    program: Path
    dialect: str | None
    setup: Path | None
    given_setup: Setup | None
    strict: bool
    moves: bool
    time: bool
    plot: bool
    write_setup: Path | None
    folder: Path | None
    schema = "vcmm.nc/1"

    def load(self) -> Setup | None:
        return self.given_setup

    def run(self, loaded: Setup | None, report: Progress) -> UnderstoodProgram:
        read = understand_program(self.program, self.dialect, loaded, self.strict)
        path = _time_program(read, loaded) if self.time else None
        written = self._page(read, loaded, path) if self.plot else []
        if self.write_setup is not None:
            written.append(_write_setup(self.program, read, self.write_setup))
        return UnderstoodProgram(read, path, written)

    def _page(self, read: Program, setup: Setup | None, path: Toolpath | None) -> list[Path]:
        """Return the page of --plot."""
        from vcmm.show.pages.program import program_page

        data, machine = read_bytes(self.program), machine_of(setup)
        html = program_page(self.program.name, read, summary(read.moves, setup), data, machine, path)
        return [write_text((self.folder or Path()) / f"{self.program.stem}.html", html)]

    def inputs(self) -> list[Path]:
        return [self.program, *([self.setup] if self.setup else [])]

    def record(self, loaded: Setup | None, result: UnderstoodProgram) -> Record:
        return Record({}, self.inputs())  # only of the words: the document is that of `print_stream`

    def print_stream(self) -> int:
        from vcmm.show.console.program_document import MoveFile, print_read, time_json

        loaded, result = compute(self)
        machine = machine_of(loaded)
        further = {"time": time_json(result.path)} if result.path is not None else {}
        with MoveFile(loaded, "".join(machine.axes) if machine else "ABC") as moves:
            moves.take(result.read.moves)
            print_read(result.read, moves, self.inputs(), further)
        return 0

    def show(self, loaded: Setup | None, result: UnderstoodProgram) -> None:
        """Show the program."""
        read = result.read
        if read.dialect_reason:
            say(f"dialect {read.dialect}: {read.dialect_reason}")
        _show(self.program, read, summary(read.moves, loaded), self.moves, result.path)
        if result.path is not None:
            _show_time(result.path)
        for path in result.files:
            say(f"wrote {path}")


def _write_setup(program: Path, read: Program, file: Path) -> Path:
    """Write the file of --write-setup; an existing one is not overwritten."""
    from vcmm.files.own.blank_setup import blank_setup

    if file.exists():
        raise UsageError(f"{file} is there already; name another file with --write-setup")
    return write_text(file, blank_setup(read, program.name))


def _time_program(read: Program, setup: Setup | None) -> Toolpath:
    """Return the motion of the program in time, on the machine of the set-up."""
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


def _show_time(path: Toolpath) -> None:
    from vcmm.show.tables import program as tables

    show_table(tables.times(path))
    for text in path.assumptions:
        say(f"note: assumed: {text}")


def _show(program: Path, read: Program, total: ProgramSummary, moves: bool, path: Toolpath | None) -> None:
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
