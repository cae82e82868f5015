"""Monte Carlo in blocks of trials: tallies of whole numbers, whose sum does not depend on the workers, the order of blocks or
the number of interruptions.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any

import numpy as np

from vcmm.answer.evaluation.summary import Accumulator
from vcmm.core.blocks import Block, Sharing

PackedAccumulator = dict[str, Any]
Count = Callable[[Any, Block], list[PackedAccumulator]]  # (job, block) -> one tally per characteristic


def sum_blocks(
    sharing: Sharing,
    key: str,
    count: Count,
    job: Any,
    blocks: Sequence[Block],
    progress: Callable[[float], None],
) -> list[Accumulator]:
    """Return the sum of all blocks, one accumulator per characteristic. Raises ShardDone where a share is wanted."""
    wanted = sharing.share.take(blocks) if sharing.share else blocks
    total = _Total(sum(n for _, n in wanted), progress)
    for block, tallies in sharing.run_blocks(key, count, job, {b: b for b in blocks}):
        total.add(block, tallies)
    return total.sums


class _Total:
    """Running total that adds tallies as they come."""

    def __init__(self, trials: int, progress: Callable[[float], None]) -> None:
        self.trials, self.progress, self.seen = trials, progress, 0
        self.sums: list[Accumulator] = []

    def add(self, block: Block, tallies: Iterable[PackedAccumulator]) -> None:
        accumulators = [unpack(t) for t in tallies]
        if not self.sums:
            self.sums = accumulators
        else:
            for mine, more in zip(self.sums, accumulators):
                mine.merge(more)
        self.seen += block[1]
        self.progress(self.seen / self.trials)


def pack(accumulator: Accumulator) -> PackedAccumulator:
    """Return the integers of an accumulator as JSON holds them; floats by their hexadecimal digits, so that no bit is lost."""
    bins = np.flatnonzero(accumulator.counts)
    return {
        "place": [accumulator.centre.hex(), accumulator.scale.hex()],
        "bins": bins.tolist(),
        "counts": accumulator.counts[bins].tolist(),
        "trials": accumulator.trials,
        "range": [accumulator.minimum.hex(), accumulator.maximum.hex()],
        "sums": [str(n) for n in accumulator.sums],
    }


def unpack(packed_sums: PackedAccumulator) -> Accumulator:
    """Return the accumulator that `pack` wrote."""
    centre, scale = (float.fromhex(text) for text in packed_sums["place"])
    low, high = (float.fromhex(text) for text in packed_sums["range"])
    out = Accumulator(centre, scale, trials=int(packed_sums["trials"]), minimum=low, maximum=high)
    out.counts[np.array(packed_sums["bins"], dtype=np.intp)] = packed_sums["counts"]
    out.take(*map(int, packed_sums["sums"]))
    return out
