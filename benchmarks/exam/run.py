"""The exam's command line: builds cases, puts them to `vcmm diagnose --json`, scores, prints and writes.

python -m benchmarks.exam --block A --cases 40 --seed 5 --jobs 2 --budget 10min --out results.json
"""

from __future__ import annotations

import argparse
import json
import re
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from concurrent.futures import ThreadPoolExecutor
from dataclasses import dataclass
from pathlib import Path
from typing import Any

from benchmarks.exam import baselines, blocks, heldout
from benchmarks.exam.kinema import Errors
from benchmarks.exam.observe import Hidden, observed, tip_motion
from benchmarks.exam.score import confusion_text, score, summarise


@dataclass(frozen=True)
class Job:
    block: str
    seed: int
    number: int
    delta: float
    rows: int | None
    keep: Path | None
    rivals: bool
    reuse: bool = False
    improve: bool = False


def residual(case: blocks.Case):
    """Observed less what the machine file predicts."""
    d, m = case.design, case.machine
    six = {a: m.stored(a, d.q[a]) for a in m.kind.linear}
    predicted = observed(d, tip_motion(d, Errors(six, m.square)), Hidden())
    return case.values - predicted


def diagnose(
    recording: Path, seed: int, out: Path | None = None, limit: float = 900.0
) -> tuple[dict[str, Any], float]:
    """The product's own command, in a process of its own. Raises RuntimeError with its words when it refuses."""
    start = time.perf_counter()
    start_it = "import sys; from vcmm.cli import main; sys.exit(main())"
    command = [sys.executable, "-c", start_it, "diagnose", str(recording), "--seed", str(seed), "--json"]
    command += ["--out", str(out)] if out else []
    done = subprocess.run(command, capture_output=True, text=True, timeout=limit, check=False)
    if done.returncode not in (0, 1):
        raise RuntimeError(f"exit {done.returncode}: {done.stderr.strip()[-600:]}")
    return json.loads(done.stdout), time.perf_counter() - start


def run_case(job: Job) -> dict[str, Any]:
    with tempfile.TemporaryDirectory() as scratch:
        folder = (job.keep or Path(scratch)) / f"{job.block}-{job.seed}-{job.number}"
        case = blocks.build(job.block, job.seed, job.number, folder, job.delta, job.rows)
        if job.keep:
            (folder / "truth.json").write_text(json.dumps(case.truth.summary(), indent=1))
        try:
            found, seconds = _answer(job, case.recording)
        except (RuntimeError, subprocess.TimeoutExpired) as wrong:
            return {**case.truth.summary(), "error": str(wrong), "seconds": None}
        if job.keep:
            (folder / "found.json").write_text(json.dumps(found | {"exam_seconds": seconds}, indent=1))
        row = score(case.truth, found, seconds)
        better = folder / "out" / "machine.toml"
        if job.improve and row.get("right") and better.exists():
            row["new_recording_energy_left"] = heldout.energy_left(case, better, folder / "new")
        if job.rivals:
            row["baselines"] = baselines.all_names(case.design, residual(case))
        return row


def _answer(job: Job, recording: Path) -> tuple[dict[str, Any], float]:
    """The answer, or the one kept from an earlier run when only the scoring is wanted again."""
    kept = recording.parent / "found.json"
    if job.reuse and kept.exists():
        found = json.loads(kept.read_text())
        return found, float(found.get("exam_seconds", 0.0))
    return diagnose(recording, job.seed, recording.parent / "out" if job.improve else None)


def seconds_of(text: str) -> float:
    """'10min' -> 600. Raises ValueError for other words."""
    found = re.fullmatch(r"([0-9.]+) ?(s|min|h)", text)
    if not found:
        raise ValueError(f'--budget "{text}": write a number and s, min or h, such as 10min')
    return float(found[1]) * {"s": 1, "min": 60, "h": 3600}[found[2]]


def run_block(jobs: Sequence[Job], workers: int, budget: float) -> list[dict[str, Any]]:
    """Rows of the cases that fit into the budget, in order; no case is started after it."""
    end = time.monotonic() + budget
    rows: list[dict[str, Any]] = []

    def one(job: Job) -> dict[str, Any] | None:
        return run_case(job) if time.monotonic() < end else None

    with ThreadPoolExecutor(workers) as pool:
        for row in pool.map(one, jobs):
            if row is not None:
                rows.append(row)
                print(line_of(row), file=sys.stderr, flush=True)
    return rows


def line_of(row: dict[str, Any]) -> str:
    what = "+".join(f"{c['effect']}{list(c['where'].values())}" for c in row["concealed"]) or "nothing"
    head = f"{row['block']} {row['seed']} {row['case']} {row['design']} {row['world']} | {what} -> "
    if row.get("error"):
        return head + "ERROR " + row["error"].replace("\n", " ")[-300:]
    mark = row.get("right", row.get("flagged", not row["anything"]))
    said = (
        ", ".join(f"{n}{list((w or {}).values())}" for n, w in zip(row["answered"], row["where"]))
        or "nothing"
    )
    return (
        head
        + f"{said} | {row['verdict']} | mistake {row['mistake']} | unknown {bool(row['unknown'])} | {'ok' if mark else 'MISS'} {row['seconds']:.0f} s"
    )


def numbers_of(text: str) -> list[int]:
    """'40' -> 0..39, '7,9' -> 7 and 9, '20-29' -> 20..29."""
    if text.isdigit():
        return list(range(int(text)))
    out: list[int] = []
    for word in text.split(","):
        low, _, high = word.partition("-")
        out += range(int(low), int(high or low) + 1)
    return out


def main(arguments: Sequence[str] | None = None) -> int:
    parser = argparse.ArgumentParser(prog="python -m benchmarks.exam", description=__doc__)
    parser.add_argument("--block", default="A", help="letters of the blocks, such as AB (A B C D E F G H M)")
    parser.add_argument("--cases", default="40", help="how many, or which: 40 | 7,9 | 20-29 | 7-7")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--delta", type=float, default=None, help="default 10; 15 in block E")
    parser.add_argument(
        "--rows", type=int, default=None, help="rows per recording; default: that of the design"
    )
    parser.add_argument("--jobs", type=int, default=1)
    parser.add_argument("--budget", default="10min", help="no case is started later than this, per block")
    parser.add_argument(
        "--keep", type=Path, default=None, help="folder that keeps recordings, truths and answers"
    )
    parser.add_argument(
        "--reuse", action="store_true", help="score the answers kept in --keep, ask for none anew"
    )
    parser.add_argument(
        "--improve", action="store_true", help="judge the improved machine file on a new recording"
    )
    parser.add_argument("--no-baselines", action="store_true")
    parser.add_argument("--out", type=Path, default=None)
    a = parser.parse_args(arguments)
    everything: dict[str, Any] = {"schema": "vcmm.exam/1", "version": 1, "seed": a.seed, "blocks": {}}
    for block in a.block:
        delta = a.delta or (15.0 if block == "E" else 10.0)
        jobs = [
            Job(block, a.seed, n, delta, a.rows, a.keep, not a.no_baselines, a.reuse, a.improve)
            for n in numbers_of(a.cases)
        ]
        rows = run_block(jobs, a.jobs, seconds_of(a.budget))
        summary = summarise(rows)
        everything["blocks"][block] = {"delta": delta, "summary": summary, "cases": rows}
        print(f"block {block}, delta {delta:g}, {len(rows)} cases")
        print(json.dumps({k: v for k, v in summary.items() if k != "confusion"}, indent=1))
        print(confusion_text(summary["confusion"]))
        if a.out:
            a.out.write_text(json.dumps(everything, indent=1, allow_nan=False, default=str))
    return 0
