"""vcmm place --machines: which of several machines suits the part, each with the part at its best pose."""

from __future__ import annotations

from collections.abc import Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any, NamedTuple

import numpy as np

from vcmm.answer.placing.placement import place
from vcmm.answer.placing.result import place_json
from vcmm.answer.placing.words import amount, pose_text
from vcmm.core.blocks import Sharing, key_of
from vcmm.core.errors import ModelLimit, UsageError, VcmmError, first_of
from vcmm.core.text import read_head
from vcmm.face.job import Progress, Record, SharedJob
from vcmm.files.own.placement_writer import placed_text
from vcmm.files.own.scenario import load_scenario
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import say, show_answers, show_table
from vcmm.show.tables.answers_parts import machine_answers
from vcmm.show.tables.placement import RankedMachine, ranking
from vcmm.show.tables.table import ResultTable, records
from vcmm.task.measuring.scenario import Scenario

Options = dict[str, Any]  # of the search: None where it was not given
Row = dict[str, Any]  # what became of one machine, plain values: blocks of a shard hold it as JSON


class CandidateMachines(NamedTuple):
    """Files of the machines, and the task on each, or what is wrong with the file."""

    files: list[Path]
    tasks: list[Scenario | str]


class Ranked(NamedTuple):
    """Machine file -> its result; order: those that can take the part, the best first."""

    rows: dict[str, Row]
    order: list[str]

    @property
    def best(self) -> Row:
        return self.rows[self.order[0]]

    def table(self) -> ResultTable[RankedMachine]:
        return ranking(self.order, self.rows)


@dataclass(frozen=True)
class PlaceMachinesJob(SharedJob[CandidateMachines, Ranked]):
    """One document: that of the best machine, and the ranking. Machines that cannot take the part are named."""

    scenario: Path
    machine_files: tuple[Path, ...]
    search: Options
    verb, schema = "place", "vcmm.place/1"

    @property
    def stem(self) -> str:
        return self.scenario.stem

    def options(self) -> dict[str, object]:
        return {
            "scenario": str(self.scenario),
            "machines": [str(m) for m in self.machine_files],
            **self.search,
        }

    def inputs(self) -> list[Path]:
        return _read(self.scenario, machines_in(self.machine_files))

    @classmethod
    def of_shards(cls, options: dict[str, Any], sharing: Sharing) -> PlaceMachinesJob:
        search = {k: v for k, v in options.items() if k not in ("scenario", "machines")}
        machine_files = tuple(Path(m) for m in options["machines"])
        return cls(Path(options["scenario"]), machine_files, search, sharing=sharing)

    def load(self) -> CandidateMachines:
        machines = machines_in(self.machine_files)
        return CandidateMachines(machines, _load_tasks(self.scenario, machines))

    def run(self, loaded: CandidateMachines, report: Progress) -> Ranked:
        """Raises UsageError where none can take the part, ShardDone."""
        key, count = key_of("place", self.search, _read(self.scenario, loaded.files)), len(loaded.files)
        report(f"0 of {count} machines", 0.0)
        rows: list[Row] = self.sharing.map_items(
            key, placed_on, self.search, loaded.tasks, lambda s: report(f"{round(s * count)} of {count} machines", s)
        )  # fmt: skip
        by_machine = {str(m): row for m, row in zip(loaded.files, rows)}
        if all(row["refused"] for row in rows):
            why = "; ".join(f"{m}: {row['refused']}" for m, row in by_machine.items())
            raise UsageError(f"none of the machines can take the part: {why}")
        order = sorted(
            (m for m in by_machine if not by_machine[m]["refused"]), key=lambda m: by_machine[m]["value"]
        )
        return Ranked(by_machine, order)

    def record(self, loaded: CandidateMachines, result: Ranked) -> Record:
        table, best = result.table(), result.best
        documented = [
            row | ({"why": result.rows[row["machine"]]["refused"]} if row["machine"] not in result.order else {})
            for row in records(table.columns, table.rows)
        ]  # fmt: skip
        body = best["content"] | {"machine": result.order[0], "machines": documented}
        return Record(body, [*sources(self.scenario), *loaded.files], best["seed"], best["warnings"])

    def texts(self, loaded: CandidateMachines, result: Ranked, content: str, folder: Path) -> dict[str, str]:
        best, machine = result.best, Path(result.order[0])
        near = None if best["convenient"] is None else np.array(best["convenient"])
        placed = placed_text(self.scenario, folder / "placed.toml", np.array(best["pose"]), machine, near)
        return {"place.json": content, "report.html": best["page"], "placed.toml": placed}

    def files_sentence(
        self, loaded: CandidateMachines, result: Ranked, folder: Path, names: Sequence[str]
    ) -> str:
        return f"wrote {folder}/report.html, place.json, placed.toml for {Path(result.order[0])}"

    def show(self, loaded: CandidateMachines, result: Ranked) -> None:
        show_answers(machine_answers(result.order, result.rows))
        show_table(result.table())
        for machine, row in result.rows.items():
            if row["refused"]:
                say(f"note: {machine}: {row['refused']}")


def machines_in(named: Sequence[Path]) -> list[Path]:
    """Return machine files, each once; of a folder all that lie in it and below. Raises UsageError where a folder holds none."""
    out: list[Path] = []
    for path in named:
        if not path.is_dir():
            read_head(path)
        inside = sorted(
            p for p in path.rglob("*.toml") if p.is_file() and b"machine/" in p.read_bytes()[:100_000]
        )
        if path.is_dir() and not inside:
            raise UsageError(f'{path} holds no machine: no .toml file there says vcmm = "machine/1"')
        out += inside if path.is_dir() else [path]
    return list(dict.fromkeys(out))


def _read(scenario: Path, machines: list[Path]) -> list[Path]:
    """Return all files of the job, each once."""
    return list(dict.fromkeys(f for p in (scenario, *machines) for f in sources(p)))


def _load_tasks(scenario: Path, machines: list[Path]) -> list[Scenario | str]:
    """Return the task on every machine, or what is wrong with a machine file as text. Raises what the last raises where none can be read."""
    out: list[Scenario | str] = []
    for number, machine in enumerate(machines, 1):
        try:
            out.append(load_scenario(scenario, machine))
        except VcmmError as error:
            out.append(first_of(error))
            if number == len(machines) and all(isinstance(task, str) for task in out):
                raise
    return out


def placed_on(options: Options, scenario: Scenario | str) -> Row:
    """Return the part at its best pose on one machine, by any worker; `refused`: why the machine cannot take it, or its file not be read."""
    from vcmm.show.pages.place import place_page

    if isinstance(scenario, str):
        return {"name": "", "refused": scenario}
    try:
        placed = place(scenario, **{k: v for k, v in options.items() if v is not None})
    except ModelLimit as error:
        return {"name": scenario.machine.name, "refused": str(error)}
    best, near = placed.best, placed.region.convenient
    return {
        "name": scenario.machine.name, "refused": "", "value": best.value, "pose": best.pose.tolist(),
        "convenient": None if near is None else near.tolist(), "words": [pose_text(best.pose), amount(best.value, placed)],
        "content": place_json(placed), "page": place_page(placed), "seed": placed.seed, "warnings": list(placed.warnings),
    }  # fmt: skip
