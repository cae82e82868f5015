"""vcmm uncertainty: value, U, decision and budget of every characteristic."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter

from vcmm.core.errors import UsageError
from vcmm.face.cli.options import Cluster, CountOption, Evidence, Require, Seed, Shard, Workers


def uncertainty_command(
    scenario: Path, *, trials: int | None = None, seed: Seed | None = None, engine: Literal["auto", "montecarlo", "exact"] = "auto", digits: CountOption = None,
    workers: Workers = None, cluster: Cluster = None, shard: Shard = None, json: Annotated[bool, Parameter(name="--json")] = False, out: Path | None = None,
    evidence: Evidence = None, require: Require = None,
) -> int:  # fmt: skip
    """Task-specific uncertainty: value, U, coverage interval, decision and budget of every characteristic.

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
    from vcmm.face.cli.options import put_shard, sharing_of, write_shard
    from vcmm.show.console.documents import sources

    sharing = sharing_of(workers, cluster, shard)
    options = {"trials": trials, "seed": seed, "engine": engine, "digits": digits}
    if sharing.share is None:
        return run_uncertainty(scenario, options, sharing, json, out, evidence=evidence, require=require)
    if require is not None:
        raise UsageError("--require is of the whole job, not of one shard; give it without --shard")
    if digits is not None:
        raise UsageError(
            "--digits decides on the way how many trials are run, so they cannot be split; use --trials"
        )
    shared = write_shard(
        "uncertainty", {"scenario": str(scenario), **options}, sources(scenario), sharing.share,
        lambda: _evaluate(scenario, options, sharing),
    )  # fmt: skip
    return put_shard(shared, scenario.stem, json, out)


def _evaluate(scenario: Path, options: dict[str, Any], sharing: Any) -> Any:
    """(scenario, result); complaints get file and line."""
    from vcmm.face.api import uncertainty
    from vcmm.files.own.scenario import load_scenario
    from vcmm.show.console.complaints import about
    from vcmm.show.console.terminal import progress

    loaded = load_scenario(scenario)
    with progress() as report, about(scenario):
        return loaded, uncertainty(loaded, **options, progress=report, sharing=sharing)


def run_uncertainty(
    scenario: Path,
    options: dict[str, Any],
    sharing: Any,
    json: bool,
    out: Path | None,
    evidence: Path | None = None,
    require: str | None = None,
) -> int:
    """The whole job: document, files, tables. options: trials, seed, engine, digits."""
    from vcmm.face.cli.options import exit_code
    from vcmm.show.console.documents import document, print_json, sources
    from vcmm.show.console.files import output_folder
    from vcmm.show.tables.uncertainty import uncertainty_json

    folder = output_folder(out) if out else None
    loaded, result = _evaluate(scenario, options, sharing)
    code = exit_code(result.characteristics, require)
    content = document(
        "vcmm.uncertainty/1",
        uncertainty_json(result),
        seed=result.seed,
        files=sources(scenario),
        warnings=result.warnings,
    )
    if evidence:
        from vcmm.face.cli.options import keep_evidence

        given = {k: v for k, v in options.items() if (k, v) != ("engine", "auto")}
        keep_evidence(evidence, ("uncertainty", scenario, given), loaded.task(), content)
    if folder:
        _write(folder, loaded, result, content, sources(scenario))
    if json:
        print_json(content)
    else:
        show(result)
    return code


def show(result: Any) -> None:
    """The result table, the largest budget lines, and how it was computed."""
    from vcmm.answer.evaluation.result import common_causes
    from vcmm.show.console.terminal import say, say_warnings, show_answers, show_table
    from vcmm.show.report.answers import answer_of
    from vcmm.show.tables.uncertainty import (
        computation_table,
        largest,
        not_added_up,
        results,
        stated_with,
        undecided_because,
    )

    show_answers(answer_of(c) for c in result.characteristics)
    show_table(results(result))
    for sentence in (*stated_with(result.characteristics), *undecided_because(result.characteristics)):
        say(sentence)
    for table in (largest(result.characteristics), computation_table(result)):
        show_table(table)
    for c in result.characteristics:
        for cause, (share, names) in common_causes(c.budget).items():
            say(f"{c.name}: {share:.1%} of u² come from {cause}, in {' and '.join(names)}")
    for sentence in not_added_up(result.characteristics):
        say(sentence)
    say_warnings(result.warnings)


def _write(folder: Path, scenario: Any, result: Any, content: dict[str, Any], files: list[Path]) -> None:
    from vcmm.show.console.documents import json_text
    from vcmm.show.console.files import write_files
    from vcmm.show.console.terminal import say
    from vcmm.show.pages.uncertainty import uncertainty_page
    from vcmm.show.tables.uncertainty import budget_csv

    texts = {
        "uncertainty.json": json_text(content),
        "budget.csv": budget_csv(result),
        "report.html": uncertainty_page(scenario, result, files),
    }
    write_files(folder, texts)
    say(f"wrote {folder}/report.html, uncertainty.json, budget.csv")
