"""A job of the command line as one value, and the one runner of all jobs.

A verb declares a `Job`: how its files are loaded, the computation, the document, the files beside it, the text for
the user, and the exit code. `run_job` does the rest, in the same order for every verb: places are checked before any work,
then load, run, document, evidence, files, answer. `run_shared` does one shard of a job, or all of it.
"""

from __future__ import annotations

import os
import re
from abc import ABC, abstractmethod
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import nullcontext
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any, ClassVar, Generic, TypeVar

from vcmm.core.blocks import Folder, NoStore, ShardDone, Share, Sharing
from vcmm.core.blocks import Progress as Progress
from vcmm.core.crew import crew_of
from vcmm.core.errors import UsageError
from vcmm.show.console.complaints import about
from vcmm.show.console.documents import document, fingerprint, json_text, print_json
from vcmm.show.console.files import output_folder, write_files, write_text
from vcmm.show.console.terminal import progress, say

if TYPE_CHECKING:
    from vcmm.answer.evaluation.result import CharacteristicResult
    from vcmm.task.measuring.task import Task

Loaded = TypeVar("Loaded")
Result = TypeVar("Result")
REQUIRED, FAILED = "conforms", "does not conform"


@dataclass(frozen=True)
class Flags:
    """Options for the result, the same for every verb that has the flag: --json, --out, --evidence."""

    json: bool = False
    out: Path | None = None
    evidence: Path | None = None


@dataclass(frozen=True)
class Record:
    """Content of the document of a job inside its frame. files: all that were read."""

    body: dict[str, Any]
    files: Sequence[Path]
    seed: int | None = None
    warnings: Sequence[str] = ()


@dataclass(frozen=True)
class Pack:
    """Content of an evidence pack beside the document: the command that makes it again, and the task whose influences are listed."""

    verb: str
    scenario: Path
    options: Mapping[str, Any]
    task: Task


class Job(ABC, Generic[Loaded, Result]):
    """A verb as a value: a frozen dataclass whose fields are the options of the verb.

    Loaded: what its files hold. Result: what is computed. Methods have no effects of their own but `write_binaries` and `export`.
    """

    schema: ClassVar[str]  # of the document, such as "vcmm.field/1"
    names_files_last: ClassVar[bool] = False  # behind the answer and the notes, not before them

    @property
    def place(self) -> tuple[Path, str] | None:
        """File and table for complaints about numbers (the table may be empty); None: the complaint names its own."""
        return None

    def check(self) -> None:
        """Raises UsageError for what is refused before any file is read."""

    @abstractmethod
    def load(self) -> Loaded:
        """Read all files."""

    @abstractmethod
    def run(self, loaded: Loaded, report: Progress) -> Result:
        """Compute the result."""

    @abstractmethod
    def record(self, loaded: Loaded, result: Result) -> Record:
        """Return the content of the document."""

    @abstractmethod
    def show(self, loaded: Loaded, result: Result) -> None:
        """Show the result on stdout and stderr."""

    def texts(self, loaded: Loaded, result: Result, content: str, folder: Path) -> dict[str, str]:
        """Return the file name -> text, of --out. content: the document as text."""
        raise NotImplementedError(f"{type(self).__name__} has no --out")

    def write_binaries(self, loaded: Loaded, result: Result, folder: Path) -> list[str]:
        """Write what is no text, after the texts; returns the names."""
        return []

    def files_sentence(self, loaded: Loaded, result: Result, folder: Path, names: Sequence[str]) -> str:
        """Return the sentence about the files; an empty one is not printed."""
        return f"wrote {folder}/{', '.join(names)}"

    def export(self, loaded: Loaded, result: Result, content: dict[str, Any]) -> None:
        """Write what other options than --out ask for, such as --export and --report. content: the document."""

    def pack(self, loaded: Loaded) -> Pack:
        """Return the content of --evidence."""
        raise NotImplementedError(f"{type(self).__name__} has no --evidence")

    def notes(self, loaded: Loaded, result: Result) -> Iterable[str]:
        """Return remarks for stderr, with --json too."""
        return ()

    def finish(self, loaded: Loaded, result: Result) -> None:
        """Finish after everything is written and shown: raise a postponed internal error."""

    def exit_code(self, loaded: Loaded, result: Result) -> int:
        """Return 0, or 1 where the condition of the verb is not met. Raises UsageError before anything is written."""
        return 0


def run_job(job: Job[Loaded, Result], flags: Flags) -> int:
    """Run the whole job; return its exit code. Nothing is written before everything is computed."""
    job.check()
    folder = output_folder(flags.out) if flags.out else None
    loaded, result = compute(job)
    code = job.exit_code(loaded, result)
    record = job.record(loaded, result)
    content = document(
        job.schema, record.body, seed=record.seed, files=record.files, warnings=record.warnings
    )
    if flags.evidence:
        keep_evidence(flags.evidence, job.pack(loaded), content)
    sentence = ""
    if folder:
        texts = job.texts(loaded, result, json_text(content), folder)
        write_files(folder, texts)
        names = [*texts, *job.write_binaries(loaded, result, folder)]
        sentence = job.files_sentence(loaded, result, folder, names)
    if sentence and not job.names_files_last:
        say(sentence)
    job.export(loaded, result, content)
    print_json(content) if flags.json else job.show(loaded, result)
    for note in job.notes(loaded, result):
        say(note)
    if sentence and job.names_files_last:
        say(sentence)
    job.finish(loaded, result)
    return code


def compute(job: Job[Loaded, Result]) -> tuple[Loaded, Result]:
    """Return the loaded data and the result; complaints about numbers get file and line."""
    loaded = job.load()
    with progress() as report, about(*job.place) if job.place else nullcontext():
        return loaded, job.run(loaded, report)


# --- jobs in shards ---


@dataclass(frozen=True)
class SharedJob(Job[Loaded, Result]):
    """A job whose blocks several processes or computers may do. `cls.of_shards(options, sharing)` makes it again for `vcmm merge`."""

    verb: ClassVar[str]
    sharing: Sharing = field(default_factory=Sharing, kw_only=True)

    @property
    @abstractmethod
    def stem(self) -> str:
        """Name of the file of a shard."""

    @abstractmethod
    def options(self) -> dict[str, Any]:
        """Return the options of the job, as its shards hold them (JSON)."""

    @abstractmethod
    def inputs(self) -> list[Path]:
        """Return all files that the job reads."""

    @classmethod
    @abstractmethod
    def of_shards(cls, options: dict[str, Any], sharing: Sharing) -> SharedJob[Loaded, Result]:
        """Return the job of `options`, on the blocks of its shards."""

    def check_shard(self) -> None:
        """Raises UsageError for an option that has no meaning for one shard."""


def run_shared(job: SharedJob[Loaded, Result], flags: Flags) -> int:
    """Run the whole job, or its share as a document that `vcmm merge` reads: on stdout, or as a file in --out or here."""
    share = job.sharing.share
    if share is None:
        return run_job(job, flags)
    job.check()
    job.check_shard()
    content = write_shard(job.verb, job.options(), job.inputs(), share, lambda: compute(job))
    return put_shard(content, job.stem or job.verb, flags.json, flags.out)


def write_shard(
    verb: str, options: dict[str, Any], files: list[Path], share: Share, job: Callable[[], object]
) -> dict[str, Any]:
    """Do a job's share and return the document that `vcmm merge` reads.

    A job in which nothing is sampled has no blocks: its shards are empty, and merging them does the job.
    """
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
    """Write the shard as a document on stdout, or as a file in `out` or here."""
    if json:
        print_json(content)
        return 0
    number, of = content["shard"]
    say(f"wrote {write_text((out or Path()) / f'{stem}.shard-{number}-of-{of}.json', json_text(content))}")
    return 0


def sharing_of(workers: int | None, cluster: str | None, shard: str | None, keep: bool = False) -> Sharing:
    """Return the Sharing for these options: who counts, and where finished blocks are kept until the job is done. Raises UsageError.

    keep: even where this process does it all.
    """
    long = keep or workers is not None or cluster is not None or shard is not None
    folder = _block_folder() if long else None
    return Sharing(crew_of(workers, cluster), Folder(folder) if folder else NoStore(), share_of(shard))


def share_of(text: str | None) -> Share | None:
    """Parse '2/8' -> the second of eight shards. Raises UsageError."""
    if text is None:
        return None
    match = re.fullmatch(r"([0-9]{1,6})/([0-9]{1,6})", text)
    if not match:
        raise UsageError(f'--shard "{text}"; write for example --shard 2/8, the second of eight')
    return Share(int(match[1]), int(match[2]))


def _block_folder() -> Path | None:
    """Return the folder of finished blocks in the user's cache; None where nothing can be kept."""
    home = os.environ.get("XDG_CACHE_HOME") or os.environ.get("LOCALAPPDATA")
    try:
        folder = (Path(home) if home else Path.home() / ".cache") / "vcmm" / "blocks"
        folder.mkdir(parents=True, exist_ok=True)
    except (OSError, RuntimeError):
        return None
    return folder if os.access(folder, os.W_OK) else None


# --- decisions and evidence ---


def decision_code(characteristics: Iterable[CharacteristicResult], require: str | None) -> int:
    """Return 1 where a characteristic does not conform; with --require conforms also where one is undecided.

    UsageError: something is required and nothing is decided, as no characteristic has limits.
    """
    decided = [c.decision.text for c in characteristics if c.decision is not None]
    if require is None:
        return int(FAILED in decided)
    if not decided:
        raise UsageError(
            "--require conforms, but no characteristic has limits: state limits or zone in [[part.characteristics]]"
        )
    return int(any(text != REQUIRED for text in decided))


def keep_evidence(path: Path, pack: Pack, content: dict[str, Any]) -> None:
    """Write the evidence pack of a job. content: its document, which names all files read."""
    from vcmm.answer.evaluation.declaration import declared_influences
    from vcmm.show.console.evidence import command_words, write_pack

    files = [Path(entry["file"]) for entry in content["inputs"]]
    words = command_words(pack.verb, pack.scenario, pack.options)
    write_pack(path, words, content, files, declared_influences(pack.task))
    say(f"wrote {path}; vcmm rerun {path} runs it again")
