"""How often `vcmm track` is right: forecast bands, false alarms, changes found and named, on machines of referee/fleet.py.

    python -m referee.follow FOLDER --machines 20 --quiet      bands and false alarms
    python -m referee.follow FOLDER --machines 20              changes: found within two checks that see them, named rightly

    python -m referee.follow FOLDER --again      the table from the rows that lie there

Bands: after the checks of 90, 180 and 270 days the forecast of every number 7, 30 and 90 days after the last check is held against the truth of
that day: the ends of the curves (slope times travel; the bow is zero there) and the squareness. A band says nothing of a jump to come: forecasts over one, after one that only a laser of another axis followed, and onto the one day of an open door, are counted apart. Machines are drawn
independently, numbers of one machine are not: the coverage interval of a share of bands is that of Student's t over the shares of machines; that of a
share of changes is exact (C. Clopper & E. Pearson, Biometrika 26 (1934) 404), and so is that of a rate of false alarms (F. Garwood, Biometrika 28 (1936) 437).
"""

import argparse
import json
import shutil
from pathlib import Path

import numpy as np
from scipy import stats

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
    shutil.rmtree(folder, ignore_errors=True)
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
        known = max(int(c["recording"][:3]) for c in document["checks"] if "laser" not in c["recording"])
        for one in document["forecast"]:
            number, scale = NUMBERS[one["input"]]
            day = last + int(one["days"])
            if day < len(theta):
                away = abs(one["value"] - theta[day][number] * scale) / one["u"]
                jump = any(
                    known < d <= day and n in (number, -1) and (n >= 0 or d == day) for d, _, n in told
                )
                bands.append(
                    {
                        "cut": cut,
                        "days": int(one["days"]),
                        "inside": bool(away < 1.96),
                        "input": one["input"],
                        "jump": jump,
                        "u": one["u"],
                        "away": float(away),
                    }
                )
    return document, bands, told


def checks_after(document, day, number):
    """Names of the first two checks after a change that can see it: a laser sees one slope only; an open door is seen on its day alone."""
    checks = [c["recording"] for c in document["checks"]]
    if number < 0:
        return [c for c in checks if int(c[:3]) == day]
    return [c for c in checks if int(c[:3]) >= day and "laser" not in c][:2]


def judge_changes(document, told):
    """Of every change: found by an alarm within the first two checks after it, and its first name that of the number."""
    alarms = {c["recording"]: c for c in document["checks"] if c["alarm"]}
    out = []
    for day, kind, number in told:
        hit = [alarms[c] for c in checks_after(document, day, number) if c in alarms]
        first = hit[0]["changed"][0]["name"] if hit and hit[0]["changed"] else ""
        if number < 0:
            named = first.startswith("everything")
        else:
            named = any(place in first and NAMES[number] == name for place, name in SEEN_BY.items())
        out.append({"kind": kind, "found": bool(hit), "named": named, "said": first})
    return out


def false_alarms(document, told):
    """Alarms that are no change within the two checks before them; the check after an open door, where all is back, is one of its own."""
    checks = [c["recording"] for c in document["checks"]]
    true = set()
    for day, _, number in told:
        seen = checks_after(document, day, number)
        true |= set(seen)
        true |= set(checks[checks.index(seen[-1]) + 1 :][:1]) if number < 0 and seen else set()
    return [c["recording"] for c in document["checks"] if c["alarm"] and c["recording"] not in true]


def share_of_machines(shares):
    """(mean, low, high) of shares of machines: Student's t, 95 %."""
    shares = np.array(shares, dtype=float)
    half = (
        stats.t.ppf(0.975, len(shares) - 1) * shares.std(ddof=1) / np.sqrt(len(shares))
        if len(shares) > 1
        else np.nan
    )
    return float(shares.mean()), float(shares.mean() - half), float(shares.mean() + half)


def exact_share(hits, count):
    """(share, low, high): Clopper and Pearson, 95 %."""
    low = stats.beta.ppf(0.025, hits, count - hits + 1) if hits else 0.0
    high = stats.beta.ppf(0.975, hits + 1, count - hits) if hits < count else 1.0
    return hits / count, float(low), float(high)


def exact_rate(hits, years):
    """(rate, low, high) in a year: Garwood, 95 %."""
    low = stats.chi2.ppf(0.025, 2 * hits) / 2 if hits else 0.0
    return hits / years, float(low / years), float(stats.chi2.ppf(0.975, 2 * hits + 2) / 2 / years)


def count(folder, seeds, events, every):
    """Rows of all machines; those that lie in the folder are gone on with."""
    journal = Path(folder) / "rows.json"
    rows = json.loads(journal.read_text()) if journal.exists() else []
    for seed in (s for s in seeds if s not in {r["seed"] for r in rows}):
        document, bands, told = follow(folder, seed, events, every)
        row = {
            "seed": seed,
            "bands": bands,
            "false": false_alarms(document, told),
            "changes": judge_changes(document, told),
        }
        rows.append(row)
        print(json.dumps({k: v for k, v in row.items() if k != "bands"}), flush=True)
        journal.write_text(json.dumps(rows))
    return rows


AGES = (7, 30, 90)


def line(name, found, count, bar):
    mean, low, high = found
    return f"| {name} | {mean:.3f} | {low:.3f} to {high:.3f} | {count} | {bar} |"


def band_lines(rows):
    """A line of the table per age and kind of number."""
    out = []
    for kind, word in (("component_table", "slopes"), ("squareness", "squareness"), ("", "all numbers")):
        for days in AGES:
            own = [
                [
                    b["inside"]
                    for b in r["bands"]
                    if b["days"] == days and kind in b["input"] and not b["jump"]
                ]
                for r in rows
            ]
            shares = [np.mean(p) for p in own if p]
            bar = "0.93 to 0.97" if not kind else ""
            out.append(
                line(f"95 % band, {days} d, {word}", share_of_machines(shares), sum(map(len, own)), bar)
            )
    for days in AGES:
        own = [b["inside"] for r in rows for b in r["bands"] if b["days"] == days and b["jump"]]
        if own:
            out.append(
                line(
                    f"95 % band, {days} d, over a jump",
                    exact_share(sum(own), len(own)),
                    len(own),
                    "none: not foreseen",
                )
            )
    return out


def summary(rows):
    """Lines of a table, with its head."""
    out = ["| what | figure | 95 % interval | of | bar |", "|---|---|---|---|---|"]
    return out + band_lines(rows) + alarm_lines(rows)


def alarm_lines(rows):
    """A line of the table for false alarms, and two for every kind of change."""
    out = []
    wrong = [len(r["false"]) for r in rows]
    out.append(
        line(
            "false alarms in a machine-year",
            exact_rate(sum(wrong), len(rows)),
            f"{len(rows)} machines",
            "1 per machine at most",
        )
    )
    out.append(
        line(
            "machines with more than one",
            exact_share(sum(w > 1 for w in wrong), len(rows)),
            f"{len(rows)}",
            "0",
        )
    )
    changes = [c for r in rows for c in r["changes"]]
    for kind in (*sorted({c["kind"] for c in changes}), ""):
        own = [c for c in changes if kind in c["kind"]]
        if not own:
            continue
        word = kind or "all changes"
        out.append(
            line(
                f"{word}: found within two checks",
                exact_share(sum(c["found"] for c in own), len(own)),
                len(own),
                "1",
            )
        )
        out.append(
            line(
                f"{word}: named rightly", exact_share(sum(c["named"] for c in own), len(own)), len(own), "0.9"
            )
        )
    return out


if __name__ == "__main__":
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("folder", type=Path)
    words.add_argument("--machines", type=int, default=2)
    words.add_argument("--first", type=int, default=0, help="seed of the first machine")
    words.add_argument("--every", type=int, default=7)
    words.add_argument("--quiet", action="store_true", help="no collisions, no new encoder, no open door")
    words.add_argument("--again", action="store_true", help="the table of the rows that lie there")
    given = words.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    if given.again:
        counted = json.loads((given.folder / "rows.json").read_text())
    else:
        counted = count(
            given.folder, range(given.first, given.first + given.machines), not given.quiet, given.every
        )
    print("\n".join(summary(counted)))
