"""One digest per document of every job: what a change of the house must leave alone, to the last bit.

    python tools/identity.py write before.json              # 300 documents; with VCMM_DATA also recordings and NC corpora
    python tools/identity.py write after.json --shard 1/2   # every second document; put together by `compare`
    python tools/identity.py compare before.json after.json [more.json]

Each document has two digests: of its text, and of its keys and numbers alone (words left out), so that a change of
words can be told from a change of results. `compare` exits 1 where a result differs, names it, and lists documents whose
words alone differ. What differs from run to run (version, times, paths) is blanked.
"""

from __future__ import annotations

import argparse
import hashlib
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile
import time
from collections.abc import Iterator
from dataclasses import dataclass
from pathlib import Path
from typing import Any

ROOT = Path(__file__).resolve().parents[1]
SCENARIOS = ROOT / "scenarios"
PROGRAM = Path(sys.executable).with_name("vcmm")
SECONDS = 300  # a document that takes longer is an error
FEW = ("--trials", "4000")
NUMBER = re.compile(r"[-+]?\d+(?:\.\d+)?(?:[eE][-+]?\d+)?")
PASSING = ("version", "seconds", "elapsed_s", "created", "date", "python", "platform")  # keys that may differ


@dataclass(frozen=True)
class Case:
    """One command, run in a copy of the scenarios; `files` are read after it beside what it prints."""

    name: str
    words: tuple[str, ...]
    files: tuple[str, ...] = ()


def main() -> int:
    """Returns 1 where results differ."""
    parser = argparse.ArgumentParser(
        description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter
    )
    verbs = parser.add_subparsers(dest="verb", required=True)
    write = verbs.add_parser("write")
    write.add_argument("file", type=Path)
    write.add_argument("--shard", default="1/1")
    write.add_argument("--only", default="", help="cases whose name holds this")
    compare = verbs.add_parser("compare")
    compare.add_argument("before", type=Path)
    compare.add_argument("after", type=Path, nargs="+")
    asked = parser.parse_args()
    if asked.verb == "write":
        return write_digests(asked.file, asked.shard, asked.only)
    after = {k: v for path in asked.after for k, v in json.loads(path.read_text()).items()}
    return compare_digests(json.loads(asked.before.read_text()), after)


def write_digests(file: Path, shard: str, only: str) -> int:
    """Run the cases of a shard and write their digests; goes on where it stopped. Returns 1 where a case ended with exit 70."""
    number, of = (int(x) for x in shard.split("/"))
    chosen = [c for i, c in enumerate(cases()) if i % of == number - 1 and only in c.name]
    done: dict[str, Any] = json.loads(file.read_text()) if file.exists() else {}
    for i, case in enumerate(chosen):
        if case.name in done:
            continue
        start = time.monotonic()
        done[case.name] = digest_of(case)
        file.write_text(json.dumps(done, indent=0, sort_keys=True))
        print(f"{i + 1}/{len(chosen)} {case.name}: exit {done[case.name]['exit']}, {time.monotonic() - start:.1f} s", file=sys.stderr, flush=True)  # fmt: skip
    bad = sorted(name for name, d in done.items() if d["exit"] not in (0, 1, 2))
    print(f"{len(done)} documents, {len(bad)} ended otherwise than done or refused: {bad}")
    return 1 if bad else 0


def compare_digests(before: dict[str, Any], after: dict[str, Any]) -> int:
    """Print what differs; 1 where an exit code, a key or a number does, or where a document is missing."""
    missing = sorted(set(before) ^ set(after))
    both = sorted(set(before) & set(after))
    results = [n for n in both if any(before[n][k] != after[n][k] for k in ("exit", "numbers"))]
    words = [n for n in both if n not in results and before[n]["text"] != after[n]["text"]]
    for title, names in (
        ("missing on one side", missing),
        ("RESULT differs", results),
        ("words alone differ", words),
    ):
        for name in names:
            print(f"{title}: {name}")
    print(
        f"{len(both)} compared: {len(results)} results differ, {len(words)} in words alone, {len(missing)} missing"
    )
    return 1 if results or missing else 0


# --- what is run ---


def cases() -> list[Case]:
    """All documents; those of recordings and NC programs need VCMM_DATA."""
    return [*_of_scenarios(), *_of_commands(), *_refusals(), *_of_data()]


def _of_scenarios() -> Iterator[Case]:
    for path in sorted(SCENARIOS.glob("*.toml")):
        text, name, file = path.read_text(encoding="utf-8"), path.stem, path.name
        yield Case(f"check {name}", ("check", file, "--json"))
        if "[plan" not in text and "[cut" not in text:
            continue
        cut = "[cut" in text
        verb = "cut" if cut else "uncertainty"
        yield Case(f"{verb} {name}", (verb, file, *FEW, "--json"))
        yield Case(f"{verb} {name} seed 7", (verb, file, *FEW, "--seed", "7", "--json"))
        yield Case(f"{verb} {name} in words", (verb, file, *FEW))
        yield Case(
            f"{verb} {name} page", (verb, file, *FEW, "--out", "out"), ("out/report.html", "out/budget.csv")
        )
        yield Case(f"measure {name}", ("measure", file, "--json"))
        yield Case(
            f"measure {name} drawn",
            ("measure", file, "--seed", "3", "--out", "out", "--json"),
            ("out/points.csv",),
        )
        if not cut:
            yield Case(
                f"uncertainty {name} montecarlo", (verb, file, "--engine", "montecarlo", *FEW, "--json")
            )
            yield Case(
                f"uncertainty {name} exact", (verb, file, "--engine", "exact", "--trials", "60", "--json")
            )
            yield Case(f"routes {name}", ("routes", file, "--trials", "2000", "--json"))
            yield Case(f"audit {name}", ("audit", file, "--parts", "30", "--json"))
            yield Case(
                f"place {name}",
                ("place", file, "--evaluations", "60", "--scan", "32", "--trials", "1000", "--json"),
            )


def _of_commands() -> Iterator[Case]:
    for what in (
        "scenarios",
        "effects",
        "features",
        "strategies",
        "characteristics",
        "laws",
        "aliases",
        "units",
    ):
        yield Case(f"list {what}", ("list", what, "--json"))
    listed = subprocess.run(
        [str(PROGRAM), "list", "effects", "--json"], capture_output=True, text=True, check=True
    )
    for item in json.loads(listed.stdout)["items"]:
        yield Case(f"explain {item['effect']}", ("explain", item["effect"]))
    for kind in ("machine", "scenario", "recording", "setup", "design"):
        yield Case(f"schema {kind}", ("schema", kind))
    for machine in sorted(SCENARIOS.glob("*/machine.toml")):
        where = machine.relative_to(SCENARIOS).as_posix()
        yield Case(f"field {where}", ("field", where, "--json"))
        yield Case(f"field {where} exact", ("field", where, "--exact", "--nodes", "3", "--json"))
    for table in ("isg", "linuxcnc", "heidenhain"):
        yield Case(
            f"table {table}",
            ("compensate", "worn_cmm/machine.toml", "--table", table, "--out", "out", "--json"),
            ("out/*",),
        )
    for program in sorted(SCENARIOS.glob("*/*.nc")):
        where, setup = program.relative_to(SCENARIOS).as_posix(), program.with_name("setup.toml")
        yield Case(f"nc {where}", ("nc", where, "--setup", setup.relative_to(SCENARIOS).as_posix(), "--json"))
        yield Case(f"compensate {where}", ("compensate", where, "--setup", setup.relative_to(SCENARIOS).as_posix(), "--out", "new.nc", "--json"), ("new.nc",))  # fmt: skip
    yield Case(
        "evaluate measured_block",
        ("evaluate", "measured_block.toml", "--points", "measured_block/points.csv", *FEW, "--json"),
    )
    yield Case("cut measured_block measured", ("cut", "measured_block.toml", "--measured", "measured_block/points.csv", *FEW, "--out", "out", "--json"), ("out/*.toml", "out/*.csv"))  # fmt: skip
    for file in ("worn_cmm.toml", "ballbar.toml", "traced_cmm/warm_up.toml"):
        yield Case(f"diagnose {file}", ("diagnose", file, "--json", "--out", "out"), ("out/machine.toml",))
    yield Case("calibrate traced_cmm", ("calibrate", "traced_cmm.toml", "--structure", "w b X Y Z t", "--out", "out", "--json"), ("out/*.toml", "out/*.csv"))  # fmt: skip
    track = ("track", "tracked_mill/machine.toml", "tracked_mill/checks")
    plan = (
        "--task",
        "tracked_mill.toml",
        "--limit",
        "length = 2 um",
        "--checks",
        "tracked_mill/checks.toml",
        "--days",
        "30",
    )
    yield Case(
        "track tracked_mill",
        (*track, "--out", "out", "--json"),
        ("out/*.toml", "out/*.csv", "out/track.json"),
    )
    yield Case("track tracked_mill plan", (*track, *plan, "--json"))
    yield Case(
        "track tracked_mill parts",
        (*track, "--task", "tracked_mill.toml", "--parts", "tracked_mill/parts.csv", "--json"),
    )
    yield Case("track tracked_mill at", (*track, "--at", "2027-02-01", "--json"))
    yield Case("demo", ("demo", "--json"))


def _refusals() -> Iterator[Case]:
    """Every scenario with one line spoilt, ten ways: messages with exit 2 (or an answer) that must not change."""
    for path in sorted(SCENARIOS.glob("*.toml")):
        lines = path.read_text(encoding="utf-8").splitlines()
        holding = [i for i, line in enumerate(lines) if "=" in line and not line.startswith("#")]
        for k in range(6):
            if len(holding) <= k:
                continue
            i = holding[(k * 7919) % len(holding)]
            key, _, value = lines[i].partition("=")
            spoilt = {
                0: f"{key}x={value}",
                1: f'{key}= "?"',
                2: f"{key}= [",
                3: f"{key}= -1e400",
                4: "",
                5: f"{key}= true",
            }[k]
            yield Case(f"refusal {path.stem} {k}", ("check", f"{path.name}:{i}:{spoilt}"))


def _of_data() -> Iterator[Case]:
    data = os.environ.get("VCMM_DATA")
    if not data:
        return
    base = Path(data) / "data"
    for folder in ("recordings_2", "recordings_3"):
        for file in sorted((base / folder).glob("*/*.toml")):
            if re.search(r"^data *=", file.read_text(encoding="utf-8"), re.M):
                yield Case(f"diagnose {folder}/{file.parent.name}/{file.name}", ("diagnose", str(file), "--json", "--out", "out"), ("out/machine.toml", "out/errors.csv"))  # fmt: skip
                yield Case(
                    f"compare {folder}/{file.parent.name}/{file.name}", ("compare", str(file), "--json")
                )
    programs = [
        p for f in ("nc", "nc_public") for p in sorted((base / f).rglob("*")) if p.suffix.lower() in ENDINGS
    ]
    for folder in sorted({p.parent for p in programs}):
        yield Case(f"nc folder {folder.relative_to(base)}", ("nc", str(folder), "--json"))
    for program in programs[::4]:
        yield Case(f"nc {program.relative_to(base)}", ("nc", str(program), "--json"))
    for file in sorted((base / "formats").rglob("*")):
        if file.suffix.lower() in (".qif", ".xml", ".stp"):
            yield Case(
                f"convert {file.name}",
                ("convert", str(file), "--out", "out", "--json"),
                ("out/*.toml", "out/*.csv"),
            )


ENDINGS = (".nc", ".ngc", ".mpf", ".spf", ".h", ".i", ".tap", ".gcode", ".cnc", ".min", ".eia", ".txt")


# --- how it is digested ---


def digest_of(case: Case) -> dict[str, Any]:
    """{"exit", "text", "numbers"}: exit code, digest of the document, digest of its keys and numbers."""
    with tempfile.TemporaryDirectory() as at:
        folder = Path(at) / "work"
        shutil.copytree(SCENARIOS, folder)
        words = list(case.words)
        if case.name.startswith("refusal "):
            file, line, spoilt = words[1].split(":", 2)
            lines = (folder / file).read_text(encoding="utf-8").splitlines()
            lines[int(line)] = spoilt
            (folder / file).write_text("\n".join(lines) + "\n", encoding="utf-8")
            words[1] = file
        program = [str(PROGRAM), *words]
        around = os.environ | {
            "PYTHONPATH": str(ROOT),
            "COLUMNS": "100",
            "NO_COLOR": "1",
            "PYTHONHASHSEED": "0",
        }
        try:
            run = subprocess.run(program, cwd=folder, env=around, capture_output=True, text=True, timeout=SECONDS, check=False)  # fmt: skip
        except subprocess.TimeoutExpired:
            return {"exit": -1, "text": "", "numbers": ""}
        texts = [run.stdout if run.returncode != 2 else run.stderr]
        for pattern in case.files:
            for path in sorted(folder.glob(pattern)):
                texts.append(path.name + "\n" + path.read_text(encoding="utf-8", errors="replace"))
        whole = "\n".join(_blank(t, at) for t in texts)
    return {"exit": run.returncode, "text": _sha(whole), "numbers": _sha(_numbers(whole))}


def _blank(text: str, folder: str) -> str:
    """The text without what differs from run to run; JSON in one order of keys."""
    text = text.replace(os.path.realpath(folder), "").replace(folder, "").replace(str(ROOT), "")
    try:
        return json.dumps(_without(json.loads(text)), sort_keys=True, ensure_ascii=False)
    except ValueError:
        return re.sub(
            r"\b\d{4}-\d\d-\d\d(?:[T ]\d\d:\d\d(?::\d\d)?)?|vcmm \d[\w.+]*|\b\d+(\.\d+)? s\b", "", text
        )


def _without(value: Any) -> Any:
    if isinstance(value, dict):
        return {k: _without(v) for k, v in value.items() if k not in PASSING}
    return [_without(v) for v in value] if isinstance(value, list) else value


def _numbers(text: str) -> str:
    """Keys and numbers of a JSON document; of another text its numbers in order."""
    head, _, rest = text.partition("\n")
    try:
        value = json.loads(head)
    except ValueError:
        return " ".join(NUMBER.findall(text))
    return json.dumps(_bare(value), sort_keys=True) + " ".join(NUMBER.findall(rest))


def _bare(value: Any) -> Any:
    """A document without its words: a text becomes the numbers in it."""
    if isinstance(value, dict):
        return {k: _bare(v) for k, v in value.items()}
    if isinstance(value, list):
        return [_bare(v) for v in value]
    return NUMBER.findall(value) if isinstance(value, str) else value


def _sha(text: str) -> str:
    return hashlib.sha256(text.encode("utf-8")).hexdigest()[:20]


if __name__ == "__main__":
    sys.exit(main())
