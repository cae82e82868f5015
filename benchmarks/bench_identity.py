"""The same numbers to the last bit, whoever counts: blocks, threads, processes, shards, Dask, and after kills. One command.

    python -m benchmarks.bench_identity [--trials 3000] [--without dask]

First the numbers themselves: 2^18 trials of 15 outputs in 1, 2 and 8 pieces, and by two threads. Then documents as a user gets
them: `vcmm uncertainty` of the ring gauge with exact trials (500 to a block) by one process, two workers, two workers one of which
is killed (`kill -9`), a client that is killed and called again, two shards put together by `vcmm merge`, two Dask workers, and
two of which one is killed. Exit code 1 where one differs.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

import numpy as np
import psutil

from benchmarks.bench_montecarlo import Scenario
from benchmarks.bench_sharing import VCMM, dask

PIECES, TRIALS = (1, 2, 8), 2**18


def numbers() -> dict[str, str]:
    """The trials themselves, as a digest, by pieces and by threads."""
    from vcmm.answer.evaluation.montecarlo import simulate

    terms = Scenario().terms()

    def piece(first: int, trials: int) -> np.ndarray:
        return np.concatenate(
            [b.copy() for b in simulate(np.zeros(15), terms, seed=1, trials=trials, first=first)]
        )

    def cut(n: int) -> list[tuple[int, int]]:
        return [(k * TRIALS // n, TRIALS // n) for k in range(n)]

    def digest(parts: Sequence[np.ndarray]) -> str:
        return hashlib.sha256(np.concatenate(parts).tobytes()).hexdigest()[:12]

    found = {f"{n} pieces": digest([piece(*p) for p in cut(n)]) for n in PIECES}
    with ThreadPoolExecutor(2) as pool:
        found["two threads"] = digest(list(pool.map(lambda p: piece(*p), cut(8))))
    return found


def until(true: Callable[[], bool]) -> None:
    while not true():
        time.sleep(0.02)


class Documents:
    """One job done in many ways; each way starts without finished blocks."""

    def __init__(self, folder: Path, trials: int) -> None:
        from vcmm.files.own.library import example

        self.folder, self.scenario = folder, folder / "ring.toml"
        self.scenario.write_text(example("ring_gauge").read_text())
        self.job = ("uncertainty", "ring.toml", "--engine", "exact", "--trials", str(trials))
        os.environ["XDG_CACHE_HOME"] = str(folder / "cache")

    def start(self, *words: str) -> subprocess.Popen[bytes]:
        return subprocess.Popen(
            [*VCMM, *self.job, *words], cwd=self.folder, stdout=subprocess.PIPE, stderr=subprocess.DEVNULL
        )

    def kept(self) -> int:
        return len(list((self.folder / "cache").rglob("*-500.json")))

    def plain(self, *words: str) -> bytes:
        return self.start("--json", *words).communicate()[0]

    def one_killed(self, *words: str, hands: Sequence[psutil.Process] = ()) -> bytes:
        """A worker ended by kill -9 after the first block."""
        client = self.start("--json", *words)
        until(lambda: self.kept() >= 1 or client.poll() is not None)
        victims = list(hands) or psutil.Process(client.pid).children()
        if client.poll() is None:
            victims[-1].kill()  # the first child of a client keeps its books and does no work
        return client.communicate()[0]

    def taken_up(self) -> bytes:
        """The client ended by kill -9 after the second block, then called again."""
        client = self.start("--json", "--workers", "2")
        until(lambda: self.kept() >= 2 or client.poll() is not None)
        client.kill()
        client.communicate()
        print(f"killed with {self.kept()} blocks kept, called again", flush=True)
        return self.plain("--workers", "2")

    def shards(self) -> bytes:
        for k in (1, 2):
            self.start("--shard", f"{k}/2").communicate()
        words = ("merge", "ring.shard-1-of-2.json", "ring.shard-2-of-2.json", "--json")
        return subprocess.run([*VCMM, *words], cwd=self.folder, capture_output=True, check=False).stdout

    def on_dask(self, kill: bool) -> bytes:
        with dask(self.folder, 2) as (address, hands):
            words = ("--cluster", address)
            return self.one_killed(*words, hands=hands) if kill else self.plain(*words)


def documents(folder: Path, trials: int, clusters: bool) -> dict[str, str]:
    job = Documents(folder, trials)
    ways: dict[str, Callable[[], bytes]] = {
        "one process": job.plain,
        "two workers": lambda: job.plain("--workers", "2"),
        "two workers, one killed": lambda: job.one_killed("--workers", "2"),
        "client killed, called again": job.taken_up,
        "two shards, merged": job.shards,
    }
    if clusters:
        ways |= {
            "two Dask workers": lambda: job.on_dask(False),
            "two Dask workers, one killed": lambda: job.on_dask(True),
        }
    found = {}
    for name, way in ways.items():
        printed = way()
        found[name] = hashlib.sha256(printed).hexdigest()[:12] if printed else "nothing printed"
        print(f"| {name} | {found[name]} |", flush=True)
    return found


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--trials", type=int, default=3000)
    parser.add_argument("--without", choices=("dask",), default=None)
    given = parser.parse_args()
    found = numbers()
    for name, digest in found.items():
        print(f"| {name} | {digest} |", flush=True)
    with tempfile.TemporaryDirectory() as folder:
        told = documents(Path(folder), given.trials, given.without is None)
    same = (
        len(set(found.values())) == 1
        and len(set(told.values())) == 1
        and "nothing printed" not in told.values()
    )
    print("the same to the last bit" if same else "DIFFERENT")
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores, {time.strftime('%d %B %Y')}")
    return 0 if same else 1


if __name__ == "__main__":
    sys.exit(main())
