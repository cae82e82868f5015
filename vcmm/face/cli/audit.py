"""vcmm audit: are the intervals right? Counted on drawn parts and machines."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated, Any

from cyclopts import Parameter

from vcmm.face.cli.options import Cluster, Shard, Workers

LEAST_PARTS = 100


def audit_command(
    scenarios: list[Path],
    *,
    parts: int = 2000,
    seed: int | None = None,
    workers: Workers = None,
    cluster: Cluster = None,
    shard: Shard = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
) -> int:
    """Count how often the intervals of this very task hold the true value, on parts and machines drawn from what is known.

    Exit code 1 when a claimed coverage lies outside its band.

    Parameters
    ----------
    scenarios
        Scenario file (scenario/1). Several, or folders of them: one table of all tasks; a file that cannot be counted is told in its row.
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
    from vcmm.core.errors import UsageError
    from vcmm.face.cli.options import put_shard, sharing_of, write_shard

    if parts < LEAST_PARTS:
        raise UsageError(f"--parts {parts} are too few to count a coverage; use 100 or more (2000 is usual)")
    options = {"parts": parts, "seed": seed}
    several = len(scenarios) > 1 or scenarios[0].is_dir()
    sharing = sharing_of(workers, cluster, shard, keep=several)
    if sharing.share is None:
        return run_audit(scenarios, options, sharing, json, out)
    from vcmm.face.cli.audit_several import files_of, scenarios_in

    files = files_of(scenarios_in(scenarios)) if several else files_of(scenarios)
    asked = {"scenarios": [str(s) for s in scenarios], **options}
    shared = write_shard(
        "audit", asked, files, sharing.share, lambda: count_scenarios(scenarios, options, sharing, not json)
    )
    return put_shard(shared, scenarios[0].stem or "audit", json, out)


def count_scenarios(scenarios: list[Path], options: dict[str, Any], sharing: Any, shown: bool) -> Any:
    """Rows of one task, or the records of several. Raises ShardDone where a share is wanted."""
    if len(scenarios) > 1 or scenarios[0].is_dir():
        from vcmm.face.cli.audit_several import audited_tasks

        return audited_tasks(scenarios, options, sharing, shown)
    return _count_scenario(scenarios[0], options, sharing, shown)


def _count_scenario(scenario: Path, options: dict[str, Any], sharing: Any, shown: bool) -> Any:
    """(rows, seed) of one task; complaints get file and line."""
    from vcmm.answer.inference.audit import audit
    from vcmm.core.blocks import key_of
    from vcmm.face.cli.audit_several import with_seed
    from vcmm.files.own.scenario import load_scenario
    from vcmm.show.console.complaints import about
    from vcmm.show.console.documents import sources
    from vcmm.show.console.terminal import progress

    loaded = load_scenario(scenario)
    settings = with_seed(loaded.settings, options["seed"])
    key = key_of("audit", options, sources(scenario))
    with progress(shown) as report, about(scenario):
        rows = audit(
            loaded, parts=options["parts"], settings=settings, progress=report, sharing=sharing, key=key
        )
    return rows, settings.seed


def run_audit(
    scenarios: list[Path], options: dict[str, Any], sharing: Any, json: bool, out: Path | None
) -> int:
    """The whole job: document, files, table. options: parts, seed."""
    if len(scenarios) > 1 or scenarios[0].is_dir():
        from vcmm.face.cli.audit_several import run_several

        return run_several(scenarios, options, sharing, json, out)
    from vcmm.show.console.documents import document, json_text, print_json, sources
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import say, show_answers, show_table
    from vcmm.show.tables.answers_runs import audit_answers
    from vcmm.show.tables.audit import audit_json, audit_table, missing_claims
    from vcmm.show.tables.table import csv_text

    folder = output_folder(out) if out else None
    rows, seed = _count_scenario(scenarios[0], options, sharing, not json)
    content = document("vcmm.audit/1", audit_json(rows), seed=seed, files=sources(scenarios[0]))
    table = audit_table(rows)
    if folder:
        write_files(folder, {"audit.json": json_text(content), "audit.csv": csv_text(table)})
    if json:
        print_json(content)
    else:
        show_answers(audit_answers(rows))
        show_table(table)
        for sentence in missing_claims(rows):
            say(sentence)
    return int(any(row.outside for row in rows))
