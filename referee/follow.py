"""How often `vcmm track` is right: forecast bands, false alarms, changes found and named, on machines of referee/fleet.py.

    python -m referee.follow FOLDER --machines 20 --quiet      bands and false alarms
    python -m referee.follow FOLDER --machines 20              changes: found within two checks that see them, named rightly

Bands: after the checks of 90, 180 and 270 days the forecast of every number 7, 30 and 90 days after the last check is held against the truth of
that day: the ends of the curves (slope times travel; the bow is zero there) and the squareness. Machines are drawn independently, numbers of one machine
are not: the interval of the share is that of the shares of machines.
"""

import argparse
import json
from pathlib import Path

import numpy as np

from referee.files import call
from referee.fleet import LENGTH, NAMES, write_machine

CUTS = (90, 180, 270, 365)
NUMBERS = {
    "component_table[EXX].values": (0, LENGTH * 1e3),
    "component_table[EYY].values": (1, LENGTH * 1e3),
    "component_table[EZZ].values": (2, LENGTH * 1e3),
    "squareness[C0Y].angle": (6, 1e6),
    "squareness[B0Z].angle": (7, 1e6),
    "squareness[A0Z].angle": (8, 1e6),
}
SEEN_BY = {"C0Y": "c", "B0Z": "b", "A0Z": "a", "EXX": "sX", "EYY": "sY", "EZZ": "sZ"}


def follow(folder, seed, events, every):
    """One machine followed to the end in four calls: its last document, what its forecasts held, what happened to it."""
    folder = Path(folder) / f"machine_{seed:02d}"
    theta, told = write_machine(folder / "all", seed, events, every)
    (folder / "checks").mkdir(parents=True, exist_ok=True)
    for name in ("machine.toml", "errors.csv"):
        (folder / name).write_text((folder / "all" / name).read_text())
    bands, document = [], None
    for cut in CUTS:
        for path in sorted((folder / "all" / "checks").iterdir()):
            if int(path.name[:3]) <= cut and not (folder / "checks" / path.name).exists():
                (folder / "checks" / path.name).write_text(path.read_text())
        document = call(folder, "track", "machine.toml", "checks", "--out", "out", "--no-explain")
        last = max(int(c["recording"][:3]) for c in document["checks"])
        for one in document["forecast"]:
            number, scale = NUMBERS[one["input"]]
            day = last + int(one["days"])
            if day < len(theta):
                away = abs(one["value"] - theta[day][number] * scale) / one["u"]
                bands.append({"days": int(one["days"]), "inside": bool(away < 1.96), "input": one["input"]})
    return document, bands, told


def judge_changes(document, told):
    """Of every change: found by an alarm within the first two checks after it, and its first name that of the number."""
    checks = document["checks"]
    out = []
    for day, kind, number in told:
        after = [c for c in checks if int(c["recording"][:3]) >= day][:2]
        hit = [c for c in after if c["alarm"]]
        first = hit[0]["changed"][0]["name"] if hit and hit[0]["changed"] else ""
        named = any(place in first and NAMES[number] == name for place, name in SEEN_BY.items())
        out.append({"kind": kind, "found": bool(hit), "named": named, "said": first})
    return out


def false_alarms(document, told):
    """Alarms that are no change within the two checks before them."""
    checks = document["checks"]
    true = set()
    for day, _, _ in told:
        true |= {c["recording"] for c in [c for c in checks if int(c["recording"][:3]) >= day][:2]}
    return sum(c["alarm"] and c["recording"] not in true for c in checks)


def share(values):
    """Mean over machines of their shares, and its standard uncertainty."""
    values = np.array(values, dtype=float)
    return float(values.mean()), float(values.std(ddof=1) / np.sqrt(len(values))) if len(
        values
    ) > 1 else np.nan


def count(folder, machines, events, every):
    rows = []
    for seed in range(machines):
        document, bands, told = follow(folder, seed, events, every)
        row = {
            "seed": seed,
            "bands": bands,
            "false": false_alarms(document, told),
            "changes": judge_changes(document, told),
        }
        rows.append(row)
        print(json.dumps({k: v for k, v in row.items() if k != "bands"}), flush=True)
        (Path(folder) / "rows.json").write_text(json.dumps(rows))
    return rows


def summary(rows):
    """Lines of figures."""
    lines = [
        f"{len(rows)} machines, {sum(r['false'] for r in rows)} false alarms, at most {max(r['false'] for r in rows)} on one"
    ]
    for days in (7, 30, 90):
        per = [[b["inside"] for b in r["bands"] if b["days"] == days] for r in rows]
        mean, u = share([np.mean(p) for p in per if p])
        lines.append(
            f"95 % band {days} d after the last check holds {mean:.3f} +- {u:.3f} of {sum(map(len, per))}"
        )
    changes = [c for r in rows for c in r["changes"]]
    for kind in sorted({c["kind"] for c in changes}):
        own = [c for c in changes if c["kind"] == kind]
        found, named = sum(c["found"] for c in own), sum(c["named"] for c in own)
        lines.append(f"{kind}: {found} of {len(own)} found within two checks, {named} named rightly")
    return lines


if __name__ == "__main__":
    words = argparse.ArgumentParser(description=__doc__)
    words.add_argument("folder", type=Path)
    words.add_argument("--machines", type=int, default=2)
    words.add_argument("--every", type=int, default=7)
    words.add_argument("--quiet", action="store_true", help="no collisions and no new encoder")
    given = words.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    print("\n".join(summary(count(given.folder, given.machines, not given.quiet, given.every))))
