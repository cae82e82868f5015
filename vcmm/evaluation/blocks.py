"""Monte Carlo in blocks that anybody may count: each is known by its first trial and how many it holds.

Tallies are integers (vcmm.evaluation.summary), so their sum does not depend on who counted what, in which order, or how
often the work was taken up again. Blocks that are finished are kept under the key of their job, which is made of the draws
themselves: a job that was interrupted goes on where it was.
"""

from __future__ import annotations

import json
import shutil
from collections.abc import Callable, Iterable, Mapping, Sequence
from contextlib import suppress
from dataclasses import dataclass, field
from pathlib import Path
from typing import Any, Protocol

import numpy as np

from vcmm.core.crew import Crew, alone
from vcmm.core.errors import DataError, UsageError
from vcmm.core.whole_files import write_files
from vcmm.evaluation.summary import Accumulator

Block = tuple[int, int]  # first trial, number of trials
Packed = dict[str, Any]
Count = Callable[[Any, Block], list[Packed]]  # (job, block) -> one tally per characteristic


class ShardDone(Exception):
    """The blocks of one shard are counted: key of the job, and its blocks. No error: there is no result yet."""

    def __init__(self, key: str, blocks: Mapping[Block, list[Packed]]) -> None:
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

    def taken(self, blocks: Sequence[Block]) -> list[Block]:
        return list(blocks[self.number - 1 :: self.of])


class Store(Protocol):
    """Finished blocks of a job."""

    def read(self, key: str) -> dict[Block, list[Packed]]: ...

    def write(self, key: str, block: Block, tallies: list[Packed]) -> None: ...

    def done(self, key: str) -> None: ...


@dataclass(frozen=True)
class Nowhere:
    """Keeps nothing: jobs that are quickly done again."""

    def read(self, key: str) -> dict[Block, list[Packed]]:
        return {}

    def write(self, key: str, block: Block, tallies: list[Packed]) -> None: ...

    def done(self, key: str) -> None: ...


@dataclass(frozen=True)
class Folder:
    """One file per block below `path`/key, each written whole; gone when the job is done."""

    path: Path

    def read(self, key: str) -> dict[Block, list[Packed]]:
        out = {}
        for file in sorted((self.path / key).glob("*.json")):
            first, count = map(int, file.stem.split("-"))
            with suppress(ValueError, OSError):  # a file that somebody else has spoilt is counted again
                out[first, count] = json.loads(file.read_text(encoding="utf-8"))
        return out

    def write(self, key: str, block: Block, tallies: list[Packed]) -> None:
        write_files(self.path / key, {f"{block[0]}-{block[1]}.json": json.dumps(tallies)})

    def done(self, key: str) -> None:
        shutil.rmtree(self.path / key, ignore_errors=True)


@dataclass(frozen=True)
class Shards:
    """The blocks of all shards of a job, as read from their files. Nothing is counted anew."""

    key: str
    blocks: Mapping[Block, list[Packed]]

    def read(self, key: str) -> dict[Block, list[Packed]]:
        if key != self.key:
            raise DataError(
                "the shards are of another job than these files now give; let all shards run on the same files and version"
            )
        return dict(self.blocks)

    def write(self, key: str, block: Block, tallies: list[Packed]) -> None:
        raise DataError(f"no shard holds the trials from {block[0]} on; name the files of all shards")

    def done(self, key: str) -> None: ...


@dataclass(frozen=True)
class Sharing:
    """Who counts (crew), what is kept of it (store), and which part is wanted (share; None for all)."""

    crew: Crew = alone
    store: Store = field(default_factory=Nowhere)
    share: Share | None = None

    def counted(
        self, key: str, count: Count, job: Any, blocks: Sequence[Block], progress: Callable[[float], None]
    ) -> list[Accumulator]:
        """The sum of all blocks, one accumulator per characteristic. Raises ShardDone where a share is wanted."""
        wanted = self.share.taken(blocks) if self.share else list(blocks)
        known = {b: t for b, t in self.store.read(key).items() if b in set(wanted)}
        total = _Total(sum(n for _, n in wanted), progress)
        for block in known:
            total.add(block, known[block])
        todo = [b for b in wanted if b not in known]
        if todo and isinstance(self.store, Shards):
            self.store.write(key, todo[0], [])
        for i, tallies in self.crew(count, job, todo):
            self.store.write(key, todo[i], tallies)
            if self.share:
                known[todo[i]] = tallies
            total.add(todo[i], tallies)
        self.store.done(key)
        if self.share:
            raise ShardDone(key, known)
        return total.sums


class _Total:
    """Adds tallies up as they come."""

    def __init__(self, trials: int, progress: Callable[[float], None]) -> None:
        self.trials, self.progress, self.seen = trials, progress, 0
        self.sums: list[Accumulator] = []

    def add(self, block: Block, tallies: Iterable[Packed]) -> None:
        found = [unpacked(t) for t in tallies]
        if not self.sums:
            self.sums = found
        else:
            for mine, more in zip(self.sums, found):
                mine.merge(more)
        self.seen += block[1]
        self.progress(self.seen / self.trials)


def blocks_of(trials: int, size: int) -> list[Block]:
    """(first, count) of all blocks; only the last may be shorter than `size`."""
    return [(first, min(size, trials - first)) for first in range(0, trials, size)]


def packed(accumulator: Accumulator) -> Packed:
    """The integers of an accumulator as JSON holds them; floats by their hexadecimal digits, so that no bit is lost."""
    bins = np.flatnonzero(accumulator.counts)
    return {
        "place": [accumulator.centre.hex(), accumulator.scale.hex()],
        "bins": bins.tolist(),
        "counts": accumulator.counts[bins].tolist(),
        "trials": accumulator.trials,
        "range": [accumulator.minimum.hex(), accumulator.maximum.hex()],
        "sums": [str(n) for n in accumulator.sums],
    }


def unpacked(found: Packed) -> Accumulator:
    """The accumulator that `packed` wrote."""
    centre, scale = (float.fromhex(text) for text in found["place"])
    low, high = (float.fromhex(text) for text in found["range"])
    out = Accumulator(centre, scale, trials=int(found["trials"]), minimum=low, maximum=high)
    out.counts[np.array(found["bins"], dtype=np.intp)] = found["counts"]
    out.take(*map(int, found["sums"]))
    return out
