"""Rows of a recording against time, memory and what is found:

    python benchmarks/bench_rows.py [--rows 500,1000,...] [--names N] [--log 100000,1000000]

Each size is a process of its own: processor seconds of all threads, wall seconds and the largest memory, imports included. The
exponent is the slope of ln seconds over ln rows. --names N puts N concealed effects to the search of all rows at once and to the
screened one, and to one of half the rows, and compares the answers. --log: `vcmm diagnose` of an axis that goes to and fro for a day,
so many rows in a CSV file (ten columns), with a backlash and a screw of 10 mm concealed; reading included.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
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
    from tests.learn.diagnosis import generator as make

    return make.make((name,) if name else (), delta, seed, replace(make.RICH, n=rows))


def answers(name: str, rows: int, seed: int, nulls: int = 2000) -> tuple[str, ...]:
    from tests.learn.diagnosis import generator as make
    from vcmm.learn.diagnosis.engine import diagnose_recording

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


LOG = (
    'vcmm = "recording/1"\nname = "day"\nmachine = "machine.toml"\ndata = "data.csv"\nkind = "displacement"\n'
    '[noise]\nu = "0.5 um"\n[nuisance]\nzero = "setup"\n'
)
DAY = 86_400.0  # s
CYCLES = 201.7  # no whole number of rows each, so that places do not repeat


def write_log(folder: Path, rows: int) -> None:
    """CYCLES times 800 mm to and fro; 0.6 um lost at every reversal, 0.4 um of the screw, 0.5 um of noise."""
    from benchmarks.bench_tables import MACHINE

    (folder / "machine.toml").write_text(MACHINE)
    (folder / "recording.toml").write_text(LOG)
    rng, names = np.random.default_rng(1), "time_s,X_mm,Y_mm,Z_mm,nx,ny,nz,temp_scale_x_C,d_um,setup"
    with (folder / "data.csv").open("w") as file:
        file.write(names + "\n")
        for at in range(0, rows, 100_000):
            time_s = np.arange(at, min(at + 100_000, rows)) * (DAY / rows)
            phase = (time_s * (CYCLES / DAY)) % 1.0
            there = phase < 0.5
            x = np.where(there, -400 + 1600 * phase, 1200 - 1600 * phase)
            air = 20 + 1.5 * np.sin(2 * np.pi * time_s / DAY) + 0.05 * rng.standard_normal(len(x))
            d = (
                np.where(there, 0.3, -0.3)
                + 0.4 * np.sin(2 * np.pi * x / 10)
                + 0.5 * rng.standard_normal(len(x))
            )
            word = np.where(time_s < DAY / 2, "a", "b")
            file.writelines(
                f"{t:.4f},{q:.4f},100,-50,1,0,0,{w:.2f},{e:.3f},{s}\n"
                for t, q, w, e, s in zip(time_s, x, air, d, word)
            )


def logged(rows: int) -> None:
    """A row of the table: `vcmm diagnose` in a process of its own."""
    code = (
        "import os, resource, sys; os.environ.setdefault('OPENBLAS_NUM_THREADS', '1'); sys.path.insert(0, sys.argv[1]); sys.argv = ['vcmm', 'diagnose', sys.argv[2], '--json']; from vcmm.face.cli import run;"
        " code = run(sys.argv[1:]); use = resource.getrusage(resource.RUSAGE_SELF);"
        " print(code, use.ru_utime + use.ru_stime, use.ru_maxrss / 1e3, file=sys.stderr)"
    )
    with tempfile.TemporaryDirectory() as folder:
        write_log(Path(folder), rows)
        size = (Path(folder) / "data.csv").stat().st_size / 1e6
        words = [sys.executable, "-c", code, str(ROOT), f"{folder}/recording.toml"]
        done = subprocess.run(words, capture_output=True, text=True, check=False)
    code, seconds, memory = done.stderr.strip().splitlines()[-1].split()
    said = json.loads(done.stdout) if code == "0" else {"answer": [], "searched": {"of": 0}}
    names = ", ".join(f"{a['effect']} {' '.join(a['where'].values())}" for a in said["answer"])
    print(f"| {rows:,} | {size:.0f} | {said['searched']['of']:,} | {float(seconds):.1f} | {float(memory):.0f} | {names or done.stderr} |", flush=True)  # fmt: skip


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
            with mock.patch.multiple("vcmm.learn.diagnosis.engine", SCREENED=screen, LARGEST=largest):
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
    parser.add_argument("--log", default="", help="rows of a day of an axis, diagnosed by the command")
    args = parser.parse_args()
    start = time.perf_counter()
    if args.log:
        print("| rows | file MB | taken | processor s | memory MB | found |\n|---|---|---|---|---|---|")
        for rows in map(int, args.log.split(",")):
            logged(rows)
    elif args.names:
        agreement(args.names)
    else:
        growth([int(n) for n in args.rows.split(",")])
    print(f"{time.perf_counter() - start:.0f} s")


if __name__ == "__main__":
    main()
