"""How time grows with the size of a job: points, inputs, trials, rows, program lines. One command draws all curves.

    python benchmarks/bench_growth.py [--out docs/images/growth.png] [--only points,rows] [--small]

Seconds of the processor, the smaller of two runs, imports and kernels left out. The exponent is the slope of ln seconds over ln
size between the last two sizes, where what does not grow counts least. Bar: 1.15.
"""

from __future__ import annotations

import argparse
import math
import tempfile
import time
from collections.abc import Callable
from pathlib import Path

import numpy as np

BAR = 1.15
Job = Callable[[], object]
RING = "ring_gauge"


def ring_of(points: int, folder: Path) -> Job:
    """The uncertainty of a diameter by so many touches, 10^5 trials."""
    import vcmm
    from vcmm.files.own.library import example

    text = example(RING).read_text().replace("n = 16 ", f"n = {points} ")
    (folder / "ring.toml").write_text(text)
    scenario = vcmm.load_scenario(folder / "ring.toml")
    return lambda: vcmm.uncertainty(scenario, trials=100_000)


def table_of(inputs: int, folder: Path) -> Job:
    """The same with six error curves along X, each known at its nodes, errors of neighbours correlated."""
    import vcmm
    from vcmm.files.own.library import example

    rows = [
        f"{x:.6f}" + " 0.0001" * 3 + " 0.000001" * 3 for x in np.linspace(0, 700, max(2, round(inputs / 6)))
    ]
    (folder / "errors.csv").write_text("\n".join(["X EXX EYX EZX EAX EBX ECX", *rows]) + "\n")
    known = '[machine.errors]\ntable = "errors.csv"\nuncertainty = { translation = "0.3 um", rotation = "1 urad", squareness = "1 urad", correlation_length = "150 mm" }\n[machine.repeatability]'
    text = example(RING).read_text().replace("[machine.repeatability]", known, 1)
    (folder / "ring.toml").write_text(text)
    return lambda: vcmm.uncertainty(vcmm.load_scenario(folder / "ring.toml"), trials=10_000)


def trials_of(trials: int, folder: Path) -> Job:
    """A diameter by 16 touches."""
    import vcmm
    from vcmm.files.own.library import example

    scenario = vcmm.load_scenario(example(RING))
    return lambda: vcmm.uncertainty(scenario, trials=trials)


def rows_of(rows: int, folder: Path) -> Job:
    """A recording of touches with backlash concealed, diagnosed."""
    from benchmarks.bench_rows import answers

    return lambda: answers("backlash", rows, 7)


def read_of(lines: int, folder: Path) -> Job:
    """A program of straight blocks, read."""
    from vcmm.program.interpret import interpret

    text = program(lines)
    return lambda: interpret(text, "linuxcnc")


def compensated_of(lines: int, folder: Path) -> Job:
    """The same program rewritten for squareness, scale and straightness."""
    from benchmarks.bench_compensate import SETUP, machine
    from vcmm.compensation.job import compensate

    path = folder / f"{lines}.nc"
    path.write_text(program(lines))
    return lambda: compensate(path, SETUP, machine("all"), tolerance=0.005, decimals=6)


def program(lines: int) -> str:
    turn = np.linspace(0, 20 * math.pi, lines)
    ends = zip(200 * np.cos(turn), 200 * np.sin(turn), np.linspace(0, -20, lines))
    return "\n".join(
        ["G21 G90 G17 G54 F1000.", *(f"G1 X{x:.4f} Y{y:.4f} Z{z:.4f}" for x, y, z in ends), "M30"]
    )


JOBS: dict[str, tuple[Callable[[int, Path], Job], tuple[int, ...]]] = {
    "points of a circle": (ring_of, (100, 1000, 20_000, 200_000)),
    "inputs": (table_of, (12, 102, 1002, 10_002)),
    "trials": (trials_of, (100_000, 1_000_000, 10_000_000)),
    "rows of a recording": (rows_of, (500, 1000, 2000)),
    "lines read": (read_of, (1000, 10_000, 100_000)),
    "lines compensated": (compensated_of, (500, 2000, 8000)),
}


def seconds(job: Job) -> float:
    """The smaller of two runs; one where that is long."""
    best = math.inf
    for _ in range(2):
        start = time.process_time()
        job()
        best = min(best, time.process_time() - start)
        if best > 5.0:
            break
    return best


def exponent(sizes: list[int], found: list[float]) -> float:
    """Between the last two sizes."""
    return math.log(found[-1] / found[-2]) / math.log(sizes[-1] / sizes[-2])


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--out", type=Path, default=None, help="a picture of the curves")
    parser.add_argument("--only", default="", help="words of the curves wanted")
    parser.add_argument("--small", action="store_true", help="without the largest size of each")
    given = parser.parse_args()
    curves: dict[str, tuple[list[int], list[float]]] = {}
    print("| what grows | sizes | processor s | exponent |\n|---|---|---|---|")
    for name, (make, every) in JOBS.items():
        if given.only and not any(word in name for word in given.only.split(",")):
            continue
        sizes = list(every[:-1] if given.small else every)
        with tempfile.TemporaryDirectory() as folder:
            make(sizes[0], Path(folder))()  # imports, kernels
            found = [seconds(make(size, Path(folder))) for size in sizes]
        curves[name] = (sizes, found)
        shown = ", ".join(f"{n:,}" for n in sizes), ", ".join(f"{s:.3g}" for s in found)
        print(f"| {name} | {shown[0]} | {shown[1]} | {exponent(sizes, found):.2f} |", flush=True)
    if given.out:
        draw(curves, given.out)
    return int(any(exponent(*curve) > BAR for curve in curves.values()))


def draw(curves: dict[str, tuple[list[int], list[float]]], path: Path) -> None:
    import matplotlib

    matplotlib.use("agg")
    from matplotlib import pyplot as plt

    figure, ax = plt.subplots(figsize=(7.0, 4.5), layout="constrained")
    for name, (sizes, found) in curves.items():
        ax.loglog(sizes, found, "o-", label=f"{name}, exponent {exponent(sizes, found):.2f}")
    ends = np.array([1e3, 1e6])
    ax.loglog(ends, 2e-2 * (ends / 1e3), "k:", linewidth=1, label="in proportion")
    ax.set_xlabel("size")
    ax.set_ylabel("seconds of the processor")
    ax.legend(fontsize=8)
    figure.savefig(path, dpi=110)


if __name__ == "__main__":
    import sys

    sys.exit(main())
