"""vcmm audit of several tasks, or of a folder: every task by itself, one table of all."""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from dataclasses import asdict
from pathlib import Path
from typing import Any


def run_several(
    scenarios: Sequence[Path], options: dict[str, Any], sharing: Any, json: bool, out: Path | None
) -> int:
    """Document, files, table. Exit code 1: a claimed coverage lies outside; 70: a task met a fault of ours."""
    from vcmm.answer.inference.audit import AuditResult
    from vcmm.show.console.documents import document, json_text, print_json
    from vcmm.show.console.files import output_folder, write_files
    from vcmm.show.console.terminal import say, show_table
    from vcmm.show.tables.audit import OfTask, tasks_json, tasks_table
    from vcmm.show.tables.table import csv_text

    folder = output_folder(out) if out else None
    found = audited_tasks(scenarios, options, sharing, not json)
    files = files_of([Path(r["file"]) for r in found])
    rows = [OfTask(r["file"], AuditResult(**one)) for r in found for one in r["rows"]]
    refused = {r["file"]: r["problem"] for r in found if r["problem"]}
    body = {"tasks": tasks_json(rows, [r["file"] for r in found], refused)}
    content, table = document("vcmm.audit/1", body, seed=options["seed"], files=files), tasks_table(rows)
    if folder:
        write_files(folder, {"audit.json": json_text(content), "audit.csv": csv_text(table)})
    if json:
        print_json(content)
    else:
        show_table(table)
        for file, why in refused.items():
            say(f"note: {file}: {why}")
    ours = any(r["ours"] for r in found)
    return 70 if ours else int(any(row.audited.outside for row in rows))


def scenarios_in(named: Sequence[Path]) -> list[Path]:
    """The files themselves, and of folders all scenarios in them and below. Raises UsageError where a folder holds none."""
    out: list[Path] = []
    for path in named:
        out += _below(path) if path.is_dir() else [path]
    return list(dict.fromkeys(out))


def _below(folder: Path) -> list[Path]:
    from vcmm.core.errors import UsageError

    found = [p for p in sorted(folder.rglob("*.toml")) if p.is_file() and b"scenario/" in _head(p)]
    if not found:
        raise UsageError(
            f'{folder} holds no scenario: no .toml file there says vcmm = "scenario/1"; name another folder, or the file itself'
        )
    return found


def _head(path: Path) -> bytes:
    with path.open("rb") as file:
        return file.read(100_000)


def files_of(scenarios: Sequence[Path]) -> list[Path]:
    """Every file once, with those that it names."""
    from vcmm.show.console.documents import sources

    return list(dict.fromkeys(f for p in scenarios for f in sources(p)))


def audited_tasks(
    named: Sequence[Path], options: dict[str, Any], sharing: Any, shown: bool
) -> list[dict[str, Any]]:
    """A record of every task. Files are read here, so that workers on other computers need none of them."""
    from vcmm.core.blocks import key_of
    from vcmm.show.console.terminal import progress

    files = scenarios_in(named)
    items = [_load(file) for file in files]
    key = key_of("audit", {**options, "files": [str(f) for f in files]}, files_of(files))
    with progress(shown) as bar:
        count = len(files)
        bar(f"0 of {count} tasks", 0.0)
        return list(
            sharing.all_of(
                key, record_of, options, items, lambda s: bar(f"{round(s * count)} of {count} tasks", s)
            )
        )


def _load(file: Path) -> tuple[str, Any]:
    """(file, scenario), or what is wrong with it as text."""
    from vcmm.core.errors import VcmmError, first_of
    from vcmm.files.own.scenario import load_scenario

    try:
        return str(file), load_scenario(file)
    except VcmmError as error:
        return str(file), first_of(error)


def record_of(options: Mapping[str, Any], item: tuple[str, Any]) -> dict[str, Any]:
    """One task as plain values: the rows of its audit, or `problem`, why there are none."""
    from vcmm.answer.inference.audit import audit
    from vcmm.core.errors import VcmmError, first_of

    file, scenario = item
    known = {"file": file, "rows": [], "ours": False}
    if isinstance(scenario, str):
        return {**known, "problem": scenario}
    try:
        rows = audit(scenario, parts=options["parts"], settings=with_seed(scenario.settings, options["seed"]))
    except VcmmError as error:
        return {**known, "problem": first_of(error)}
    except Exception as error:  # a fault of ours in one of hundreds is told and does not end the others
        return {
            **known,
            "problem": f"internal error ({type(error).__name__}: {error}); please report it",
            "ours": True,
        }
    return {**known, "problem": None, "rows": [asdict(r) for r in rows]}


def with_seed(settings: Any, seed: int | None) -> Any:
    """The settings with another seed, where one is given."""
    from dataclasses import replace

    return settings if seed is None else replace(settings, seed=seed)
