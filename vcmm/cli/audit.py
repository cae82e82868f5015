"""vcmm audit: are the intervals right? Counted on drawn parts and machines."""

from __future__ import annotations

from pathlib import Path
from typing import Annotated

from cyclopts import Parameter


def audit_command(
    scenario: Path,
    *,
    parts: int = 2000,
    seed: int | None = None,
    json: Annotated[bool, Parameter(name="--json")] = False,
    out: Path | None = None,
) -> int:
    """Count how often the intervals of this very task hold the true value, on parts and machines drawn from what is known.

    Exit code 1 when a claimed coverage lies outside its band.

    Parameters
    ----------
    scenario
        Scenario file (scenario/1).
    parts
        Parts to draw and measure for every kind of part.
    seed
        Seed of the random streams (default: the scenario's).
    json
        Print one JSON document.
    out
        Folder for audit.json and audit.csv.
    """
    from dataclasses import replace

    from vcmm.console.complaints import about
    from vcmm.console.documents import document, json_text, print_json, sources
    from vcmm.console.files import output_folder, write_files
    from vcmm.console.terminal import progress, say, show_table
    from vcmm.core.errors import UsageError
    from vcmm.files.scenario import load_scenario
    from vcmm.inference.audit import audit
    from vcmm.tables.audited import audit_json, audit_table, not_claimed
    from vcmm.tables.table import csv_text

    if parts < 100:
        raise UsageError(f"--parts {parts} are too few to count a coverage; use 100 or more (2000 is usual)")
    folder = output_folder(out) if out else None
    loaded = load_scenario(scenario)
    settings = loaded.settings if seed is None else replace(loaded.settings, seed=seed)
    with progress() as report, about(scenario):
        rows = audit(loaded, parts=parts, settings=settings, progress=report)
    content = document("vcmm.audit/1", audit_json(rows), seed=settings.seed, files=sources(scenario))
    table = audit_table(rows)
    if folder:
        write_files(folder, {"audit.json": json_text(content), "audit.csv": csv_text(table)})
    if json:
        print_json(content)
    else:
        show_table(table)
        for sentence in not_claimed(rows):
            say(sentence)
    return int(any(row.outside for row in rows))
