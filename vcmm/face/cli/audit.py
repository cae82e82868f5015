"""vcmm audit: count whether the intervals hold the true values, on sampled parts and machines."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any

from vcmm.answer.inference.audit import AuditResult, audit
from vcmm.core.blocks import Sharing, key_of
from vcmm.core.errors import UsageError
from vcmm.face.cli.audit_several import AuditSeveralJob, with_seed
from vcmm.face.cli.options import Cluster, InputPath, Json, Shard, Workers
from vcmm.face.job import Flags, Progress, Record, SharedJob, run_shared, sharing_of
from vcmm.files.own.scenario import load_scenario
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import say, show_answers, show_table
from vcmm.show.tables.answers_runs import audit_answers
from vcmm.show.tables.audit import audit_json, audit_table, missing_claims
from vcmm.show.tables.table import csv_text
from vcmm.task.measuring.scenario import Scenario

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
