"""Mutations over all readers: python tools/fuzz.py [first seed] [how many] prints every fault and counts by reader."""

from __future__ import annotations

import sys
import tempfile
from collections import Counter
from pathlib import Path

sys.path.insert(0, str(Path(__file__).resolve().parents[1]))

from tests.hostile.judge import trial


def main(first: int = 0, count: int = 3000) -> int:
    """Returns 1 where a fault was found."""
    asked, refused, faults = Counter[str](), Counter[str](), Counter[str]()
    with tempfile.TemporaryDirectory() as folder:
        for seed in range(first, first + count):
            found = trial(Path(folder), seed)
            asked[found.case] += 1
            refused[found.case] += found.answer.code == 2
            if found.fault:
                faults[found.case] += 1
                print(f"{seed} {found.case}, {found.file}: {found.mutation.what}: {found.fault}", flush=True)
    for name in asked:
        print(f"{name:20} {asked[name]:6} mutations {refused[name]:6} refused {faults[name]:4} faults")
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main(*map(int, sys.argv[1:])))
