"""vcmm audit: count whether the intervals hold the true values, on sampled parts and machines; of one task, or of several."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict, dataclass, replace
from pathlib import Path
from typing import Any

from vcmm.answer.inference.audit import AuditResult, audit
from vcmm.core.blocks import Sharing, key_of
from vcmm.core.errors import UsageError, VcmmError, first_of
from vcmm.face.cli.options import Cluster, InputPath, Json, Shard, Workers
from vcmm.face.job import Flags, Progress, Record, SharedJob, run_shared, sharing_of
from vcmm.files.own.scenario import load_scenario
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import say, show_answers, show_table
from vcmm.show.tables.answers_runs import audit_answers
from vcmm.show.tables.audit import OfTask, audit_json, audit_table, missing_claims, tasks_json, tasks_table
from vcmm.show.tables.table import csv_text
from vcmm.task.measuring.scenario import Scenario
from vcmm.task.measuring.settings import Settings

LEAST_PARTS = 100


def audit_command(
    scenarios: list[InputPath],
    *,
    parts: int = 2000,
    seed: int | None = None,
    workers: Workers = None,
    cluster: Cluster = None,
    shard: Shard = None,
    json: Json = False,
    out: Path | None = None,
) -> int:
    """Count how often the intervals of this very task hold the true value, on parts and machines drawn from what is known.

    Exit code 1 when a claimed coverage lies outside its band.

    Parameters
    ----------
    scenarios
        Scenario file (scenario/1). Several, or folders of them: one table of all tasks; a file that cannot be counted gives its reason in its row.
    parts
        Parts to draw and measure for every kind of part.
    seed
        Seed of the random streams (default: the scenario's).
    workers
        Processes that count; the document does not depend on it.
    cluster
        Address of a Dask scheduler whose workers count, such as tcp://scheduler:8786.
    shard
        Count one part only, such as 2/8, for a batch queue; `vcmm merge` puts all parts together.
    json
        Print one JSON document.
    out
        Folder for audit.json and audit.csv.
    """
    if parts < LEAST_PARTS:
        raise UsageError(f"--parts {parts} are too few to count a coverage; use 100 or more (2000 is usual)")
    several = len(scenarios) > 1 or scenarios[0].is_dir()
    sharing = sharing_of(workers, cluster, shard, keep=several)
    job = audit_job(scenarios, parts, seed, sharing)
    return run_shared(job, Flags(json, out))


def audit_job(scenarios: list[Path], parts: int, seed: int | None, sharing: Sharing) -> SharedJob[Any, Any]:
    """Return the audit of one task, or of several."""
    if len(scenarios) > 1 or scenarios[0].is_dir():
        return AuditSeveralJob(tuple(scenarios), parts, seed, sharing=sharing)
    return AuditJob(scenarios[0], parts, seed, sharing=sharing)


@dataclass(frozen=True)
class AuditJob(SharedJob[Scenario, tuple[AuditResult, ...]]):
    """The intervals of one task, counted."""

    scenario: Path
    parts: int
    seed: int | None = None
    verb, schema = "audit", "vcmm.audit/1"

    @property
    def place(self) -> tuple[Path, str]:
        return self.scenario, ""

    @property
    def stem(self) -> str:
        return self.scenario.stem

    def options(self) -> dict[str, object]:
        return {"scenarios": [str(self.scenario)], "parts": self.parts, "seed": self.seed}

    def inputs(self) -> list[Path]:
        return sources(self.scenario)

    @classmethod
    def of_shards(cls, options: dict[str, Any], sharing: Sharing) -> AuditJob:
        (scenario,) = options["scenarios"]
        return cls(Path(scenario), options["parts"], options["seed"], sharing=sharing)

    def load(self) -> Scenario:
        return load_scenario(self.scenario)

    def run(self, loaded: Scenario, report: Progress) -> tuple[AuditResult, ...]:
        key = key_of("audit", {"parts": self.parts, "seed": self.seed}, self.inputs())
        settings = with_seed(loaded.settings, self.seed)
        return audit(
            loaded, parts=self.parts, settings=settings, progress=report, sharing=self.sharing, key=key
        )

    def record(self, loaded: Scenario, result: tuple[AuditResult, ...]) -> Record:
        return Record(audit_json(result), self.inputs(), with_seed(loaded.settings, self.seed).seed)

    def texts(
        self, loaded: Scenario, result: tuple[AuditResult, ...], content: str, folder: Path
    ) -> dict[str, str]:
        return {"audit.json": content, "audit.csv": csv_text(audit_table(result))}

    def exit_code(self, loaded: Scenario, result: tuple[AuditResult, ...]) -> int:
        return int(any(row.outside for row in result))

    def show(self, loaded: Scenario, result: tuple[AuditResult, ...]) -> None:
        show_answers(audit_answers(result))
        show_table(audit_table(result))
        for sentence in missing_claims(result):
            say(sentence)


Task = tuple[str, Scenario | str]  # file, and its scenario or what is wrong with it


@dataclass(frozen=True)
class AuditSeveralJob(SharedJob[list[Task], list[dict[str, Any]]]):
    """The intervals of several tasks, each by itself. The result is a record for each: `file`, `rows`, `problem`, `ours`."""

    places: tuple[Path, ...]
    parts: int
    seed: int | None = None
    verb, schema = "audit", "vcmm.audit/1"

    @property
    def stem(self) -> str:
        return self.places[0].stem

    def options(self) -> dict[str, object]:
        return {"scenarios": [str(s) for s in self.places], "parts": self.parts, "seed": self.seed}

    def inputs(self) -> list[Path]:
        return files_of(scenarios_in(self.places))

    @classmethod
    def of_shards(cls, options: dict[str, Any], sharing: Sharing) -> AuditSeveralJob:
        places = tuple(Path(s) for s in options["scenarios"])
        return cls(places, options["parts"], options["seed"], sharing=sharing)

    def load(self) -> list[Task]:
        """Read all files here, so that workers on other computers need none of them."""
        return [_load(file) for file in scenarios_in(self.places)]

    def run(self, loaded: list[Task], report: Progress) -> list[dict[str, Any]]:
        options = {"parts": self.parts, "seed": self.seed}
        key = key_of("audit", {**options, "files": [file for file, _ in loaded]}, self.inputs())
        count = len(loaded)
        report(f"0 of {count} tasks", 0.0)
        return list(
            self.sharing.map_items(
                key, record_of, options, loaded, lambda s: report(f"{round(s * count)} of {count} tasks", s)
            )
        )

    def record(self, loaded: list[Task], result: list[dict[str, Any]]) -> Record:
        names = [r["file"] for r in result]
        body = {"tasks": tasks_json(_rows(result), names, _refusals(result))}
        return Record(body, files_of([Path(name) for name in names]), self.seed)

    def texts(
        self, loaded: list[Task], result: list[dict[str, Any]], content: str, folder: Path
    ) -> dict[str, str]:
        return {"audit.json": content, "audit.csv": csv_text(tasks_table(_rows(result)))}

    def exit_code(self, loaded: list[Task], result: list[dict[str, Any]]) -> int:
        """Return 1: a claimed coverage lies outside; 70: a task met an internal error."""
        if any(r["ours"] for r in result):
            return 70
        return int(any(row.audit.outside for row in _rows(result)))

    def show(self, loaded: list[Task], result: list[dict[str, Any]]) -> None:
        show_table(tasks_table(_rows(result)))
        for file, why in _refusals(result).items():
            say(f"note: {file}: {why}")


def _rows(result: list[dict[str, Any]]) -> list[OfTask]:
    return [OfTask(r["file"], AuditResult(**row)) for r in result for row in r["rows"]]


def _refusals(result: list[dict[str, Any]]) -> dict[str, str]:
    return {r["file"]: r["problem"] for r in result if r["problem"]}


def scenarios_in(named: Sequence[Path]) -> list[Path]:
    """Return the files themselves, and of folders all scenarios in them and below. Raises UsageError where a folder holds none."""
    out: list[Path] = []
    for path in named:
        out += _below(path) if path.is_dir() else [path]
    return list(dict.fromkeys(out))


def _below(folder: Path) -> list[Path]:
    files = [p for p in sorted(folder.rglob("*.toml")) if p.is_file() and b"scenario/" in _head(p)]
    if not files:
        raise UsageError(
            f'{folder} holds no scenario: no .toml file there says vcmm = "scenario/1"; name another folder, or the file itself'
        )
    return files


def _head(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(100_000)


def files_of(scenarios: Sequence[Path]) -> list[Path]:
    """Return every file once, with those that it names."""
    return list(dict.fromkeys(f for p in scenarios for f in sources(p)))


def _load(file: Path) -> Task:
    """Return (file, scenario), or what is wrong with it as text."""
    try:
        return str(file), load_scenario(file)
    except VcmmError as error:
        return str(file), first_of(error)


def record_of(options: Mapping[str, Any], item: Task) -> dict[str, Any]:
    """Return one task as plain values: the rows of its audit, or `problem`, why there are none."""
    file, scenario = item
    body = {"file": file, "rows": [], "ours": False}
    if isinstance(scenario, str):
        return {**body, "problem": scenario}
    try:
        rows = audit(scenario, parts=options["parts"], settings=with_seed(scenario.settings, options["seed"]))
    except VcmmError as error:
        return {**body, "problem": first_of(error)}
    except Exception as error:  # an internal error in one of hundreds is reported and does not end the others
        return {
            **body,
            "problem": f"internal error ({type(error).__name__}: {error}); please report it",
            "ours": True,
        }
    return {**body, "problem": None, "rows": [asdict(r) for r in rows]}


def with_seed(settings: Settings, seed: int | None) -> Settings:
    """Return the settings with another seed, where one is given."""
    return settings if seed is None else replace(settings, seed=seed)
