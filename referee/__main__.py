"""``python -m referee``: counts cells into a file, one line of JSON per row, and prints the table."""

import argparse
import json
import subprocess
import sys
import tempfile
import time
from concurrent.futures import ProcessPoolExecutor, as_completed
from fnmatch import fnmatch
from pathlib import Path

from referee import count, further
from referee.cells import all_cells
from referee.table import brief, markdown

KINDS = {
    "evaluate": count.evaluate,
    "decide": count.decide,
    "uncertainty": count.beforehand,
    "monotone": further.monotone,
    "place": further.place,
}


def commit() -> str:
    """Short name of the commit that is judged."""
    words = ["git", "rev-parse", "--short", "HEAD"]
    done = subprocess.run(words, cwd=Path(__file__).parent, capture_output=True, text=True, check=False)
    return done.stdout.strip() or "unknown"


def run(cell: str, parts: int, seed: int, mark: str, keep: str | None) -> list[dict]:
    """All rows of one cell; a cell that fails has one row with what was said."""
    began = time.perf_counter()
    with tempfile.TemporaryDirectory() as passing:
        folder = Path(keep) / cell.replace("/", "-") if keep else Path(passing)
        folder.mkdir(parents=True, exist_ok=True)
        try:
            rows = KINDS[cell.split("/")[0]](folder, seed, cell, parts)
        except Exception as error:  # what goes wrong in one cell must not stop the others
            rows = [{"characteristic": "", "n": 0, "failed": f"{type(error).__name__}: {error}"}]
    kind, task, family, machine = cell.split("/")
    seconds = round(time.perf_counter() - began, 1)
    common = {"cell": cell, "kind": kind, "task": task, "family": family, "machine": machine}
    common |= {"parts": parts, "seed": seed, "commit": mark, "seconds": seconds}
    return [common | row for row in rows]


def done_cells(path: Path, parts: int, seed: int) -> set[str]:
    """Cells that the file already holds with as many parts and this seed; failed ones are run again."""
    if not path.exists():
        return set()
    rows = [json.loads(line) for line in path.read_text().splitlines() if line.strip()]
    return {r["cell"] for r in rows if r["parts"] >= parts and r["seed"] == seed and "failed" not in r}


def main(words: list[str] | None = None) -> int:
    """Run the command line."""
    parser = argparse.ArgumentParser(prog="referee", description=__doc__)
    parser.add_argument("--cells", default="*", help="pattern; several with commas")
    parser.add_argument("--parts", type=int, default=400)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--out", default="referee.jsonl")
    parser.add_argument("--shard", default="1/1", help="i/n: every n-th cell, beginning with the i-th")
    parser.add_argument("--keep", help="folder that keeps the files of every cell")
    parser.add_argument("--list", action="store_true", help="name the cells and stop")
    parser.add_argument("--table", metavar="FILE", help="print the table of a file and stop")
    parser.add_argument(
        "--brief", metavar="FILE", help="print the table of a page, with fewer columns, and stop"
    )
    chosen = parser.parse_args(words)
    if chosen.table or chosen.brief:
        print(markdown(Path(chosen.table)) if chosen.table else brief(Path(chosen.brief)))
        return 0
    part, of = (int(v) for v in chosen.shard.split("/"))
    patterns = chosen.cells.split(",")
    cells = [c for c in all_cells() if any(fnmatch(c, p) for p in patterns)][part - 1 :: of]
    if chosen.list:
        print("\n".join(cells))
        return 0
    path = Path(chosen.out)
    cells = [c for c in cells if c not in done_cells(path, chosen.parts, chosen.seed)]
    mark = commit()
    if chosen.jobs == 1:
        for cell in cells:
            write(path, run(cell, chosen.parts, chosen.seed, mark, chosen.keep))
        return 0
    with ProcessPoolExecutor(chosen.jobs) as pool:
        waiting = [pool.submit(run, c, chosen.parts, chosen.seed, mark, chosen.keep) for c in cells]
        for done in as_completed(waiting):
            write(path, done.result())
    return 0


def write(path: Path, rows: list[dict]) -> None:
    """Add the rows of a finished cell to the file, all or none."""
    with path.open("a") as file:
        file.write("".join(json.dumps(row) + "\n" for row in rows))
    last = rows[-1]
    print(f"{last['cell']}  {last['seconds']} s  {last.get('failed', '')}", file=sys.stderr, flush=True)


if __name__ == "__main__":
    sys.exit(main())
