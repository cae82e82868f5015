"""vcmm diagnose FOLDER: every recording of a folder by itself, and what changed from one to the next."""

from __future__ import annotations

from pathlib import Path
from typing import Any


def folder_job(folder: Path, options: dict[str, Any], sharing: Any, json: bool, out: Path | None) -> int:
    """Tables, document, CSV, page. options: seed, machine. Exit code 0: a recording that cannot be read is told in its row; 70
    where one met a fault of ours.
    """
    from vcmm.show.console.documents import print_json
    from vcmm.show.console.files import output_folder

    target = output_folder(out) if out else None
    records, files = diagnose_folder(folder, options, sharing, json)
    from vcmm.files.learned.fleet import changes, in_time

    records = in_time(records)
    found = changes(records)
    content = _document(records, found, files, options["seed"])
    if target:
        _write(target, folder.name, records, found, content)
    if json:
        print_json(content)
    else:
        _show(folder.name, records, found)
    return 70 if any(r["ours"] for r in records) else 0


def diagnose_folder(
    folder: Path, options: dict[str, Any], sharing: Any, quiet: bool
) -> tuple[list[dict[str, Any]], list[Path]]:
    """A record of every recording, and all files that were read. Raises ShardDone where a share is wanted."""
    from vcmm.core.blocks import key_of
    from vcmm.files.learned.fleet import FolderJob, diagnosed_folder
    from vcmm.files.own.recording_files import recordings_in
    from vcmm.show.console.terminal import progress

    machine = Path(options["machine"]) if options["machine"] else None
    asked, found = FolderJob(folder, options["seed"], machine), recordings_in(folder)
    files = read_files(found, machine)
    with progress(not quiet) as bar:
        count = len(found)
        bar(f"0 of {count} recordings", 0.0)
        records = diagnosed_folder(
            asked, found, key_of("diagnose", options, files), sharing,
            lambda share: bar(f"{round(share * count)} of {count} recordings", share),
        )  # fmt: skip
    return records, files


def read_files(found: list[Path], machine: Path | None) -> list[Path]:
    """Every file once."""
    from vcmm.show.console.documents import sources

    return list(dict.fromkeys(f for p in [*found, *([machine] if machine else [])] for f in sources(p)))


def shard_of_folder(folder: Path, options: dict[str, Any], sharing: Any, json: bool, out: Path | None) -> int:
    """Every n-th recording, for `vcmm merge`."""
    from vcmm.face.job import put_shard, write_shard
    from vcmm.files.own.recording_files import recordings_in

    files = read_files(recordings_in(folder), Path(options["machine"]) if options["machine"] else None)
    shared = write_shard(
        "diagnose", {"scenario": str(folder), **options}, files, sharing.share,
        lambda: diagnose_folder(folder, options, sharing, json),
    )  # fmt: skip
    return put_shard(shared, folder.name or "diagnose", json, out)


def _document(
    records: list[dict[str, Any]], found: list[Any], files: list[Path], seed: int
) -> dict[str, Any]:
    from vcmm.show.console.documents import document
    from vcmm.show.tables import fleet as tables
    from vcmm.show.tables.table import records as as_records

    told = [{k: v for k, v in r.items() if k != "ours"} for r in records]
    body = {"recordings": told, "changes": as_records(tables.CHANGES, found)}
    return document("vcmm.learn.diagnosis-folder/1", body, seed=seed, files=files)


def _write(
    target: Path, name: str, records: list[dict[str, Any]], found: list[Any], content: dict[str, Any]
) -> None:
    from vcmm.show.console.documents import json_text
    from vcmm.show.console.files import write_files
    from vcmm.show.console.terminal import say
    from vcmm.show.pages.fleet import fleet_page
    from vcmm.show.tables import fleet as tables
    from vcmm.show.tables.table import csv_text

    texts = {
        "diagnosis.json": json_text(content),
        "recordings.csv": csv_text(tables.numbers(records)),
        "changes.csv": csv_text(tables.changes(found)),
        "report.html": fleet_page(name, records, found),
    }
    write_files(target, texts)
    say(f"wrote {target}/" + ", ".join(texts))


def _show(name: str, records: list[dict[str, Any]], found: list[Any]) -> None:
    from vcmm.show.console.terminal import say, show_answers, show_table
    from vcmm.show.tables import fleet as tables
    from vcmm.show.tables.answers_runs import folder_answers

    show_answers(folder_answers(records, found))
    show_table(tables.recordings(name, records))
    if found:
        show_table(tables.changes(found))
    bad = [r for r in records if r["problem"]]
    if bad:
        say(f"note: {len(bad)} of {len(records)} recordings were not diagnosed; the table says why")
