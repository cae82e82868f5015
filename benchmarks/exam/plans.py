"""Which cases a run holds, in which order: rounds, so that a run stopped at any time is a balanced sample.

A round holds `count` cases of every entry; the next round goes on with the next numbers. Plain methods run on every third case.
"""

from __future__ import annotations

from collections.abc import Iterator
from dataclasses import dataclass

Asked = tuple[str, int, float, bool]  # block, number, delta, plain methods too


@dataclass(frozen=True)
class Entry:
    """count cases of a block per round, from number `first`."""

    block: str
    count: int
    delta: float = 10.0
    first: int = 0


ROUND = (
    Entry("A", 10), Entry("A", 3, 7.0, 1000), Entry("A", 3, 5.0, 2000), Entry("B", 2), Entry("C", 1), Entry("D", 1),
    Entry("E", 1, 15.0), Entry("F", 1), Entry("G", 1), Entry("H", 1),
)  # fmt: skip
PLANS: dict[str, tuple[tuple[Entry, ...], int]] = {  # entries of a round, rounds
    "ten-minutes": ((Entry("A", 4), Entry("B", 2), Entry("E", 1, 15.0), Entry("F", 1), Entry("H", 1)), 30),
    "hour": (ROUND, 60),
    # every block of the size that its bars can be read from in 636 cases: 120 nulls, 24 courses of time
    "balanced": (
        (Entry("A", 6), Entry("A", 6, 7.0, 1000), Entry("A", 4, 5.0, 2000), Entry("A", 4, 15.0, 3000), Entry("B", 10),
         Entry("C", 2), Entry("D", 4), Entry("E", 8, 15.0), Entry("F", 4), Entry("G", 2), Entry("H", 3)), 12,
    ),
    # 960 per delta in A, 300 to 420 of C to H: the sizes published with the method; B 690 of each of eight worlds
    "overnight": (
        (*(Entry("A", 16, d, f) for d, f in ((10.0, 0), (7.0, 1000), (5.0, 2000), (15.0, 3000))), Entry("B", 92),
         Entry("C", 5), Entry("D", 5), Entry("E", 7, 15.0), Entry("F", 7), Entry("G", 4), Entry("H", 5)), 60,
    ),
}  # fmt: skip


def asked(name: str) -> Iterator[Asked]:
    """All cases of a plan in order. Raises KeyError for an unknown plan."""
    entries, rounds = PLANS[name]
    for turn in range(rounds):
        for e in entries:
            for k in range(e.count):
                number = turn * e.count + k
                yield e.block, e.first + number, e.delta, number % 3 == 0


def size(name: str) -> int:
    entries, rounds = PLANS[name]
    return rounds * sum(e.count for e in entries)
