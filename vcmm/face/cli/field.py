"""vcmm field: the volumetric error map of a machine."""

from __future__ import annotations

import re
from collections.abc import Iterator
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path
from typing import NamedTuple

from vcmm.answer.evaluation.checks import independent_draws
from vcmm.core.errors import ModelLimit
from vcmm.core.machine import Machine
from vcmm.core.run import Run
from vcmm.face.cli.options import InputFile, Json
from vcmm.face.job import Flags, Job, Progress, Record, run_job
from vcmm.files.columns import read_positions
from vcmm.files.own.machine import load_machine
from vcmm.files.sheets import read_csv
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import show_answers, show_table
from vcmm.show.tables.answers import field_answers
from vcmm.show.tables.error_field import field_csv, field_json, maxima
from vcmm.task.response.logs import with_logs
from vcmm.task.response.volumetric import ErrorField, field, grid, missing_columns


def field_command(
    machine: InputFile,
    *,
    at: InputFile | None = None,
    exact: bool = False,
    nodes: int = 5,
    json: Json = False,
    out: Path | None = None,
) -> int:
    """Compute the volumetric error map: tip errors (actual - nominal), their U, maxima, body diagonals.

    Parameters
    ----------
    machine
        Machine file (machine/1).
    at
        CSV of positions (X_mm, Y_mm ... offset_x_mm ...); without it a grid over the travels.
    exact
        Multiply the transforms instead of first order.
    nodes
        Nodes per axis of the grid.
    json
        Print one JSON document.
    out
        Folder for field.html (picture of the deformed volume), field.csv and field.json.
    """
    return run_job(FieldJob(machine, at, exact, nodes), Flags(json, out))


class MappedMachine(NamedTuple):
    """A machine, the positions to map (None for a grid), and effects that such rows cannot show: (effect, its columns)."""

    machine: Machine
    run: Run | None
    absent: tuple[tuple[str, tuple[str, ...]], ...]


@dataclass(frozen=True)
class FieldJob(Job[MappedMachine, ErrorField]):
    """The error map of a machine, at positions or on a grid."""

    machine: Path
    at: Path | None
    exact: bool
    nodes: int
    schema = "vcmm.field/1"

    def load(self) -> MappedMachine:
        machine = load_machine(self.machine)
        run = with_logs(read_positions(self.at, machine.chain.letters)) if self.at else None
        return MappedMachine(machine, run, missing_columns(machine, run or grid(machine, 2)))

    def run(self, loaded: MappedMachine, report: Progress) -> ErrorField:
        with rows_of(self.machine, self.at):
            return field(loaded.machine, loaded.run, self.exact, self.nodes)

    def record(self, loaded: MappedMachine, result: ErrorField) -> Record:
        not_mapped = {name: list(columns) for name, columns in loaded.absent}
        files = sources(self.machine) + ([self.at] if self.at else [])
        return Record({**field_json(result), "not_mapped": not_mapped}, files)

    def texts(self, loaded: MappedMachine, result: ErrorField, content: str, folder: Path) -> dict[str, str]:
        from vcmm.show.pages.field import field_page

        return {
            "field.html": field_page(loaded.machine, result),
            "field.csv": field_csv(loaded.machine, result),
            "field.json": content,
        }

    def show(self, loaded: MappedMachine, result: ErrorField) -> None:
        show_answers(field_answers(loaded.machine, result))
        show_table(maxima(loaded.machine, result))

    def notes(self, loaded: MappedMachine, result: ErrorField) -> Iterator[str]:
        """Yield the limits of the map, and the Inputs that its U does not include."""
        if result.within:
            ranges = ", ".join(f"{a} {low:g} to {high:g} mm" for a, low, high in result.within)
            yield f"note: mapped where every effect is known: within {ranges}; body diagonals of the travels lie beyond"
        for text in independent_draws(loaded.machine.inputs):
            yield f"warning: {text}"
        if result.left_out:
            yield f"note: not in U, which is that of one positioning at 20 degC: {', '.join(result.left_out)}"
        if loaded.absent:
            named = ", ".join(f"{name} ({', '.join(columns)})" for name, columns in loaded.absent)
            more = "" if self.at else "; give such rows with --at"
            yield f"note: not in this map, which holds positions only: {named}{more}"


@contextmanager
def rows_of(machine: Path, at: Path | None) -> Iterator[None]:
    """Give a complaint about a row the line of the positions file; without one, the way to choose the positions."""
    try:
        yield
    except ModelLimit as error:
        text = str(error)
        row = re.match(r"row (\d+): ", text)
        if at is None:
            raise ModelLimit(f"{machine}: {text}; or choose the positions with --at") from None
        if not row:
            raise ModelLimit(f"{at}: {text}") from None
        raise ModelLimit(f"{read_csv(at).at(int(row[1]) - 1)}: {text[row.end() :]}") from None
