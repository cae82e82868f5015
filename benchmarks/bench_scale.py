"""How large a job may be: seconds of the processor and memory of commands as a user types them.

    python -m benchmarks.bench_scale --only points              a trial with 1000 points against one with 100, bar 1.2
    python -m benchmarks.bench_scale --only threads             two threads of one process against one, aim 1.8, beside two processes
    python -m benchmarks.bench_scale --only trials [--sizes 10000000,100000000,1000000000] [--workers 2]
    python -m benchmarks.bench_scale --only scan [--sizes 100000,1000000]      one feature of so many points
    python -m benchmarks.bench_scale --only measured [--sizes 100000,1000000]  the same from a file of measured points
    python -m benchmarks.bench_scale --only parameters [--sizes 100,1000,10000]  a machine of so many parameters

Every command is a process of its own. Told are seconds to wait, seconds of the processor (caller, busiest worker: where every process
has a core their sum is the wait), the memory of the largest process, and that without the files of libraries, which
processes share. What a size adds is the difference to the first rows, where imports are the same. The load of the computer and the date are printed: other work makes every wait longer.
"""

from __future__ import annotations

import argparse
import json
import os
import sys
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

from benchmarks.bench_growth import RING, table_of
from benchmarks.bench_sharing import VCMM, watched

SMALL = 1000  # trials or points of the command that is all imports
LOADED = [VCMM[0], "-c", f"from vcmm.answer.evaluation import streams; streams.kernels(10**9); {VCMM[2]}"]
POINTS_BAR, POINTS, PAIRS = 1.2, (100, 1000), 7
SIZES = {
    "trials": "10000000,100000000",
    "scan": "100000,1000000",
    "measured": "100000,1000000",
    "parameters": "100,1000,10000",
}


def ring_text(points: int) -> str:
    from vcmm.files.own.library import example

    return example(RING).read_text().replace("n = 16 ", f"n = {points} ")


def trials_words(trials: int, folder: Path, workers: int) -> tuple[str, ...]:
    """All of them sampled."""
    (folder / "ring.toml").write_text(ring_text(16))
    words = (
        "uncertainty",
        str(folder / "ring.toml"),
        "--trials",
        str(trials),
        "--engine",
        "montecarlo",
        "--json",
    )
    return (*words, "--workers", str(workers)) if workers > 1 else words  # fmt: skip


def scan_words(points: int, folder: Path, workers: int) -> tuple[str, ...]:
    """The uncertainty of a diameter by so many touches, as vcmm decides."""
    (folder / "ring.toml").write_text(ring_text(points))
    return ("uncertainty", str(folder / "ring.toml"), "--trials", "100000", "--json")


def measured_words(points: int, folder: Path, workers: int) -> tuple[str, ...]:
    """A diameter from so many measured points."""
    import numpy as np

    words = scan_words(points, folder, workers)
    turn = 2 * np.pi * np.arange(points) / points
    rows = np.column_stack([25 * np.cos(turn), 25 * np.sin(turn), 0 * turn])
    np.savetxt(
        folder / "points.csv", rows, fmt="bore,%.6f,%.6f,%.6f", header="feature,x_mm,y_mm,z_mm", comments=""
    )
    return ("evaluate", words[1], "--points", str(folder / "points.csv"), *words[2:])


def parameter_words(inputs: int, folder: Path, workers: int) -> tuple[str, ...]:
    """Six error curves along X, each known at its nodes, errors of neighbours correlated."""
    table_of(inputs, folder)
    return ("uncertainty", str(folder / "ring.toml"), "--trials", "100000", "--json")


WORDS: dict[str, Callable[[int, Path, int], tuple[str, ...]]] = {
    "trials": trials_words,
    "scan": scan_words,
    "measured": measured_words,
    "parameters": parameter_words,
}


def grown(name: str, sizes: list[int], workers: int) -> None:
    """Print a row of every size, after one of a small job; of trials also one of a small job with compiled kernels loaded."""
    small = SMALL if name != "parameters" else 12
    print(
        f"| {name} | s to wait | caller, s | busiest worker, s | MB, largest process | MB without files of libraries |"
    )
    print("|---|---|---|---|---|---|")
    rows = [(f"{size:,}", size, workers, VCMM) for size in (small, *sizes)]
    if name == "trials":
        rows.insert(1, (f"{small:,}, kernels loaded", small, 1, LOADED))
    for title, size, hands, program in rows:
        with tempfile.TemporaryDirectory() as folder:
            os.environ["XDG_CACHE_HOME"] = folder  # finished blocks of an earlier call would be taken from it
            run = watched(WORDS[name](size, Path(folder), hands), program=program)
        print(
            f"| {title} | {run.wait:.1f} | {run.caller:.1f} | {run.worker:.1f} | {run.memory:.0f} | {run.private:.0f} |",
            flush=True,
        )


def per_trial(points: int, trials: int) -> Callable[[], float]:
    """Seconds of the processor of so many trials more, in this process: fits and certificates cancel out."""
    import vcmm

    with tempfile.TemporaryDirectory() as folder:
        path = Path(folder) / "ring.toml"
        path.write_text(ring_text(points))
        scenario = vcmm.load_scenario(path)

    def seconds(n: int) -> float:
        start = time.process_time()
        vcmm.uncertainty(scenario, trials=n, engine="montecarlo")
        return time.process_time() - start

    return lambda: seconds(2 * trials) - seconds(trials)


def points_compared(trials: int = 1_000_000) -> bool:
    """Interleaved pairs; the cheapest of each, since other work only makes them dearer."""
    jobs = {n: per_trial(n, trials) for n in POINTS}
    for job in jobs.values():
        job()
    found: dict[int, list[float]] = {n: [] for n in POINTS}
    for _ in range(PAIRS):
        for n, job in jobs.items():
            found[n].append(job())
    best = {n: sorted(each)[len(each) // 2] / trials for n, each in found.items()}
    for n, one in best.items():
        print(f"a trial with {n:,} points: {1e9 * one:.0f} ns of the processor (median of {PAIRS} pairs)")
    ratio = best[POINTS[1]] / best[POINTS[0]]
    print(f"ratio {ratio:.2f}, bar {POINTS_BAR}")
    return ratio <= POINTS_BAR


def main() -> int:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--only", choices=("points", "threads", *WORDS), required=True)
    parser.add_argument("--sizes", default="")
    parser.add_argument("--workers", type=int, default=1)
    given = parser.parse_args()
    good = True
    if given.only == "points":
        good = points_compared()
    elif given.only == "threads":
        from benchmarks.bench_montecarlo import threads_told

        good = threads_told()
    else:
        sizes = [int(n) for n in (given.sizes or SIZES[given.only]).split(",")]
        grown(given.only, sizes, given.workers)
    load, day = os.getloadavg()[0], time.strftime("%d %B %Y")
    print(json.dumps({"load": round(load, 1), "cores": os.cpu_count(), "date": day}))
    return 0 if good else 1


if __name__ == "__main__":
    sys.exit(main())
