"""The exam's command line: builds cases, puts them to `vcmm diagnose --json`, scores, prints and writes.

python -m benchmarks.exam --block A --cases 40 --seed 5 --jobs 2 --budget 10min --out results.jsonl
python -m benchmarks.exam --plan overnight --seed 5 --jobs 2 --budget 10h --out night.jsonl    # or --cluster tcp://scheduler:8786
python -m benchmarks.exam summarise results.jsonl night.jsonl
"""

from __future__ import annotations

import argparse
import json
import re
import sys
import tempfile
import time
import traceback
from collections.abc import Callable, Iterable, Iterator, Sequence
from dataclasses import dataclass, replace
from pathlib import Path
from typing import Any

from benchmarks.exam import addon, asking, baselines, blocks, cost, folds, heldout, plans, results
from benchmarks.exam.addon_rows import NotPossible
from benchmarks.exam.kinema import Errors
from benchmarks.exam.observe import Hidden, observed, tip_motion
from benchmarks.exam.score import score, summarise
from benchmarks.exam.tables import pages
from vcmm.core.crew import Crew, crew_of
from vcmm.face.job import share_of


@dataclass(frozen=True)
class Job:
    """One case and what is done with it. improve, follow: blocks J and F on further recordings; fresh: a process of its own."""

    block: str
    seed: int
    number: int
    delta: float
    rows: int | None
    keep: Path | None
    rivals: bool
    reuse: bool = False
    improve: bool = False
    follow: bool = False
    fresh: bool = False

    @property
    def key(self) -> results.Key:
        return (self.block, self.seed, self.number, self.delta, self.rows)


def residual(case: blocks.Case):
    """Observed less what the machine file predicts."""
    d, m = case.design, case.machine
    six = {a: m.stored(a, d.q[a]) for a in m.kind.linear}
    predicted = observed(d, tip_motion(d, Errors(six, m.square)), Hidden())
    return case.values - predicted


def run_case(job: Job) -> dict[str, Any]:
    """All that is known of one case, as plain values. A case that fails, here or in the command, is a row with its words."""
    start = time.process_time()
    asked = {"delta_asked": job.delta, "rows_asked": job.rows}
    with tempfile.TemporaryDirectory() as scratch:
        folder = (job.keep or Path(scratch)) / f"{job.block}-{job.seed}-{job.number}-{job.delta:g}"
        told = {
            "block": job.block,
            "seed": job.seed,
            "case": job.number,
            "design": "",
            "world": "",
            "concealed": [],
        }
        try:
            case = blocks.build(job.block, job.seed, job.number, folder, job.delta, job.rows)
            told = case.truth.summary()
            row = asked_and_scored(job, case, folder)
        except Exception as wrong:
            where = "" if isinstance(wrong, RuntimeError) else traceback.format_exc()[-600:]
            row = {**told, "error": f"{type(wrong).__name__}: {wrong} {where}".strip(), "seconds": None}
    return row | asked | {"processor_s": time.process_time() - start}


def asked_and_scored(job: Job, case: blocks.Case, folder: Path) -> dict[str, Any]:
    if job.keep:
        (folder / "truth.json").write_text(json.dumps(case.truth.summary(), indent=1))
    found, seconds = _answer(job, case.recording)
    if job.keep:
        (folder / "found.json").write_text(json.dumps(found | {"exam_seconds": seconds}, indent=1))
    row = score(case.truth, found, seconds)
    if row["unknown"]:  # its curve or map is long and scores nothing
        row["unknown"] = {k: v for k, v in row["unknown"].items() if k != "shape"}
    return row | _more(job, case, found, row, folder)


def _answer(job: Job, recording: Path) -> tuple[dict[str, Any], float]:
    """The answer, or the one kept from an earlier run when only the scoring is wanted again."""
    kept = recording.parent / "found.json"
    if job.reuse and kept.exists():
        found = json.loads(kept.read_text())
        return found, float(found.get("exam_seconds", 0.0))
    out = recording.parent / "out" if job.improve else None
    return asking.diagnose(recording, job.seed, out, fresh=job.fresh)


def _more(
    job: Job, case: blocks.Case, found: dict[str, Any], row: dict[str, Any], folder: Path
) -> dict[str, Any]:
    """What goes beyond the answer itself: folds, an improved machine, the next measurement, plain methods, cost."""
    more: dict[str, Any] = {"rows": case.design.rows, "version": found.get("version")}
    better = folder / "out" / "machine.toml"
    parts: dict[str, Callable[[], Any]] = {}
    if job.block in "AD":
        parts["folds"] = lambda: folds.judged(case, found)
    if job.block == "E":
        parts["covariates"] = lambda: list(case.truth.items[0].covariates)
    if job.improve and better.exists() and row.get("exact" if job.block == "D" else "right"):
        parts["new_recording_energy_left"] = lambda: heldout.energy_left(case, better, folder / "new")
    if job.follow:
        parts["next"] = lambda: followed(job, case, found, folder / "next")
    if job.rivals:
        parts["baselines"] = lambda: baselines.all_names(case.design, residual(case))
    if job.block == "M":
        parts["cost"] = lambda: cost.cost(case.recording, job.seed)
    for word, make in parts.items():
        try:
            more[word] = make()
        except (
            Exception
        ) as wrong:  # the answer itself is scored all the same; the words are printed with the tables
            more.setdefault("not_done", {})[word] = f"{type(wrong).__name__}: {wrong}"
    return more


def followed(job: Job, case: blocks.Case, found: dict[str, Any], folder: Path) -> dict[str, Any] | None:
    """The first proposal of the next measurement, taken and diagnosed; None where the first answer has no rivals."""
    if case.truth.invisible or not found["answer"] or not found["answer"][0].get("cannot_be_told_from"):
        return None
    step = addon.recommended(found)
    if step is None:
        return {"status": "none proposed"}
    said = {"do": step["do"], "minutes": step["minutes"], "separates": list(step["separates"])}
    change = addon.change_of(step["do"])
    if change is None:
        return {**said, "status": "not known to the exam"}
    try:
        recording = addon.write(case, change, folder)
    except NotPossible as why:
        return {**said, "status": f"not possible: {why}"}
    again, seconds = asking.diagnose(recording, job.seed)
    row = score(replace(case.truth, design=f"{case.truth.design} and add-on"), again, seconds)
    kept = ("answered", "sets", "set_size", "right", "in_set", "probabilities", "verdict", "seconds")
    return {**said, "status": "taken", **{k: row[k] for k in kept}}


def seconds_of(text: str) -> float:
    """'10min' -> 600. Raises ValueError for other words."""
    found = re.fullmatch(r"([0-9.]+) ?(s|min|h)", text)
    if not found:
        raise ValueError(f'--budget "{text}": write a number and s, min or h, such as 10min')
    return float(found[1]) * {"s": 1, "min": 60, "h": 3600}[found[2]]


def run_jobs(jobs: Iterable[Job], crew: Crew, budget: float, out: Path | None) -> list[dict[str, Any]]:
    """Rows of the cases that fit into the budget; no case is started after it. Each is written as soon as it is there."""
    seen = results.done(out)
    waiting = [job for job in jobs if job.key not in seen]
    done = crew(case_before, time.time() + budget, waiting)
    return [_kept(row, out) for _, row in done if row is not None]


def case_before(end: float, job: Job) -> dict[str, Any] | None:
    """One case, unless the time (s since 1970) is over."""
    return run_case(job) if time.time() <= end else None


def _kept(row: dict[str, Any], out: Path | None) -> dict[str, Any]:
    if out:
        results.append(out, row)
    print(line_of(row), file=sys.stderr, flush=True)
    return row


def line_of(row: dict[str, Any]) -> str:
    what = "+".join(f"{c['effect']}{list(c['where'].values())}" for c in row["concealed"]) or "nothing"
    head = f"{row['block']} {row['seed']} {row['case']} {row['design']} {row['world']} | {what} -> "
    if row.get("error"):
        return head + "ERROR " + row["error"].replace("\n", " ")[-300:]
    follow = (row.get("next") or {}).get("status", "")
    mark = row.get("right", row.get("flagged", not row["anything"]))
    word = "not visible" if mark is None or row["invisible"] else "ok" if mark else "MISS"
    said = (
        ", ".join(f"{n}{list((w or {}).values())}" for n, w in zip(row["answered"], row["where"]))
        or "nothing"
    )
    return (
        head
        + f"{said} | {row['verdict']} | mistake {row['mistake']} | unknown {bool(row['unknown'])} | {word} {row['seconds']:.0f} s"
        + (f" | next {follow}" if follow else "")
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


def jobs_of(a: argparse.Namespace) -> Iterator[tuple[str, list[Job]]]:
    """(heading, jobs): one heading per block asked for, or one for a whole plan."""

    def job(block: str, number: int, delta: float, rivals: bool) -> Job:
        follow = block == "F" and not a.no_next
        improve = a.improve or (bool(a.plan) and block in "AD" and delta >= 10)
        rivals = rivals and not a.no_baselines and block in "AB"
        return Job(block, a.seed, number, delta, a.rows, a.keep, rivals, a.reuse, improve, follow, a.fresh)

    if a.plan:
        yield f"plan {a.plan}", [job(*one) for one in plans.asked(a.plan)]
        return
    for block in a.block:
        delta = a.delta or (15.0 if block == "E" else 10.0)
        yield f"block {block}, delta {delta:g}", [job(block, n, delta, True) for n in numbers_of(a.cases)]


def parser() -> argparse.ArgumentParser:
    p = argparse.ArgumentParser(
        prog="python -m benchmarks.exam", description=__doc__, formatter_class=argparse.RawTextHelpFormatter
    )
    p.add_argument("--block", default="A", help="letters of the blocks, such as AB (A B C D E F G H M)")
    p.add_argument("--plan", choices=sorted(plans.PLANS), help="blocks in rounds, in place of --block")
    p.add_argument("--cases", default="40", help="how many, or which: 40 | 7,9 | 20-29 | 7-7")
    p.add_argument("--seed", type=int, default=1)
    p.add_argument("--delta", type=float, default=None, help="default 10; 15 in block E")
    p.add_argument("--rows", type=int, default=None, help="rows per recording; default: that of the design")
    p.add_argument("--jobs", type=int, default=1)
    p.add_argument(
        "--cluster", default=None, help="Dask scheduler whose workers take the cases, in place of --jobs"
    )
    p.add_argument(
        "--shard", default=None, help="one part of the cases only, such as 2/8; summarise takes all files"
    )
    p.add_argument("--budget", default="10min", help="no case is started later, per block or per plan")
    p.add_argument("--keep", type=Path, default=None, help="folder that keeps recordings, truths and answers")
    p.add_argument("--reuse", action="store_true", help="score the answers kept in --keep, ask for none anew")
    p.add_argument(
        "--improve", action="store_true", help="judge the improved machine file on a new recording"
    )
    p.add_argument("--no-next", action="store_true", help="block F without taking the next measurement")
    p.add_argument("--no-baselines", action="store_true", help="no plain methods on the cases of A and B")
    p.add_argument("--fresh", action="store_true", help="a process of its own for each answer")
    p.add_argument("--out", type=Path, default=None, help="one JSON line per case; cases in it are skipped")
    return p


def main(arguments: Sequence[str] | None = None) -> int:
    words = list(sys.argv[1:] if arguments is None else arguments)
    if words[:1] == ["summarise"]:
        print(pages(results.read([Path(w) for w in words[1:]])))
        return 0
    a = parser().parse_args(words)
    crew = crew_of(cluster=a.cluster) if a.cluster else crew_of(a.jobs)
    share = share_of(a.shard)
    for heading, jobs in jobs_of(a):
        rows = run_jobs(
            jobs[share.number - 1 :: share.of] if share else jobs, crew, seconds_of(a.budget), a.out
        )
        print(f"{heading}, {len(rows)} cases run")
        if rows and not a.plan:
            figures = {k: v for k, v in summarise(rows).items() if k != "confusion"}
            print(json.dumps(figures, indent=1))
        print(pages(results.read([a.out]) if a.out and a.out.exists() else rows))
    return 0
