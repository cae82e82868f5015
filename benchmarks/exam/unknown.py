"""The prior of a mechanism that no catalogue holds, fitted on each half of the kept cases and tested on the other one.

    python -m benchmarks.exam.unknown [RESULTS ...]

Such a mechanism can do whatever the best name does, so the rows cannot tell it from that name: its odds against a name that is surely the
best of the catalogue are a constant w, and p / (1 + w) is left of a probability p. w is the ratio of wrong to right claims of at least
0.95, each plus one (Laplace); once where the account closes (verdict "explained") and once where something is left. The program uses
the w of both halves together (last rows), which no case has tested.
"""

from __future__ import annotations

import gzip
import json
import sys
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path
from typing import Any

from benchmarks.exam.calibration import Claim, claims
from benchmarks.exam.score import bound

SURE = 0.95  # claims that are counted
KEPT = ("results.jsonl.gz", "results_balanced.jsonl.gz")
CLOSED, OPEN = "explained", "something is left"


def records(paths: Sequence[Path]) -> list[dict[str, Any]]:
    out = []
    for path in paths:
        with gzip.open(path, "rt") as file:
            out += [json.loads(line) for line in file]
    return out


def by_verdict(rows: Iterable[Mapping[str, Any]]) -> dict[str, list[Claim]]:
    """The sure claims of every record, by whether the account closes."""
    out: dict[str, list[Claim]] = {CLOSED: [], OPEN: []}
    for r in rows:
        group = CLOSED if r.get("verdict") == "explained" else OPEN
        out[group] += [c for c in claims([r]) if c.stated >= SURE]
    return out


def odds(found: Sequence[Claim]) -> float:
    """w of some sure claims."""
    right = sum(c.right for c in found)
    return (len(found) - right + 1) / (right + 1)


def row(group: str, name: str, fitted: Sequence[Claim], tested: Sequence[Claim]) -> str:
    """One line of the table: w of some claims, and what it states of others beside what is right there."""
    w, hits = odds(fitted), sum(c.right for c in tested)
    stated = sum(c.stated for c in tested) / max(len(tested), 1)
    interval = f"{bound(hits, len(tested), lower=True):.3f} to {bound(hits, len(tested), lower=False):.3f}"
    return (
        f"| {group} | {name} | {sum(c.right for c in fitted)} of {len(fitted)} | {w:.3f} | {stated:.3f} | {stated / (1 + w):.3f} |"
        f" {hits} of {len(tested)} = {hits / max(len(tested), 1):.3f} | {interval} |"
    )


def main(words: Sequence[str]) -> int:
    here = Path(__file__).resolve().parent
    rows = records([Path(w) for w in words] or [here / name for name in KEPT])
    first, second = (by_verdict(rows[k::2]) for k in (0, 1))
    print(
        "| verdict | fitted, tested | right, fitted | w | stated before | stated now | right, tested | 90 % bounds |"
    )
    print("|" + "---|" * 8)
    for group in (CLOSED, OPEN):
        print(row(group, "first half, second half", first[group], second[group]))
        print(row(group, "second half, first half", second[group], first[group]))
    for group in (CLOSED, OPEN):
        both = [*first[group], *second[group]]
        print(
            f"| {group} | both halves, none | {sum(c.right for c in both)} of {len(both)} | {odds(both):.3f} | | | | |"
        )
    return 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
