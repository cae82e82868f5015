"""A year of daily checks followed at once, and one more recording the day after: python benchmarks/bench_track.py [--count 300]

The recordings are those of referee/fleet.py: probed grids (36 rows each time that they are read, three times by default), and a ball bar of 72 rows every tenth.
Each is the whole command as a shop calls it, start of Python, page and documents included. Wall time
and processor time of the command: on a machine with other work the second is what an idle one takes at most.
"""

from __future__ import annotations

import argparse
import os
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

import numpy as np

from referee.fleet import date_of, draw_year, machine_text, write_bar, write_probe


def write_year(folder: Path, count: int, times: int) -> int:
    """`count` recordings of a year: grids, each place read `times` times, and a ball bar every tenth; rows of all."""
    rng = np.random.default_rng([33, 300])
    (folder / "checks").mkdir(parents=True)
    text, tables = machine_text("a year")
    (folder / "machine.toml").write_text(text)
    (folder / "errors.csv").write_text(tables)
    theta, _ = draw_year(rng, True)
    rows = 0
    for number in range(count):
        day = number * 365 // count
        name = f"{number:03d}"
        if number % 10 == 9:
            write_bar(folder / "checks", name, date_of(day), theta[day], rng)
            rows += 72
            continue
        write_probe(folder / "checks", name, date_of(day), theta[day], rng, times)
        rows += 36 * times
    return rows


def timed(folder: Path) -> tuple[float, float]:
    """Wall and processor time of `vcmm track` in a folder, s."""
    before, start = os.times(), time.perf_counter()
    command = [
        str(Path(sys.executable).parent / "vcmm"),
        "track",
        "machine.toml",
        "checks",
        "--no-explain",
        "--json",
    ]
    done = subprocess.run(command, cwd=folder, capture_output=True, text=True, check=False)
    if done.returncode not in (0, 1):
        raise RuntimeError(done.stderr)
    after = os.times()
    used = after.children_user + after.children_system - before.children_user - before.children_system
    return time.perf_counter() - start, used


def main(count: int, times: int) -> None:
    with tempfile.TemporaryDirectory() as name:
        folder = Path(name)
        rows = write_year(folder, count + 1, times)
        kept = [folder / "checks" / f"{count:03d}{end}" for end in (".toml", ".csv")]
        for path in kept:
            shutil.move(path, folder / path.name)
        wall, used = timed(folder)
        print(f"{count} recordings, {rows} rows: {wall:.1f} s of wall time, {used:.1f} s of processor time")
        for path in kept:
            shutil.move(folder / path.name, path)
        wall, used = timed(folder)
        print(f"one more recording: {wall:.1f} s of wall time, {used:.1f} s of processor time")
        print(f"load of this machine: {os.getloadavg()[0]:.1f} on {os.cpu_count()} cores")


if __name__ == "__main__":
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("--count", type=int, default=300)
    words.add_argument("--rows", type=int, default=3, help="how often each place of a grid is read")
    given = words.parse_args()
    main(given.count, given.rows)
