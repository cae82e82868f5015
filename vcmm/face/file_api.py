"""NC programs and files of other systems as Python calls."""

from __future__ import annotations

from collections.abc import Mapping
from dataclasses import dataclass
from pathlib import Path
from typing import TYPE_CHECKING, Any

from vcmm.core.readable import Readable, Reading
from vcmm.face import machine_readings

if TYPE_CHECKING:
    from vcmm.program.moves import Program
    from vcmm.program.setup import Setup
    from vcmm.program.summary import ProgramSummary


@dataclass(frozen=True, eq=False)
class ProgramMeaning(Readable):
    """Meaning of an NC program: its moves and remarks in `program`, lengths, times and extents in `summary`."""

    name: str
    program: Program
    summary: ProgramSummary
    reading: Reading | None = None

    def __repr__(self) -> str:
        return f"<ProgramMeaning {self.name}: {self.program.dialect}, {len(self.moves)} moves, {len(self.warnings)} remarks>"

    @property
    def moves(self) -> tuple[Any, ...]:
        """Tool-tip positions in the machine frame, mm, one move after the other."""
        return self.program.moves

    @property
    def warnings(self) -> tuple[Any, ...]:
        """Remarks with line, column and text."""
        return self.program.warnings


def nc(
    program: str | Path,
    *,
    dialect: str | None = None,
    setup: str | Path | Setup | None = None,
    strict: bool = False,
) -> ProgramMeaning:
    """Read an NC program: its moves as tool-tip positions in the machine frame, extents, remarks.

    Parameters
    ----------
    program
        File of the program.
    dialect
        How it is written: "fanuc", "fanuc-lathe", "linuxcnc" ...; default: that of the set-up, else guessed.
    setup
        Set-up, or the path of its file; without it work offsets are zero and tools unknown.
    strict
        Assume nothing: refuse what the program lacks and the machine would have in its memory.

    Returns
    -------
    ProgramMeaning
        `moves`, `warnings`, `summary`.

    Raises
    ------
    DataError
        The program cannot be read: line, column and reason.
    """
    from vcmm.face.programs import machine_of, understand_program
    from vcmm.files.own.setup import load_setup
    from vcmm.program.summary import summary

    files = [Path(program), *([Path(setup)] if isinstance(setup, str | Path) else [])]
    loaded = load_setup(setup) if isinstance(setup, str | Path) else setup
    read = understand_program(Path(program), dialect, loaded, strict)
    total = summary(read.moves, loaded)
    reading = machine_readings.program_reading(Path(program), total, machine_of(loaded), files)
    return ProgramMeaning(Path(program).name, read, total, reading)


@dataclass(frozen=True, eq=False)
class ConvertedFile(Readable):
    """Result of converting a file of another system: its kind, counts, the files that were written, assumptions and omissions (`notes`),
    and the problems that `vcmm check` reports for it (`problems`).
    """

    kind: str
    counts: Mapping[str, int]
    output_files: tuple[Path, ...]
    notes: tuple[str, ...]
    problems: tuple[str, ...]
    reading: Reading | None = None

    def __repr__(self) -> str:
        counted = ", ".join(f"{n} {what}" for what, n in self.counts.items())
        return f"<ConvertedFile {self.kind}: {counted}; {len(self.output_files)} files written>"

    def body(self) -> dict[str, Any]:
        """Return the body of the document."""
        return {
            "kind": self.kind, "counts": dict(self.counts), "written": [str(p) for p in self.output_files],
            "notes": list(self.notes), "problems": list(self.problems),
        }  # fmt: skip


def convert(
    file: str | Path, *, machine: str | Path | None = None, out: str | Path | None = None
) -> ConvertedFile:
    """Make vcmm files of a STEP, QIF, DMIS or DCC file, or of an export of PC-DMIS or CALYPSO.

    Parameters
    ----------
    file
        The file.
    machine
        Machine file of the scenario; without it a placeholder machine with a certificate is used.
    out
        Folder for the files (default: the name of the file without its ending).

    Returns
    -------
    ConvertedFile
        What was written, what was assumed or left out.

    Raises
    ------
    DataError, UsageError
        The file is not understood; a file of the same name is there already.
    """
    from vcmm.face.converting import written_files

    named = [None if p is None else Path(p) for p in (machine, out)]
    made, problems, written = written_files(Path(file), *named)
    reading = machine_readings.converted_reading(Path(file))
    return ConvertedFile(made.kind, made.counts, tuple(written), made.notes, tuple(problems), reading)
