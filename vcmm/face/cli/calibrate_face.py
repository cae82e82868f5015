"""vcmm calibrate face: a scan of a turned or milled face, its map, and the program corrected for it."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from vcmm.compensation.result import CompensatedProgram
from vcmm.compensation.source import write_source
from vcmm.core.errors import UsageError
from vcmm.core.machine import Machine
from vcmm.core.units import quantity
from vcmm.face.job import Job, Progress, Record
from vcmm.face.public.faces import FaceMap, FaceScan, correct_face, load_face_scan, map_face
from vcmm.files.own.machine import load_machine
from vcmm.files.toml import read_toml
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import say_warnings, show_table
from vcmm.show.pages.faces import face_page
from vcmm.show.tables import faces as tables
from vcmm.show.tables.compensation import departure_json


@dataclass(frozen=True)
class FaceProgram:
    """The program that cut the face, as requested. lines: "FIRST-LAST", or "" for all that pass over the scan."""

    path: Path | None
    setup: Path | None
    lines: str
    tolerance: str
    decimals: int | None


class ScannedFace(NamedTuple):
    """A scan, and the machine that scanned; None where its errors are not subtracted."""

    scan: FaceScan
    machine: Machine | None


class MappedFace(NamedTuple):
    """The map, and the program corrected for it; None where none was named."""

    face: FaceMap
    better: CompensatedProgram | None

    @property
    def notes(self) -> list[str]:
        return [*self.face.warnings, *(self.better.warnings if self.better else ())]


@dataclass(frozen=True)
class FaceJob(Job[ScannedFace, MappedFace]):
    """A face mapped, and the program that cut it written again. folder: of --out."""

    scan: Path
    machine: Path | None
    program: FaceProgram
    folder: Path | None
    schema = "vcmm.face/1"

    def load(self) -> ScannedFace:
        machine = None if self.machine is None else load_machine(self.machine)
        return ScannedFace(load_face_scan(self.scan), machine)

    def run(self, loaded: ScannedFace, report: Progress) -> MappedFace:
        """Raises UsageError where the corrected program has no place to go, or would lie over the program."""
        face = map_face(loaded.scan, loaded.machine)
        better = _correction(face, self.program)
        if better is not None:
            if self.folder is None:
                raise UsageError("--program writes a corrected program: name a folder for it with --out")
            self.refuse_taken(self.folder)
        return MappedFace(face, better)

    def target(self, folder: Path) -> Path:
        """Return the path of the corrected program."""
        program = self.program.path
        assert program is not None  # a correction is of a program
        return folder / f"{program.stem}-compensated{program.suffix}"

    def refuse_taken(self, folder: Path) -> None:
        target = self.target(folder)
        if target.exists() and self.program.path is not None and target.samefile(self.program.path):
            raise UsageError(f"{target} is the program itself; choose another folder with --out")

    def record(self, loaded: ScannedFace, result: MappedFace) -> Record:
        body = tables.face_json(result.face)
        if result.better is not None:
            body |= {"program": _program(result.better)}
        named = (self.scan, _data(self.scan), self.machine, self.program.path, self.program.setup)
        read = [p for p in named if p is not None]
        files = list(dict.fromkeys(f for p in read for f in ([p] if p.suffix != ".toml" else sources(p))))
        return Record(body, files, warnings=result.notes)

    def texts(self, loaded: ScannedFace, result: MappedFace, content: str, folder: Path) -> dict[str, str]:
        face = result.face
        texts = {"face.json": content, "face.html": face_page(face), "map.csv": tables.map_csv(face)}
        return texts | ({"profile.csv": tables.profile_csv(face)} if face.r is not None else {})

    def write_binaries(self, loaded: ScannedFace, result: MappedFace, folder: Path) -> list[str]:
        """Return the corrected program, byte by byte unchanged except for the corrections."""
        if result.better is None:
            return []
        target = self.target(folder)
        write_source(target, result.better.data)
        return [target.name]

    def show(self, loaded: ScannedFace, result: MappedFace) -> None:
        show_table(tables.figures(result.face))
        better = result.better
        if better is not None:
            before, after = (d.largest * 1e3 for d in (better.before, better.after))
            print(
                f"program: up to {before:.3g} µm beside its path before, {after:.3g} µm after; {better.blocks.changes} blocks changed, {better.blocks.additions} added"
            )
        say_warnings(result.notes)


def _data(scan: Path) -> Path:
    return scan.parent / str(read_toml(scan).data["data"])


def _correction(face_map: FaceMap, program: FaceProgram) -> CompensatedProgram | None:
    """Return the corrected program; None where none was named."""
    if program.path is None:
        if program.setup is not None or program.lines:
            raise UsageError("--setup and --lines belong to --program; name the program that cut the face")
        return None
    if program.setup is None:
        raise UsageError("--program takes --setup setup.toml as well (machine, work offsets, tools)")
    largest = quantity(program.tolerance, "length", "--tolerance", "1 um")
    return correct_face(
        program.path,
        program.setup,
        face_map,
        lines=_lines(program.lines),
        tolerance=largest,
        decimals=program.decimals,
    )


def _lines(text: str) -> tuple[int, int] | None:
    if not text:
        return None
    first, dash, last = text.partition("-")
    if not (first.strip().isdigit() and (last.strip().isdigit() or not dash)):
        raise UsageError(
            f'--lines "{text}": write the first and the last line of the program that cut the face, such as "12-20"'
        )
    return int(first), int(last or first)


def _program(better: CompensatedProgram) -> dict[str, object]:
    made = {"before": departure_json(better.before), "after": departure_json(better.after)}
    return {
        "name": better.name,
        "dialect": better.dialect,
        "deviation": made,
        "changed": better.blocks.changes,
    }
