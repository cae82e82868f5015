"""Does a test notice when a formula, a threshold or a guard is wrong? Breaks one place at a time and runs the tests.

    python tools/mutants.py --out /tmp/mutants [--seed 1] [--count 100] [--jobs 2] [--rooms placing,nc] [--limit-seconds 60]
    python tools/mutants.py --out /tmp/mutants --nearest --per-room 8 --others 4   # a sample of every room

Changes are drawn by seed from all rooms (`mutant_sites.py` says what counts and what is left out). Every test
is run once beforehand to see which functions it calls (`mutant_map.py`); a change is then put to the tests that call its
function, then to those that know its file, nearest and quickest first, until one fails or --limit-seconds of tests are spent.
--nearest does without that run: the sources say which tests name the function, or name what names it (`mutant_nearest.py`); the
nearest are asked first. What no test within the limit notices counts as survived. --per-room draws so many formulas of
every room, --others so many other changes, and the table says each room and the shares with their 95 % intervals (Clopper-Pearson).

Written to --out: mutants.md and mutants.csv (the table), results.jsonl (one line per change; a second run goes on from
there), and the copies of the tree in which the tests run; the working tree is left alone. Changes that no test can notice
because they change nothing that matters are listed with their reason in mutants_equivalent.toml.
"""

from __future__ import annotations

import argparse
import csv
import hashlib
import json
import os
import queue
import re
import shutil
import signal
import subprocess
import sys
import time
import tomllib
from collections import Counter
from collections.abc import Iterable, Iterator
from concurrent.futures import ThreadPoolExecutor
from itertools import count, islice, zip_longest
from pathlib import Path
from typing import Any

from scipy.stats import beta

sys.path.insert(0, str(Path(__file__).resolve().parent))

from mutant_map import Coverage
from mutant_nearest import Nearest
from mutant_sites import Site, shown, sites
from mutant_trees import Copy, copied, end_workers

ROOT = Path(__file__).resolve().parents[1]
ROOMS = [
    "core",
    "physics",
    "part",
    "program",
    "task",
    "answer",
    "shop",
    "compensation",
    "learn",
    "files",
    "show",
    "face",
]
FIRST, START = 3.0, 2.0  # s: tests of the first batch; what a batch costs beyond its tests
_unfit: set[str] = set()  # tests that fail alone, without any change
_stamp = count(
    int(time.time()) + 1000
)  # a new time of change for every broken file, so that no bytecode is mistaken for it


def main() -> None:
    options = _options()
    options.out.mkdir(parents=True, exist_ok=True)
    copies = [copied(options.out, k) for k in range(options.jobs)]
    for copy in copies if options.nearest else ():
        copy.start()
    coverage = Nearest(ROOT) if options.nearest else _coverage(copies[0], options)
    if options.per_room:
        many = (options.seed, options.per_room, options.others)
        of_rooms = [sample(*many, room) for room in options.rooms or ROOMS]
        chosen = [site for turn in zip_longest(*of_rooms) for site in turn if site is not None]
    else:
        chosen = drawn(options.seed, options.count, options.rooms)
    known = {r["key"]: r for r in _results(options.out)}
    for copy in copies if options.nearest else ():
        copy.ready()
    left = [site for site in chosen if site.key not in known]
    free: queue.Queue[Copy] = queue.Queue()
    for copy in copies:
        free.put(copy)

    end = time.monotonic() + 60.0 * options.minutes

    def judged(site: Site) -> None:
        if time.monotonic() > end:
            return
        copy = free.get()
        try:
            _keep(options.out, _judged(copy, coverage, site, options.limit_seconds))
        finally:
            free.put(copy)

    with ThreadPoolExecutor(options.jobs) as pool:
        list(pool.map(judged, left))
    end_workers()
    known = {r["key"]: r for r in _results(options.out)}
    _tables(options.out, [known[site.key] for site in chosen if site.key in known])


def _options() -> argparse.Namespace:
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    parser.add_argument("--out", type=Path, required=True)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--count", type=int, default=100)
    parser.add_argument("--jobs", type=int, default=2)
    parser.add_argument(
        "--rooms", type=lambda text: tuple(text.split(",")), default=(), help="such as placing,nc"
    )
    parser.add_argument("--limit-seconds", type=float, default=60.0, help="of computing by tests, per change")
    parser.add_argument(
        "--keep-map",
        action="store_true",
        help="use the record of the tests in --out though files have changed",
    )
    parser.add_argument("--minutes", type=float, default=1e6, help="begin no change after so long")
    parser.add_argument("--tests", default="tests", help="what is run once for the map")
    parser.add_argument(
        "--nearest", action="store_true", help="no map: the tests that the sources show to be nearest"
    )
    parser.add_argument("--per-room", type=int, default=0, help="so many changes of formulas of every room")
    parser.add_argument("--others", type=int, default=0, help="with --per-room: so many other changes of it")
    return parser.parse_args()


def drawn(seed: int, number: int, rooms: tuple[str, ...]) -> list[Site]:
    """So many changes, every place as likely as any other; one that is not touched keeps its rank when others change."""
    return list(islice(_different(_ranked(seed, rooms)), number))


def sample(seed: int, formulas: int, others: int, room: str) -> list[Site]:
    """So many formulas and so many other changes of a room, every place of either class as likely as any other; the
    classes take turns, so that a run that is ended early has an even sample too."""
    ranked = _ranked(seed, (room,))
    first = islice(_different(place for place in ranked if place.formula), formulas)
    second = islice(_different(place for place in ranked if not place.formula), others)
    turns = sorted(
        [((k + 0.5) / formulas, site) for k, site in enumerate(first)]
        + [((k + 0.5) / others, site) for k, site in enumerate(second)],
        key=lambda turn: turn[0],
    )
    return [site for _, site in turns]


def _ranked(seed: int, rooms: tuple[str, ...]) -> list[Site]:
    """All places in an order drawn by seed."""
    files = sorted(p.relative_to(ROOT).as_posix() for p in (ROOT / "vcmm").rglob("*.py"))
    if rooms:
        files = [f for f in files if f.startswith(tuple(f"vcmm/{room}/" for room in rooms))]
    places = [site for file in files for site in sites(ROOT, file)]
    seen: Counter[str] = Counter()

    def rank(site: Site) -> str:
        name = "|".join((str(seed), site.file, site.owner, site.kind, site.before, site.after))
        seen[name] += 1
        return hashlib.sha256(f"{name}|{seen[name]}".encode()).hexdigest()

    return sorted(places, key=rank)


def _different(places: Iterable[Site]) -> Iterator[Site]:
    """Changes that parse and mean something to the parser, each once."""
    keys = set()
    for place in places:
        site = shown(ROOT, place)
        if site is not None and site.key not in keys:
            keys.add(site.key)
            yield site


def _coverage(copy: Copy, options: argparse.Namespace) -> Coverage:
    """What every test calls; run once for a state of package and tests."""
    every = sorted(p for d in ("vcmm", "tests") for p in (copy.folder / d).rglob("*.py"))
    state = hashlib.sha256(options.tests.encode() + b"".join(p.read_bytes() for p in every)).hexdigest()
    record = options.out / "map"
    mark = record / "state"
    if not (mark.exists() and (options.keep_map or mark.read_text() == state)):
        shutil.rmtree(record, ignore_errors=True)
        record.mkdir()
        print("running all tests once, to see what they call ...", flush=True)
        arguments = [
            *options.tests.split(),
            "-p",
            "mutant_map",
            "-n",
            str(options.jobs),
            "--dist",
            "loadscope",
            "--maxfail=1000",
        ]
        done = copy.run(arguments, 7200, VCMM_MUTANT_MAP=str(record.resolve()))
        print(done.stdout[-2000:])
        mark.write_text(state)
    return Coverage.read(ROOT, record)


# ---------------------------------------------------------------------- one change


def _judged(copy: Copy, coverage: Coverage | Nearest, site: Site, limit: float) -> dict[str, Any]:
    """The change put to the tests: the one that noticed it, or "" and what was tried."""
    begin = time.perf_counter()
    tests = [t for t in coverage.noticing(site.file, site.owner) if t not in _unfit]
    by, tried = _broken(copy, coverage, site, tests, limit)
    while isinstance(coverage, Nearest) and "::" in by and not _passes_unbroken(copy, site, by):
        _unfit.add(by.split("[")[0])
        tests = [t for t in tests if t not in _unfit]
        by, tried = _broken(copy, coverage, site, tests, limit)
    return {
        "key": site.key, "file": site.file, "line": site.line, "owner": site.owner, "kind": site.kind, "formula": site.formula,
        "before": site.before_line, "after": site.after_line, "noticed": by, "tried": tried, "possible": len(tests),
        "seconds": round(time.perf_counter() - begin, 1),
    }  # fmt: skip


def _broken(
    copy: Copy, coverage: Coverage | Nearest, site: Site, tests: list[str], limit: float
) -> tuple[str, int]:
    """What `_noticed` says with the file broken, which is mended afterwards."""
    path = copy.folder / site.file
    source, times = path.read_bytes(), path.stat()
    path.write_bytes(site.applied(source))
    stamp = next(_stamp)
    os.utime(path, (stamp, stamp))
    try:
        return _noticed(copy, coverage, site, tests, limit)
    finally:
        path.write_bytes(source)
        os.utime(path, ns=(times.st_atime_ns, times.st_mtime_ns))


def _passes_unbroken(copy: Copy, site: Site, test: str) -> bool:
    """Whether a test that failed passes without the change: one that needs others to run first does not, and notices nothing."""
    return not _failed(copy.fork(site, [test], 120) or copy.run([test], 120), [test])


def _noticed(
    copy: Copy, coverage: Coverage | Nearest, site: Site, tests: list[str], limit: float
) -> tuple[str, int]:
    """(the test that failed, tests that were run), in batches of growing length within the limit.

    What no test notices in a fork is put to the first batch once more in a process of its own, since the fork has
    what modules compute at import from before the change.
    """
    at, spent, size, first, forked = 0, 0.0, FIRST, 0, isinstance(coverage, Nearest)
    while at < len(tests) and spent < limit:
        batch, expected = [], 0.0
        while at < len(tests) and (
            not batch or expected + coverage.seconds[tests[at]] <= min(size, limit - spent)
        ):
            batch.append(tests[at])
            expected += coverage.seconds[tests[at]]
            at += 1
        done = copy.fork(site, batch, int(30.0 + 6.0 * expected)) if forked else None
        forked = done is not None
        by = _failed(done or copy.run(batch, int(30.0 + 6.0 * expected)), batch)
        if by:
            return by, at
        spent, size, first = spent + expected + START, size * 3.0, first or at
    return _failed(copy.run(tests[:first], 120), tests[:1]) if forked else "", at


def _failed(done: subprocess.CompletedProcess[str], batch: list[str]) -> str:
    """The test that failed, or how the tests ended otherwise; "" where all passed."""
    if done.returncode == -signal.SIGXCPU:
        return f"no end ({batch[0]} ...)"
    if done.returncode in (0, 5):
        return ""
    found = re.search(r"^(?:FAILED|ERROR) (\S+)", done.stdout, re.MULTILINE)
    return found[1] if found else f"pytest ends with {done.returncode}"


# ---------------------------------------------------------------------- what is written


def _results(out: Path) -> list[dict[str, Any]]:
    file = out / "results.jsonl"
    return (
        [json.loads(line) for line in file.read_text(encoding="utf-8").splitlines()] if file.exists() else []
    )


def _keep(out: Path, result: dict[str, Any]) -> None:
    with (out / "results.jsonl").open("a", encoding="utf-8") as file:
        file.write(json.dumps(result) + "\n")
    print(
        f"{result['file']}:{result['line']} {result['seconds']} s: {result['noticed'] or 'SURVIVED'}",
        flush=True,
    )


def equivalents() -> list[dict[str, str]]:
    """file, after (a fragment of the changed line) and reason of every change that means nothing."""
    file = ROOT / "tools" / "mutants_equivalent.toml"
    return tomllib.loads(file.read_text(encoding="utf-8")).get("equivalent", [])


def _verdict(result: dict[str, Any]) -> str:
    if result["noticed"]:
        return str(result["noticed"])
    for one in equivalents():
        if one["file"] == result["file"] and one["after"] in result["after"]:
            return f"equivalent: {one['reason']}"
    more = (
        "" if result["tried"] == result["possible"] else f" of {result['possible']}, the rest took too long"
    )
    return (
        f"**survived** ({result['tried']} tests{more})"
        if result["possible"]
        else "**survived** (no test calls it)"
    )


def _tables(out: Path, results: list[dict[str, Any]]) -> None:
    rows = [
        [f"{r['file']}:{r['line']}", f"`{r['before']}`", f"`{r['after']}`", r["kind"], "formula" if r["formula"] else "other", _verdict(r)]
        for r in sorted(results, key=lambda r: (not r["formula"], r["file"], r["line"]))
    ]  # fmt: skip
    titles = ["place", "before", "after", "kind", "class", "noticed by"]
    with (out / "mutants.csv").open("w", newline="", encoding="utf-8") as file:
        csv.writer(file).writerows([titles, *rows])
    lines = [
        "| " + " | ".join(cell.replace("|", "\\|") for cell in row) + " |"
        for row in [titles, ["---"] * 6, *rows]
    ]
    text = _summary(rows) + "\n\n" + _by_room(rows) + "\n\n" + "\n".join(lines) + "\n"
    (out / "mutants.md").write_text(text, encoding="utf-8")
    print(_summary(rows))


def _by_room(rows: list[list[str]]) -> str:
    """Of every room: formulas and other changes that matter, how many were noticed, and changes that mean nothing."""
    lines = ["| room | formulas | noticed | others | noticed | mean nothing |", "|---|---|---|---|---|---|"]
    for room in ROOMS:
        of_room = [row for row in rows if row[0].startswith(f"vcmm/{room}/")]
        (formulas, seen, same), (others, too, also) = (_counted(of_room, c) for c in ("formula", "other"))
        if of_room:
            lines.append(f"| {room} | {formulas} | {seen} | {others} | {too} | {same + also} |")
    return "\n".join(lines)


def _counted(rows: list[list[str]], name: str) -> tuple[int, int, int]:
    """(changes that matter, noticed, changes that mean nothing) of a class."""
    verdicts = [row[5] for row in rows if row[4] == name]
    survived = sum(v.startswith("**survived**") for v in verdicts)
    same = sum(v.startswith("equivalent") for v in verdicts)
    return len(verdicts) - same, len(verdicts) - survived - same, same


def interval(seen: int, number: int) -> tuple[float, float]:
    """Clopper-Pearson, 95 %: shares that would give so many or so few with 2.5 % each (Biometrika 26 (1934) 404)."""
    low = float(beta.ppf(0.025, seen, number - seen + 1)) if seen else 0.0
    return low, float(beta.ppf(0.975, seen + 1, number - seen)) if seen < number else 1.0


def _summary(rows: list[list[str]]) -> str:
    said = []
    for name in ("formula", "other"):
        number, seen, same = _counted(rows, name)
        low, high = interval(seen, number)
        said.append(f"{name}: {seen} of {number} noticed ({low:.3f} to {high:.3f}), {same} more mean nothing")
    return "; ".join(said)


if __name__ == "__main__":
    main()
