"""Rows of a recording against time, memory and what is found: python benchmarks/bench_rows.py [--rows 500,1000,...] [--names N]

Each size is a process of its own: processor seconds of all threads, wall seconds and the largest memory, imports included. The
exponent is the slope of ln seconds over ln rows. --names N puts N concealed effects to the search of all rows at once and to the
screened one, and to one of half the rows, and compares the answers.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import time
from dataclasses import replace
from pathlib import Path
from typing import Any
from unittest import mock

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
sys.path.insert(0, str(ROOT))

ROWS = (500, 1000, 2000, 4000, 7000, 10_000)
CONCEALED = ("backlash", "squareness", "thermal_drift", "screw_pitch", "step_change", "probe_lobing", "scale_expansion", "part_expansion",
             "cross_axis_flexure", "hysteresis", "lost_motion", "trigger_delay", "geometric_change", "tip_form", "")  # fmt: skip


def made(name: str, rows: int, seed: int, delta: float = 10.0) -> Any:
    from tests.diagnosis import generator as make

    return make.make((name,) if name else (), delta, seed, replace(make.RICH, n=rows))


def answers(name: str, rows: int, seed: int, nulls: int = 2000) -> tuple[str, ...]:
    from tests.diagnosis import generator as make
    from vcmm.diagnosis.engine import diagnose_recording

    d = diagnose_recording(made(name, rows, seed).recording, make.machine(), 1, nulls)
    return (*(a.id for a in d.answer), *(["unknown"] if d.unknown else []))


def measured(rows: int) -> dict[str, float]:
    """One diagnosis in a process of its own."""
    code = (
        "import json, resource, sys, time; sys.path.insert(0, sys.argv[1]); from benchmarks.bench_rows import answers; start = time.perf_counter();"
        f" said = answers('backlash', {rows}, 7); use = resource.getrusage(resource.RUSAGE_SELF);"
        " print(json.dumps({'said': said, 'wall': time.perf_counter() - start, 'seconds': use.ru_utime + use.ru_stime, 'mb': use.ru_maxrss / 1e3}))"
    )
    done = subprocess.run([sys.executable, "-c", code, str(ROOT)], capture_output=True, text=True, check=True)
    return dict(json.loads(done.stdout))


def exponent(rows: list[int], seconds: list[float]) -> float:
    return float(np.polyfit(np.log(rows), np.log(seconds), 1)[0])


def growth(rows: list[int]) -> None:
    print("| rows | processor s | wall s | memory MB | found |")
    print("|---|---|---|---|---|")
    seconds = []
    for n in rows:
        one: dict[str, Any] = measured(n)
        seconds.append(one["seconds"])
        print(
            f"| {n} | {one['seconds']:.1f} | {one['wall']:.1f} | {one['mb']:.0f} | {', '.join(one['said'])} |",
            flush=True,
        )
    print(f"\nexponent of the processor time over all rows {exponent(rows, seconds):.2f}")


def agreement(count: int, rows: int = 1200) -> None:
    """The same recordings: all rows at once; candidates screened in a third of them; names searched in half and fitted to all."""
    print("| concealed | all rows | screened in a third | searched in half |")
    print("|---|---|---|---|")
    same = np.zeros(2)
    for k in range(count):
        name = CONCEALED[k % len(CONCEALED)]
        said = []
        for screen, largest in ((10**9, 10**9), (rows // 3, 10**9), (10**9, rows // 2)):
            with mock.patch.multiple("vcmm.diagnosis.engine", SCREENED=screen, LARGEST=largest):
                said.append(answers(name, rows, 40 + k, 500))
        same += [said[0] == s for s in said[1:]]
        print(
            f"| {name or 'nothing'} | " + " | ".join(", ".join(s) or "nothing" for s in said) + " |",
            flush=True,
        )
    print(
        f"\nthe same names and places: screened {same[0]:.0f} of {count}, half the rows {same[1]:.0f} of {count}"
    )


def main() -> None:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--rows", default=",".join(map(str, ROWS)))
    parser.add_argument("--names", type=int, default=0, help="concealed effects whose answers are compared")
    args = parser.parse_args()
    start = time.perf_counter()
    if args.names:
        agreement(args.names)
    else:
        growth([int(n) for n in args.rows.split(",")])
    print(f"{time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
