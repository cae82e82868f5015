"""vcmm calibrate on files with [reversal]: artefact and machine separated, a machine file with the result."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vcmm.core.errors import UsageError
from vcmm.core.kinematics import parse_structure
from vcmm.face.job import Job, Progress, Record
from vcmm.files.learned.reversed_machine import reversed_texts
from vcmm.files.own.reversal import load_reversal
from vcmm.learn.calibration.reversal import ReversalFile, ReversalResult, separate_all
from vcmm.show.console.documents import sources
from vcmm.show.console.files import output_folder, write_files
from vcmm.show.console.terminal import say, show_table
from vcmm.show.tables.calibration import reversals


@dataclass(frozen=True)
class ReversalJob(Job[list[ReversalFile], list[ReversalResult]]):
    """Every file separated. others: whether options were given that a reversal does not take."""

    files: list[Path]
    structure: str | None
    out: Path | None
    others: bool
    schema = "vcmm.calibration/1"

    def check(self) -> None:
        if self.others:
            raise UsageError(
                "reversals alone take --structure, --out and --json; leave out --errors and --report"
            )

    def load(self) -> list[ReversalFile]:
        return [load_reversal(path) for path in self.files]

    def run(self, loaded: list[ReversalFile], report: Progress) -> list[ReversalResult]:
        """Separate every file. Raises UsageError where the requested machine file cannot be written."""
        results = separate_all(loaded)
        chain = None if self.structure is None else parse_structure(self.structure)
        if self.out is not None and chain is None:
            raise UsageError(
                "a machine file needs the structure of the machine; write for example --structure \"w C' X' b Z t\""
            )
        return results

    def record(self, loaded: list[ReversalFile], result: list[ReversalResult]) -> Record:
        return Record(_body(result, self.out), [source for path in self.files for source in sources(path)])

    def export(
        self, loaded: list[ReversalFile], result: list[ReversalResult], content: dict[str, Any]
    ) -> None:
        """Write the machine file and its tables."""
        if self.out is None or self.structure is None:
            return
        output_folder(self.out.parent)
        names = [f.name for f in self.files]
        texts = reversed_texts(result, parse_structure(self.structure), self.out, names)
        write_files(self.out.parent, texts)
        say(f"wrote {', '.join(str(self.out.parent / name) for name in texts)}")

    def show(self, loaded: list[ReversalFile], result: list[ReversalResult]) -> None:
        show_table(reversals(result))
        for reversal in result:
            for c in reversal.combinations:
                print(f"not identified: {c.text}")


def _body(results: Sequence[ReversalResult], out: Path | None) -> dict[str, Any]:
    """Return the keys of a calibration; `reversals` holds every curve. residual_um, condition: of the worst file."""
    return {
        "machine": None if out is None else str(out),
        "identified": [row for result in results for row in result.rows()],
        "not_identified": [
            {"combination": list(c.names), "text": c.text} for result in results for c in result.combinations
        ],
        "condition": max(result.condition for result in results),
        "residual_um": max(result.scatter for result in results if result.file.kind != "half-turn") * 1e3
        if any(result.file.kind != "half-turn" for result in results)
        else None,
        "reversals": [result.document() for result in results],
    }
