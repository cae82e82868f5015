"""vcmm convert: convert files of other systems (STEP, QIF, DMIS, DCC) to vcmm files."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path

from vcmm.face.cli.options import InputFile, Json
from vcmm.face.converting import convert_file, refuse_taken
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.files.foreign.convert import ConvertedFiles
from vcmm.show.console.terminal import say


def convert_command(
    file: InputFile,
    *,
    machine: InputFile | None = None,
    out: Path | None = None,
    json: Json = False,
) -> int:
    """Make vcmm files of a file of another system: a part with plan, a machine with errors, quantities of a certificate.

    STEP (planes, cylinders, cones, spheres, tori; tolerances of AP242; needs vcmm[step]), QIF 3.0 (features, characteristics, measured points, 21 errors of a machine), DMIS (features, tolerances, touches), DCC
    (quantities), values and points that PC-DMIS or CALYPSO exported. What the file does not say is assumed and said; what vcmm has no word for is left out and said.

    Parameters
    ----------
    file
        The file: .step, .stp, .qif, .dmi, .dmis, .xml (DCC), .txt, .asc, .xyz (exports).
    machine
        Machine file (machine/1) of the scenario; without it a placeholder machine with a certificate is used.
    out
        Folder for the files (default: the name of the file without its ending).
    json
        Print one JSON document.
    """
    folder = out or Path(file.stem)
    return run_job(ConvertJob(file, machine, folder), Flags(json, folder))


@dataclass(frozen=True)
class ConvertJob(Job[Path, tuple[ConvertedFiles, list[str]]]):
    """One file converted; the result: its files, and the problems that `vcmm check` reports for them. folder: where they are written."""

    file: Path
    machine: Path | None
    folder: Path
    schema = "vcmm.convert/1"

    def load(self) -> Path:
        return self.file

    def run(self, loaded: Path, report: Progress) -> tuple[ConvertedFiles, list[str]]:
        made, problems = convert_file(loaded, self.machine, self.folder)
        refuse_taken(self.folder, made.texts)
        return made, problems

    def record(self, loaded: Path, result: tuple[ConvertedFiles, list[str]]) -> Record:
        made, problems = result
        body = {
            "kind": made.kind,
            "counts": made.counts,
            "written": [str(path) for path in self.written_paths(made)],
            "notes": list(made.notes),
            "problems": problems,
        }
        return Record(body, [loaded], warnings=[*made.notes, *problems])

    def written_paths(self, made: ConvertedFiles) -> list[Path]:
        return [self.folder / name for name in made.texts]

    def texts(self, loaded: Path, result: tuple[ConvertedFiles, list[str]], content: str, folder: Path) -> dict[str, str]:  # fmt: skip
        return result[0].texts

    def files_sentence(self, loaded: Path, result: tuple[ConvertedFiles, list[str]], folder: Path, names: Sequence[str]) -> str:  # fmt: skip
        return ""  # the answer names them

    def show(self, loaded: Path, result: tuple[ConvertedFiles, list[str]]) -> None:
        made, problems = result
        for note in (*made.notes, *problems):
            say(f"note: {note}")
        print(f"{made.kind}: " + ", ".join(f"{n} {what}" for what, n in made.counts.items()))
        print(f"wrote {', '.join(map(str, self.written_paths(made)))}")
        if made.check:
            print(f"next: vcmm check {self.folder / made.check}")
