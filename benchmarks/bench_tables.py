"""Reading recordings of very many rows: seconds of the processor and memory. python benchmarks/bench_tables.py [--rows 1000000] [--parquet]

A recording of touches with eight columns of numbers and a label is written and read (`load_recording`, with the history of the
axes); each in a process of its own, whose largest memory is told less that of the imports.
"""

from __future__ import annotations

import argparse
import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np

ROOT = Path(__file__).resolve().parents[1]
RECORDING = 'vcmm = "recording/1"\nname = "r"\nmachine = "machine.toml"\ndata = "{}"\nkind = "probe"\n'
MACHINE = 'vcmm = "machine/1"\nname = "m"\nstructure = "w b Y X Z t"\n' + "".join(
    f'[axes.{a}]\ntravel = ["-1 m", "1 m"]\n' for a in "XYZ"
)
NAMES = ("time_s", "X_mm", "Y_mm", "Z_mm", "nx", "ny", "nz", "d_um")
READ = """
import json, resource, sys, time
sys.path.insert(0, sys.argv[1])
from vcmm.files.own.recording import load_recording
before, start = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss, time.process_time()
found, _ = load_recording(sys.argv[2])
used = resource.getrusage(resource.RUSAGE_SELF).ru_maxrss
print(json.dumps([found.run.n, time.process_time() - start, (used - before) / 1e3]))
"""


def write(folder: Path, rows: int, parquet: bool) -> Path:
    """The recording file; its data in pieces, so that this process stays small."""
    name = f"data.{'parquet' if parquet else 'csv'}"
    (folder / "machine.toml").write_text(MACHINE)
    (folder / "recording.toml").write_text(RECORDING.format(name))
    rng, normals = np.random.default_rng(0), np.eye(3)
    pieces = [(at, min(100_000, rows - at)) for at in range(0, rows, 100_000)]

    def table(at: int, n: int) -> np.ndarray:
        normal = normals[rng.integers(0, 3, n)]
        return np.column_stack(
            [np.arange(at, at + n), rng.uniform(-500, 500, (n, 3)), normal, rng.normal(0, 1, n)]
        )

    if parquet:
        import pyarrow as pa
        from pyarrow import parquet as pq

        writer = None
        for at, n in pieces:
            one = pa.table({**dict(zip(NAMES, table(at, n).T)), "pose": ["a"] * n})
            writer = writer or pq.ParquetWriter(folder / name, one.schema)
            writer.write_table(one)
        assert writer is not None
        writer.close()
        return folder / "recording.toml"
    with (folder / name).open("w") as file:
        file.write(",".join((*NAMES, "pose")) + "\n")
        again: list[str] = []  # the same 100 000 rows at other times: writing is not what is counted
        for at, n in pieces:
            if n != len(again):
                again = lines_of(table(at, n)[:, 1:])
            file.writelines(f"{at + k},{row}\n" for k, row in enumerate(again))
    return folder / "recording.toml"


def lines_of(table: np.ndarray) -> list[str]:
    from io import StringIO

    text = StringIO()
    np.savetxt(text, table, fmt="%.6g", delimiter=",", newline=",a\n")
    return text.getvalue().splitlines()


def main() -> None:
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawTextHelpFormatter)
    parser.add_argument("--rows", default="100000,1000000")
    parser.add_argument("--parquet", action="store_true")
    given = parser.parse_args()
    print("| rows | file MB | processor s | memory MB |\n|---|---|---|---|")
    for rows in map(int, given.rows.split(",")):
        with tempfile.TemporaryDirectory() as folder:
            path = write(Path(folder), rows, given.parquet)
            size = max(p.stat().st_size for p in Path(folder).iterdir()) / 1e6
            asked = [sys.executable, "-c", READ, str(ROOT), str(path)]
            done = subprocess.run(asked, capture_output=True, text=True, check=False)
        if done.returncode:
            print(f"| {rows:,} | {size:.0f} | not read: {done.stderr.strip().splitlines()[-1][:200]} | |")
            continue
        n, seconds, memory = json.loads(done.stdout)
        assert n == rows
        print(f"| {rows:,} | {size:.0f} | {seconds:.1f} | {memory:.0f} |", flush=True)


if __name__ == "__main__":
    main()
