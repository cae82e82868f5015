"""Options that several verbs have: seeds, and who does the work of a long job."""

from __future__ import annotations

import os
import re
from collections.abc import Callable, Iterable
from pathlib import Path
from typing import Annotated, Any, Literal

from cyclopts import Parameter
from cyclopts.validators import Number

Seed = Annotated[int, Parameter(validator=Number(gte=0, lt=2**63))]  # the streams take 64 bits
CountOption = Annotated[int | None, Parameter(validator=Number(gte=1))]  # 0 would be taken for "not given"
Decimals = Annotated[int | None, Parameter(validator=Number(gte=0, lte=9))]  # a control reads no more
Workers = Annotated[int | None, Parameter(name="--workers")]
Cluster = Annotated[str | None, Parameter(name="--cluster")]
Shard = Annotated[str | None, Parameter(name="--shard")]


Require = Annotated[Literal["conforms"] | None, Parameter(name="--require")]
REQUIRED, FAILED = "conforms", "does not conform"


def exit_code(characteristics: Iterable[Any], require: str | None) -> int:
    """1 where a characteristic does not conform; with --require conforms also where one is undecided.

    UsageError: something is required and nothing is decided, as no characteristic has limits.
    """
    from vcmm.core.errors import UsageError

    decided = [c.decision.text for c in characteristics if c.decision is not None]
    if require is None:
        return int(FAILED in decided)
    if not decided:
        raise UsageError(
            "--require conforms, but no characteristic has limits: state limits or zone in [[part.characteristics]]"
        )
    return int(any(text != REQUIRED for text in decided))


def _pack_place(kind: Any, path: Path | None) -> None:
    if path is not None:
        from vcmm.show.console.evidence import check_pack_place

        check_pack_place(path)


Evidence = Annotated[Path | None, Parameter(name="--evidence", validator=_pack_place)]


def sharing_of(workers: int | None, cluster: str | None, shard: str | None, keep: bool = False) -> Any:
    """The Sharing that is asked for: who counts, and where finished blocks are kept until the job is done. Raises UsageError.

    keep: even where this process does it all.
    """
    from vcmm.core.blocks import Folder, Nowhere, Sharing
    from vcmm.core.crew import crew_of

    long = keep or workers is not None or cluster is not None or shard is not None
    folder = _block_folder() if long else None
    return Sharing(crew_of(workers, cluster), Folder(folder) if folder else Nowhere(), share_of(shard))


def share_of(text: str | None) -> Any:
    """'2/8' -> the second of eight shards. Raises UsageError."""
    from vcmm.core.blocks import Share
    from vcmm.core.errors import UsageError

    if text is None:
        return None
    match = re.fullmatch(r"([0-9]{1,6})/([0-9]{1,6})", text)
    if not match:
        raise UsageError(f'--shard "{text}"; write for example --shard 2/8, the second of eight')
    return Share(int(match[1]), int(match[2]))


def _block_folder() -> Path | None:
    """Where finished blocks wait, in the user's cache; None where nothing can be kept."""
    home = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    try:
        folder = (Path(home) if home else Path.home() / ".cache") / "vcmm" / "blocks"
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return None
    return folder if os.access(folder, os.W_OK) else None


def write_shard(
    verb: str, options: dict[str, Any], files: list[Path], share: Any, job: Callable[[], object]
) -> dict[str, Any]:
    """Do a job's share and return the document that `vcmm merge` reads.

    A job in which nothing is sampled has no blocks: its shards are empty, and merging them does the job.
    """
    from vcmm.core.blocks import ShardDone
    from vcmm.show.console.documents import document, fingerprint

    key, blocks = "", []
    try:
        job()
    except ShardDone as done:
        key = done.key
        blocks = [{"first": b[0], "trials": b[1], "tallies": t} for b, t in sorted(done.blocks.items())]
    body = {"verb": verb, "options": options, "shard": [share.number, share.of], "key": key, "blocks": blocks}
    content = document("vcmm.shard/1", body, files=files)
    return content | {"sha256": fingerprint(content)}


def put_shard(content: dict[str, Any], stem: str, json: bool, out: Path | None) -> int:
    """The shard as a document on stdout, or as a file in `out` or here."""
    from vcmm.show.console.documents import json_text, print_json
    from vcmm.show.console.files import write_text
    from vcmm.show.console.terminal import say

    if json:
        print_json(content)
        return 0
    number, of = content["shard"]
    say(f"wrote {write_text((out or Path()) / f'{stem}.shard-{number}-of-{of}.json', json_text(content))}")
    return 0


def keep_evidence(
    path: Path, command: tuple[str, Path, dict[str, Any]], task: Any, content: dict[str, Any]
) -> None:
    """Write the evidence pack of a job. command: verb, scenario and options; content: its document, which names all files read."""
    from vcmm.answer.evaluation.declaration import declared_influences
    from vcmm.show.console.evidence import command_words, write_pack
    from vcmm.show.console.terminal import say

    files = [Path(one["file"]) for one in content["inputs"]]
    write_pack(path, command_words(*command), content, files, declared_influences(task))
    say(f"wrote {path}; vcmm rerun {path} runs it again")
