"""Split a long job into blocks: who computes them, which results are kept, and which part is wanted.

A block is (first, count) of whatever is counted; its result is plain JSON values that depend on the job alone. So it does not
matter who did which block, in which order, or how often the work was taken up again: finished blocks are kept under the key
of their job, and a job that was interrupted goes on where it was.
"""

from __future__ import annotations

import hashlib
import json
import shutil
from collections.abc import Callable, Iterable, Iterator, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

from vcmm import __version__
from vcmm.core.crew import Crew, in_process
from vcmm.core.errors import DataError, UsageError
from vcmm.core.whole_files import write_files

Block = tuple[int, int]  # the first, and how many
Work = Callable[[Any, Any], Any]  # (payload, item) -> JSON values
Progress = Callable[[str, float], None]  # (what is under way, share of it that is done)


class ShardDone(Exception):
    """The blocks of one shard are done; the exception holds the key of the job and the blocks. It is no error: only the merged shards
    give a result."""

    def __init__(self, key: str, blocks: Mapping[Block, Any]) -> None:
        super().__init__(key)
        self.key, self.blocks = key, blocks


@dataclass(frozen=True)
class Share:
    """Shard `number` of `of`: every of-th block."""

    number: int
    of: int

    def __post_init__(self) -> None:
        if not 1 <= self.number <= self.of:
            raise UsageError(
                f"there is no shard {self.number}/{self.of}; write 1/{self.of} to {self.of}/{self.of}"
            )

    def take(self, blocks: Sequence[Block]) -> list[Block]:
        return list(blocks[self.number - 1 :: self.of])


class Store(Protocol):
    """Finished blocks of a job."""

    def read(self, key: str) -> Iterator[tuple[Block, Any]]: ...

    def write(self, key: str, block: Block, result: Any) -> None: ...

    def discard(self, key: str) -> None: ...


@dataclass(frozen=True)
class NoStore:
    """A store that keeps nothing, for jobs that are quickly done again."""

    def read(self, key: str) -> Iterator[tuple[Block, Any]]:
        return iter(())

    def write(self, key: str, block: Block, result: Any) -> None: ...

    def discard(self, key: str) -> None: ...


@dataclass(frozen=True)
class Folder:
    """One file per block below `path`/key, each written whole; gone when the job is done."""

    path: Path

    def read(self, key: str) -> Iterator[tuple[Block, Any]]:
        for file in sorted((self.path / key).glob("*.json")):
            with suppress(ValueError, OSError):  # a file that somebody else has spoilt is done again
                first, count = map(int, file.stem.split("-"))
                yield (first, count), json.loads(file.read_text(encoding="utf-8"))

    def write(self, key: str, block: Block, result: Any) -> None:
        write_files(self.path / key, {f"{block[0]}-{block[1]}.json": json.dumps(result)})

    def discard(self, key: str) -> None:
        shutil.rmtree(self.path / key, ignore_errors=True)


@dataclass(frozen=True)
class Shards:
    """The blocks of all shards of a job, as read from their files; nothing is computed again."""

    key: str
    blocks: Mapping[Block, Any]

    def read(self, key: str) -> Iterator[tuple[Block, Any]]:
        if key != self.key:
            raise DataError(
                "the shards are of another job than these files now give; let all shards run on the same files and version"
            )
        return iter(self.blocks.items())

    def write(self, key: str, block: Block, result: Any) -> None:
        raise DataError(f"no shard holds the block from {block[0]} on; name the files of all shards")

    def discard(self, key: str) -> None: ...


@dataclass(frozen=True)
class Sharing:
    """Sharing of a job: the computing crew, the store of results, and the wanted part (share; None for all)."""

    crew: Crew = in_process
    store: Store = field(default_factory=NoStore)
    share: Share | None = None

    def run_blocks(
        self, key: str, work: Work, payload: Any, items: Mapping[Block, Any]
    ) -> Iterator[tuple[Block, Any]]:
        """Yield (block, result) in the order of completion, those that were kept first. Raises ShardDone at the end where a share is wanted.

        items: block -> the argument of `work` for it; the result must survive JSON.
        """
        wanted = self.share.take(list(items)) if self.share else list(items)
        left, part = dict.fromkeys(wanted), dict[Block, Any]()
        for block, result in self.store.read(key):
            if block in left:
                del left[block]
                yield block, self._collect(part, block, result)
        todo = list(left)
        if todo and isinstance(self.store, Shards):
            self.store.write(key, todo[0], None)
        try:
            for i, result in self.crew(work, payload, [items[b] for b in todo]):
                self.store.write(key, todo[i], result)
                yield todo[i], self._collect(part, todo[i], result)
        except KeyboardInterrupt as error:
            if isinstance(self.store, Folder):
                error.add_note("what is finished is kept: the same call goes on where it was")
            raise
        self.store.discard(key)
        if self.share:
            raise ShardDone(key, part)

    def _collect(self, part: dict[Block, Any], block: Block, result: Any) -> Any:
        """Keep the result of a block for a share, which is handed over as a whole; otherwise return it and keep nothing."""
        if self.share:
            part[block] = result
        return result

    def map_items(
        self,
        key: str,
        work: Work,
        payload: Any,
        items: Sequence[Any],
        progress: Callable[[float], None] = lambda share: None,
    ) -> list[Any]:
        """Return the results of all items in their order; every item is a block by itself."""
        every = {(i, 1): item for i, item in enumerate(items)}
        count = len(self.share.take(list(every))) if self.share else len(every)
        results: dict[Block, Any] = {}
        for block, result in self.run_blocks(key, work, payload, every):
            results[block] = result
            progress(len(results) / count)
        return [results[block] for block in every]


def blocks_of(total: int, size: int) -> list[Block]:
    """Return (first, count) of all blocks; only the last may be shorter than `size`."""
    return [(first, min(size, total - first)) for first in range(0, total, size)]


def key_of(verb: str, options: Mapping[str, Any], files: Iterable[Path]) -> str:
    """Return the key of a job, made of version, verb, options, and the names and bytes of all files that it reads."""
    question = json.dumps(dict(sorted(options.items())), default=str)
    digest = hashlib.sha256(f"{__version__}\n{verb}\n{question}".encode())
    for file in dict.fromkeys(files):
        digest.update(f"\n{file.name}\n".encode() + file.read_bytes())
    return f"{verb}-{digest.hexdigest()[:32]}"
