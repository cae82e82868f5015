"""vcmm uncertainty: value, U, decision and budget of every characteristic."""

from __future__ import annotations

from dataclasses import dataclass
from pathlib import Path
from typing import Any, Literal

from vcmm.answer.evaluation.result import UncertaintyResult, common_causes
from vcmm.core.blocks import Sharing
from vcmm.core.errors import UsageError
from vcmm.face.api import uncertainty
from vcmm.face.cli.options import (
    Cluster,
    CountOption,
    Evidence,
    InputFile,
    Json,
    Require,
    Seed,
    Shard,
    Workers,
)
from vcmm.face.job import (
    Flags,
    Pack,
    Progress,
    Record,
    SharedJob,
    decision_code,
    run_shared,
    sharing_of,
)
from vcmm.files.own.scenario import load_scenario
from vcmm.show.console.documents import sources
from vcmm.show.console.terminal import say, say_warnings, show_answers, show_table
from vcmm.show.report.answers import answer_of
from vcmm.show.tables.uncertainty import (
    budget_csv,
    budget_table,
    computation_table,
    not_added_up,
    results,
    stated_with,
    uncertainty_json,
    undecided_because,
)
from vcmm.task.measuring.scenario import Scenario


def uncertainty_command(
    scenario: InputFile, *, trials: int | None = None, seed: Seed | None = None, engine: Literal["auto", "montecarlo", "exact"] = "auto", digits: CountOption = None,
    workers: Workers = None, cluster: Cluster = None, shard: Shard = None, json: Json = False, out: Path | None = None,
    evidence: Evidence = None, require: Require = None,
) -> int:  # fmt: skip
    """Evaluate the task-specific uncertainty: value, U, coverage interval, decision and budget of every characteristic.

    Exit code 1 when a characteristic does not conform.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1).
    trials
        Monte Carlo trials (default: the scenario's, else 10^6).
    seed
        Seed of the random streams (default: the scenario's, else 0).
    engine
        auto: closed form where the output is smooth, else Monte Carlo; montecarlo: sample all; exact: every trial
        with multiplied transforms, contact and iterated fits.
    digits
        Adaptive Monte Carlo to this many significant digits of u (JCGM 101, 7.9) instead of fixed trials.
    workers
        Processes that count the trials; the numbers do not depend on it.
    cluster
        Address of a Dask scheduler whose workers count them, such as tcp://scheduler:8786.
    shard
        Count one part only, such as 2/8, for a batch queue; `vcmm merge` puts all parts together.
    json
        Print one JSON document.
    out
        Folder for report.html, uncertainty.json, budget.csv.
    evidence
        Zip with all files, versions, seed, influences covered and the document; `vcmm rerun` runs it again and compares.
    require
        conforms: exit code 1 also where a characteristic is undecided, not only where one does not conform.
    """
    sharing = sharing_of(workers, cluster, shard)
    job = UncertaintyJob(scenario, trials, seed, engine, digits, require, sharing=sharing)
    return run_shared(job, Flags(json, out, evidence))


@dataclass(frozen=True)
class UncertaintyJob(SharedJob[Scenario, UncertaintyResult]):
    """The uncertainty of every characteristic of a measuring scenario."""

    scenario: Path
    trials: int | None = None
    seed: int | None = None
    engine: str = "auto"
    digits: int | None = None
    require: str | None = None
    verb, schema = "uncertainty", "vcmm.uncertainty/1"

    @property
    def place(self) -> tuple[Path, str]:
        return self.scenario, ""

    @property
    def stem(self) -> str:
        return self.scenario.stem

    def count_options(self) -> dict[str, Any]:
        return {"trials": self.trials, "seed": self.seed, "engine": self.engine, "digits": self.digits}

    def options(self) -> dict[str, object]:
        return {"scenario": str(self.scenario), **self.count_options()}

    def inputs(self) -> list[Path]:
        return sources(self.scenario)

    @classmethod
    def of_shards(cls, options: dict[str, Any], sharing: Sharing) -> UncertaintyJob:
        return cls(**options | {"scenario": Path(options["scenario"])}, sharing=sharing)

    def check_shard(self) -> None:
        if self.require is not None:
            raise UsageError("--require is of the whole job, not of one shard; give it without --shard")
        if self.digits is not None:
            raise UsageError(
                "--digits decides on the way how many trials are run, so they cannot be split; use --trials"
            )

    def load(self) -> Scenario:
        return load_scenario(self.scenario)

    def run(self, loaded: Scenario, report: Progress) -> UncertaintyResult:
        return uncertainty(loaded, **self.count_options(), progress=report, sharing=self.sharing)

    def record(self, loaded: Scenario, result: UncertaintyResult) -> Record:
        return Record(uncertainty_json(result), sources(self.scenario), result.seed, result.warnings)

    def pack(self, loaded: Scenario) -> Pack:
        given = {k: v for k, v in self.count_options().items() if (k, v) != ("engine", "auto")}
        return Pack("uncertainty", self.scenario, given, loaded.task())

    def texts(
        self, loaded: Scenario, result: UncertaintyResult, content: str, folder: Path
    ) -> dict[str, str]:
        from vcmm.show.pages.uncertainty import uncertainty_page

        return {
            "report.html": uncertainty_page(loaded, result, sources(self.scenario)),
            "uncertainty.json": content,
            "budget.csv": budget_csv(result),
        }

    def exit_code(self, loaded: Scenario, result: UncertaintyResult) -> int:
        return decision_code(result.characteristics, self.require)

    def show(self, loaded: Scenario, result: UncertaintyResult) -> None:
        """Show the result table, the largest budget lines, and the method."""
        show_answers(answer_of(c) for c in result.characteristics)
        show_table(results(result))
        for sentence in (*stated_with(result.characteristics), *undecided_because(result.characteristics)):
            say(sentence)
        for table in (budget_table(result.characteristics), computation_table(result)):
            show_table(table)
        for c in result.characteristics:
            for cause, (share, names) in common_causes(c.budget).items():
                say(f"{c.name}: {share:.1%} of u² come from {cause}, in {' and '.join(names)}")
        for sentence in not_added_up(result.characteristics):
            say(sentence)
        say_warnings(result.warnings)
