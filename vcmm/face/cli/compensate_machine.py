"""The two forms of vcmm compensate that take a machine: corrected points, and tables for a control."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from vcmm.compensation.points import CorrectedPoints, corrected_points
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.face.cli.field import rows_of
from vcmm.face.job import Job, Progress, Record
from vcmm.files.columns import read_positions
from vcmm.files.foreign.compensation_tables import Tables, control_tables, without_scatter
from vcmm.files.own.machine import load_machine
from vcmm.show.console.documents import sources
from vcmm.show.console.files import write_text
from vcmm.show.console.terminal import say
from vcmm.show.tables.compensation import points_csv
from vcmm.task.response.logs import with_logs


class Indicated(NamedTuple):
    """A machine without its scatter, and the indicated positions of its tip."""

    machine: Machine
    run: Run


@dataclass(frozen=True)
class PointsJob(Job[Indicated, CorrectedPoints]):
    """MACHINE --points measured.csv: indicated to corrected points. target: the file of the result."""

    machine: Path
    points: Path
    target: Path
    schema = "vcmm.compensated-points/1"

    def load(self) -> Indicated:
        machine = without_scatter(load_machine(self.machine))
        return Indicated(machine, with_logs(read_positions(self.points, machine.chain.letters)))

    def run(self, loaded: Indicated, report: Progress) -> CorrectedPoints:
        with rows_of(self.machine, self.points):
            return corrected_points(loaded.machine, loaded.run)

    def record(self, loaded: Indicated, result: CorrectedPoints) -> Record:
        body = {
            "machine": loaded.machine.name, "points": len(result.error), "file": str(self.target), "max_um": largest_error(result) * 1e3,
            "corrected_mm": result.corrected.tolist(), "error_mm": result.error.tolist(),
        }  # fmt: skip
        return Record(body, [*sources(self.machine), self.points])

    def export(self, loaded: Indicated, result: CorrectedPoints, content: dict[str, object]) -> None:
        write_text(self.target, points_csv(result))
        say(f"wrote {self.target}")

    def show(self, loaded: Indicated, result: CorrectedPoints) -> None:
        count, name = len(result.error), loaded.machine.name
        print(f"{count} points of {name}: errors up to {largest_error(result) * 1e3:.2f} µm taken off")


def largest_error(corrected: CorrectedPoints) -> float:
    """Return the largest error of all points in mm; 0 without points."""
    return max((float((e**2).sum() ** 0.5) for e in corrected.error), default=0.0)


@dataclass(frozen=True)
class TableJob(Job[Machine, Tables]):
    """MACHINE --table FORMAT: tables for a control. folder: where they are written."""

    machine: Path
    form: str
    folder: Path
    schema = "vcmm.compensation-table/1"

    def load(self) -> Machine:
        return load_machine(self.machine)

    def run(self, loaded: Machine, report: Progress) -> Tables:
        return control_tables(loaded, self.form)

    def record(self, loaded: Machine, result: Tables) -> Record:
        body = {
            "machine": loaded.name, "format": self.form,
            "files": [str(self.folder / name) for name in result.files], "left_out": list(result.left_out),
        }  # fmt: skip
        return Record(body, sources(self.machine))

    def texts(self, loaded: Machine, result: Tables, content: str, folder: Path) -> dict[str, str]:
        return result.files

    def files_sentence(self, loaded: Machine, result: Tables, folder: Path, names: Sequence[str]) -> str:
        return ""  # the answer names them

    def show(self, loaded: Machine, result: Tables) -> None:
        for name in result.files:
            print(self.folder / name)
        for text in result.left_out:
            say(f"note: {text}")
