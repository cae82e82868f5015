"""vcmm merge: merge the shards of a job."""

from __future__ import annotations

import json as json_module
from pathlib import Path
from typing import Any

from vcmm import __version__
from vcmm.core.blocks import Shards, Sharing
from vcmm.core.errors import DataError, UsageError
from vcmm.core.text import read_text
from vcmm.face.cli.options import InputFile, Json
from vcmm.face.job import Flags, run_job
from vcmm.show.console.documents import document, fingerprint

COMMON = ("verb", "options", "key", "inputs", "version")


def merge_command(*files: InputFile, json: Json = False, out: Path | None = None) -> int:
    """Put the shards of a job together: the document that one computer would have given, to the last bit.

    Exit code: that of the job.

    Parameters
    ----------
    files
        All files that a job with --shard has written, in any order.
    json
        Print one JSON document.
    out
        Folder for the files that the job itself would have written.
    """
    if not files:
        raise UsageError(
            "merge needs the files of all shards; write for example vcmm merge plate.shard-*.json"
        )
    shards = [(file, _read(file)) for file in files]
    first = _complete(shards)
    blocks = {(b["first"], b["trials"]): b["tallies"] for _, block in shards for b in block["blocks"]}
    sharing = Sharing(store=Shards(first["key"], blocks))
    return _job(first["verb"], first["options"], sharing, json, out)


def _job(verb: str, options: dict[str, Any], sharing: Sharing, json: bool, out: Path | None) -> int:
    """Run the rest of the verb. options: as its shards hold them."""
    flags = Flags(json, out)
    if verb == "audit":
        from vcmm.face.cli.audit import audit_job

        named = [Path(s) for s in options["scenarios"]]
        return run_job(audit_job(named, options["parts"], options["seed"], sharing), flags)
    if verb == "uncertainty":
        from vcmm.face.cli.uncertainty import UncertaintyJob

        return run_job(UncertaintyJob.of_shards(options, sharing), flags)
    if verb == "cut":
        from vcmm.face.cli.cut import CutJob

        return run_job(CutJob.of_shards(options, sharing), flags)
    if verb == "place":
        from vcmm.face.cli.place_machines import PlaceMachinesJob

        return run_job(PlaceMachinesJob.of_shards(options, sharing), flags)
    from vcmm.face.cli.diagnose_folder import DiagnoseFolderJob

    return run_job(DiagnoseFolderJob.of_shards(options, sharing), flags)


def _read(file: Path) -> dict[str, Any]:
    """Read the document of a shard. Raises DataError."""
    try:
        content = json_module.loads(read_text(file))
    except (json_module.JSONDecodeError, RecursionError) as error:
        raise DataError(
            f"{file}:{getattr(error, 'lineno', 1)}: no JSON document ({error}); name the file of a shard"
        ) from None
    due = {*COMMON, "shard", "blocks"}
    if not isinstance(content, dict) or content.get("schema") != "vcmm.shard/1" or not due <= set(content):
        raise DataError(f'{file}:1: no shard: "schema" must be "vcmm.shard/1", as --shard writes it')
    if content["version"] == __version__ and content.get("sha256") != fingerprint(content):
        raise DataError(f"{file}:1: this shard is not as it was written (SHA-256 differs); run it again")
    return content


def _complete(shards: list[tuple[Path, dict[str, Any]]]) -> dict[str, Any]:
    """Return the first shard, after checking that all are of one job, each once, on the present files."""
    file, first = shards[0]
    if first["version"] != __version__:
        raise DataError(f"{file}:1: made by vcmm {first['version']}, this is {__version__}; use one version")
    for other, shard in shards[1:]:
        different = [key for key in COMMON if shard[key] != first[key]]
        if different or shard["shard"][1] != first["shard"][1]:
            raise DataError(
                f"{other}:1: a shard of another job than {file} ({', '.join(different) or 'number of shards'} differ)"
            )
    numbers = [shard["shard"][0] for _, shard in shards]
    missing = sorted(set(range(1, first["shard"][1] + 1)) - set(numbers))
    twice = sorted({n for n in numbers if numbers.count(n) > 1})
    if missing or twice:
        what = (
            f"shard {missing[0]} of {first['shard'][1]} is missing; name the files of all shards"
            if missing
            else f"shard {twice[0]} is there twice; name each file once"
        )
        raise DataError(f"{file}:1: {what}")
    now = document("", {}, files=[Path(i["file"]) for i in first["inputs"]])["inputs"]
    if now != first["inputs"]:
        changed = next(a["file"] for a, b in zip(first["inputs"], now) if a != b)
        raise DataError(f"{changed}:1: the file has changed since the shards were made; run them again")
    return first
