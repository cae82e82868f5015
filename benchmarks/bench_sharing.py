"""What sharing a job out gains: one process, two workers, one and two Dask workers, in one run, rounds interleaved.

    python -m benchmarks.bench_sharing [--trials 100000000] [--parts 500000] [--rounds 3] [--only trials,audit]

Commands as a user types them; every document must be the same to the last byte. Told are seconds to wait and seconds of the
processor of the caller and of the busiest worker: their sum is what two free cores would let wait, which other work on the
computer does not disturb. The best round of each counts. Needs the extra `cluster` for the Dask workers.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Callable, Iterator, Sequence
from contextlib import contextmanager
from dataclasses import dataclass
from pathlib import Path

import psutil

VCMM = [sys.executable, "-c", "from vcmm.face.cli import main; main()"]
LOOK = 0.1  # s between two looks at the workers


@dataclass(frozen=True)
class Run:
    """One command: seconds to wait, seconds of the processor of the caller and of the busiest worker, MB of the largest process,
    MB without files of libraries (which processes share), what it printed.
    """

    wait: float
    caller: float
    worker: float
    memory: float
    private: float
    printed: bytes

    @property
    def free(self) -> float:
        """Seconds to wait where every process has a core."""
        return self.caller + self.worker


def used(process: psutil.Process) -> tuple[float, float, float]:
    """(seconds of the processor, MB, MB without files of libraries where the system tells); of one that has ended nothing."""
    try:
        times, memory = process.cpu_times(), process.memory_info()
    except psutil.Error:
        return 0.0, 0.0, 0.0
    return times.user + times.system, memory.rss / 1e6, (memory.rss - getattr(memory, "shared", 0)) / 1e6


def watched(
    words: Sequence[str], elsewhere: Sequence[psutil.Process] = (), program: Sequence[str] = VCMM
) -> Run:
    """Run a command to its end. elsewhere: workers that were there before; program: another way to start vcmm."""
    began, before = time.perf_counter(), {p.pid: used(p)[0] for p in elsewhere}
    seconds: dict[int, float] = {}
    most, most_private = 0.0, 0.0
    with (
        tempfile.TemporaryFile() as out,
        subprocess.Popen([*program, *words], stdout=out, stderr=subprocess.DEVNULL) as child,
    ):
        caller = psutil.Process(child.pid)
        while child.poll() is None:
            for p in (caller, *caller.children(), *elsewhere):
                spent, memory, private = used(p)
                seconds[p.pid] = max(spent - before.get(p.pid, 0.0), seconds.get(p.pid, 0.0))
                most, most_private = max(most, memory), max(most_private, private)
            time.sleep(LOOK)
        wait = time.perf_counter() - began
        out.seek(0)
        printed = out.read()
    if child.returncode not in (0, 1):
        raise SystemExit(f"{' '.join(words)}: exit {child.returncode}")
    own = seconds.pop(child.pid, 0.0)
    return Run(wait, own, max(seconds.values(), default=0.0), most, most_private, printed)


@contextmanager
def dask(folder: Path, workers: int) -> Iterator[tuple[str, list[psutil.Process]]]:
    """A scheduler and workers of one thread each, as a user starts them."""
    import distributed

    plan, started = folder / f"scheduler{workers}.json", list[subprocess.Popen[bytes]]()
    plan.unlink(missing_ok=True)  # of an earlier round: its scheduler is gone
    local = [sys.executable, "-m", "dask"]

    def start(*words: str) -> psutil.Process:
        quiet = subprocess.DEVNULL
        started.append(subprocess.Popen([*local, *words, "--no-dashboard"], stdout=quiet, stderr=quiet))
        return psutil.Process(started[-1].pid)

    try:
        start("scheduler", "--host", "127.0.0.1", "--port", "0", "--scheduler-file", str(plan))
        while not (plan.exists() and plan.read_text().strip().endswith("}")):
            time.sleep(LOOK)
        address = json.loads(plan.read_text())["address"]
        own = ("worker", address, "--nthreads", "1", "--no-nanny", "--local-directory", str(folder))
        hands = [start(*own) for _ in range(workers)]
        with distributed.Client(address, set_as_default=False) as client:
            client.wait_for_workers(workers)
        yield address, hands
    finally:
        for one in started:
            one.kill()
            one.wait()


def ways(job: tuple[str, ...], folder: Path, clusters: bool) -> dict[str, Callable[[], Run]]:
    """How the job is done."""

    def on_dask(workers: int) -> Run:
        with dask(folder, workers) as (address, hands):
            return watched((*job, "--cluster", address), hands)

    found: dict[str, Callable[[], Run]] = {
        "one process": lambda: watched(job),
        "two workers": lambda: watched((*job, "--workers", "2")),
    }
    if clusters:
        found |= {"one Dask worker": lambda: on_dask(1), "two Dask workers": lambda: on_dask(2)}
    return found


def compared(title: str, job: tuple[str, ...], rounds: int, clusters: bool) -> bool:
    """Print the rows of one job; whether all documents are the same."""
    runs: dict[str, list[Run]] = {}
    with tempfile.TemporaryDirectory() as folder:
        os.environ["XDG_CACHE_HOME"] = folder  # finished blocks of an earlier call would be taken from it
        for _ in range(rounds):
            for name, run in ways(job, Path(folder), clusters).items():
                runs.setdefault(name, []).append(run())
    same = len({r.printed for each in runs.values() for r in each}) == 1
    for name, each in runs.items():
        base = runs["one Dask worker" if "Dask" in name else "one process"]
        wait, free = min(r.wait for r in each), min(r.free for r in each)
        one, one_free = min(r.wait for r in base), min(r.free for r in base)
        memory = max(r.memory for r in each)
        print(
            f"| {title} | {name} | {wait:.1f} | {one / wait:.2f} | {free:.1f} | {one_free / free:.2f} | {memory:.0f} |",
            flush=True,
        )
    print(f"{title}: {'the same document' if same else 'DIFFERENT documents'}")
    return same


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--trials", type=int, default=100_000_000)
    parser.add_argument("--parts", type=int, default=500_000)
    parser.add_argument("--rounds", type=int, default=3)
    parser.add_argument("--only", default="trials,audit")
    given = parser.parse_args()
    try:
        import distributed  # noqa: F401

        clusters = True
    except ImportError:
        clusters = False
    from vcmm.files.own.library import example

    ring = str(example("ring_gauge"))
    jobs = {
        "trials": (f"{given.trials:,} trials", ("uncertainty", ring, "--trials", str(given.trials), "--engine", "montecarlo", "--json")),
        "audit": (f"audit of {given.parts:,} parts", ("audit", ring, "--parts", str(given.parts), "--json")),
    }  # fmt: skip
    print(
        "| job | who | s to wait | gain | s with free cores | gain | MB, largest process |\n|---|---|---|---|---|---|---|"
    )
    good = [compared(*jobs[name], given.rounds, clusters) for name in given.only.split(",")]
    print(f"load {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores at the end")
    return 0 if all(good) else 1


if __name__ == "__main__":
    sys.exit(main())
