"""Whether the plan of checks of `vcmm track --task` is worth its name: machines of referee/fleet.py, half a year by plan and half a year by a fixed interval.

    python -m referee.plan FOLDER --machines 6
    python -m referee.plan FOLDER --again

Until day 180 every machine is probed each week, with a ball bar each month, and a laser along X on day 180. The task is the length between two planes 460 mm apart along
X; U of it is to stay below LIMIT. Then, on one and the same machine:

    plan   the first check of the plan is done on its day, taken in, and the rest of the half year planned anew
    fixed  the cheapest check at a fixed interval that the command itself says keeps the limit over the half year

Counted: weeks in which U stays below the limit, weeks in which the machine's true departure from the tracked one stays below the limit (a check of what U claims; the error of X
between the planes, from the forecast 7 and 30 days after each check), and what the checks cost.
"""

import argparse
import json
import shutil
from pathlib import Path

import numpy as np

from referee import fleet
from referee.files import call
from referee.follow import exact_share, share_of_machines

START, END = 180, 360
LIMIT = 1.8  # um, of U
CHECKS = (
    ("sphere plate", "175_probe.toml", 25, 20),
    ("ball bar", "165_bar.toml", 40, 30),
    ("laser X", "180_laser.toml", 120, 90),
)
TASK = """vcmm = "scenario/1"
machine = "machine.toml"
[part.features]
left = { type = "plane", point = "0 0 0 mm", normal = [-1, 0, 0], size = "40 40 mm" }
right = { type = "plane", point = "460 0 0 mm", normal = [1, 0, 0], size = "40 40 mm" }
[[part.characteristics]]
name = "length"
type = "distance"
between = ["left", "right"]
[pose]
shift = "20 250 200 mm"
[plan]
touch = { speed = "5 mm/s", approach = "3 mm", clearance = "10 mm" }
styli.down = { offset = "0 0 0 mm", tip_diameter = "4 mm" }
[[plan.steps]]
feature = "left"
stylus = "down"
points = { strategy = "grid", n = [3, 3], margin = "5 mm" }
[[plan.steps]]
feature = "right"
stylus = "down"
points = { strategy = "grid", n = [3, 3], margin = "5 mm" }
"""


def begin(folder, seed):
    """machine.toml, task, list of checks, and recordings until START in folder/checks; truth of every day."""
    rng = np.random.default_rng([seed, 34])
    (folder / "checks").mkdir(parents=True)
    text, tables = fleet.machine_text(f"machine {seed}")
    (folder / "machine.toml").write_text(text)
    (folder / "errors.csv").write_text(tables)
    (folder / "task.toml").write_text(TASK)
    lines = ['vcmm = "checks/1"']
    for name, like, cost, minutes in CHECKS:
        lines += [
            "[[checks]]",
            f'name = "{name}"',
            f'like = "{like}"',
            f"cost = {cost}",
            f"minutes = {minutes}",
        ]
    (folder / "list.toml").write_text("\n".join(lines) + "\n")
    theta, _ = fleet.draw_year(rng, False)
    for day in range(START + 1):
        for name in (("probe",) if day % 7 == 0 else ()) + (("bar",) if day % 30 == 15 else ()):
            check(folder, name, day, theta, rng)
    check(folder, "laser", START, theta, rng)
    return theta


def check(folder, kind, day, theta, rng):
    """One recording of a day."""
    name, date = f"{day:03d}_{kind}", fleet.date_of(day)
    where = folder / "checks"
    if kind == "laser":
        fleet.write_laser(where, name, date, theta[day], rng, 0)
    else:
        {"probe": fleet.write_probe, "bar": fleet.write_bar}[kind](where, name, date, theta[day], rng)


def ask(folder, days):
    """The document of the plan of so many days."""
    return call(
        folder, "track", "machine.toml", "checks", "--out", "out", "--no-explain", "--task", "task.toml",
        "--limit", f"length = {LIMIT} um", "--checks", "list.toml", "--days", str(days),
    )  # fmt: skip


KIND = {name: like[4:].removesuffix(".toml") for name, like, _, _ in CHECKS}


def day_of(date):
    return int((np.datetime64(date) - np.datetime64("2026-01-01")).astype(int))


def true_errors(document, day, until, theta):
    """|truth less forecast| of X between the ends, um, 7 and 30 days after a check, where no other check came before."""
    out = []
    for one in document["forecast"]:
        then = day + int(one["days"])
        if one["input"] == "component_table[EXX].values" and one["days"] <= 30 and then <= until:
            out.append(abs(one["value"] - theta[then][0] * fleet.LENGTH * 1e3) * 460 / fleet.LENGTH)
    return out


def held_until(document, day):
    """The last day on which U is below the limit without another check."""
    nearest = min((day_of(n["when"]) for n in document["next_checks"]), default=day)
    if document["plan"]["checks"]:
        return nearest
    return END if document["plan"]["kept"] else nearest


def go_on(folder, theta, rng, way, document):
    """Half a year by plan or at the fixed interval of the first plan: cost, weeks kept, true errors."""
    fixed = document["plan"]["fixed_interval"]
    day, cost, days_kept, errors, done = START, 0.0, np.zeros(END + 1, dtype=bool), [], []
    first = True
    while True:
        if way == "fixed":
            following = day if first else day + fixed["days"]
            what = fixed["check"]
        else:
            plan = document["plan"]["checks"]
            following = max(day_of(plan[0]["when"]), day) if plan else END + 1
            what = plan[0]["check"] if plan else ""
        held = held_until(document, day)
        days_kept[day : min(following, held, END) + 1] = True
        errors += true_errors(document, day, min(following, END), theta) if not first else []
        if following >= END or (not first and following == day):
            break
        day, first = following, False
        name = f"{day:03d}_{KIND[what]}"
        if (folder / "checks" / f"{name}.toml").exists():  # done that day already
            name += "2"
        check(folder, name[4:], day, theta, rng) if not name.endswith("2") else again(
            folder, name, day, theta, rng
        )
        cost += next(c for n, _, c, _ in CHECKS if n == what)
        done.append((day, what))
        document = ask(folder, END - day)
    weeks = days_kept[START : END + 1 : 7]
    return {"cost": cost, "weeks": int(weeks.sum()), "of": len(weeks), "errors": errors, "done": done}


def again(folder, name, day, theta, rng):
    """A second check of one kind on one day, under another name."""
    kept = {p: p.read_text() for p in (folder / "checks").glob(f"{name[:-1]}.*")}
    check(folder, name[4:-1], day, theta, rng)
    for path in kept:
        text = path.read_text().replace(name[:-1], name)
        path.with_name(path.name.replace(name[:-1], name)).write_text(text)
    for path, text in kept.items():
        path.write_text(text)


def count(folder, seeds):
    rows = []
    for seed in seeds:
        home = folder / f"machine_{seed:02d}"
        shutil.rmtree(home, ignore_errors=True)
        theta = begin(home / "plan", seed)
        document = ask(home / "plan", END - START)
        shutil.copytree(home / "plan", home / "fixed")
        row = {"seed": seed, "fixed_interval": document["plan"]["fixed_interval"]}
        ways = ("plan", "fixed") if row["fixed_interval"] else ("plan",)
        for way in ways:
            row[way] = go_on(home / way, theta, np.random.default_rng([seed, 35]), way, document)
        rows.append(row)
        print(json.dumps({k: {**v, "errors": None} if k in ways else v for k, v in row.items()}), flush=True)
        (folder / "plan.json").write_text(json.dumps(rows))
    return rows


def summary(rows):
    """Lines of a table."""
    out = ["| what | by plan | at a fixed interval | bar |", "|---|---|---|---|"]
    both = [r for r in rows if "fixed" in r]
    ways = {"plan": rows, "fixed": both}

    def text(found, count):
        return "{:.3f} ({:.3f} to {:.3f}) of {}".format(*found, count)

    weeks = [
        exact_share(sum(r[w]["weeks"] for r in own), sum(r[w]["of"] for r in own)) for w, own in ways.items()
    ]
    counts = [sum(r[w]["of"] for r in own) for w, own in ways.items()]
    out.append(
        f"| weeks with U below the limit | {text(weeks[0], counts[0])} | {text(weeks[1], counts[1])} | 0.95 |"
    )
    true = [[e <= LIMIT for r in own for e in r[w]["errors"]] for w, own in ways.items()]
    out.append(
        "| true error below the limit | "
        + " | ".join(text(exact_share(sum(t), len(t)), len(t)) for t in true)
        + " | 0.95 |"
    )
    ratio = share_of_machines([r["plan"]["cost"] / r["fixed"]["cost"] for r in both])
    costs = [sum(r[w]["cost"] for r in both) for w in ways]
    out.append(
        f"| cost, {len(both)} machines | {costs[0]:g} | {costs[1]:g} | ratio {costs[0] / costs[1]:.2f}; 0.7 |"
    )
    out.append("| mean ratio of costs | {:.2f} ({:.2f} to {:.2f}) | 1 | 0.7 |".format(*ratio))
    none = len(rows) - len(both)
    out.append(f"| machines on which no fixed interval keeps the limit | – | {none} of {len(rows)} | |")
    return out


if __name__ == "__main__":
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("folder", type=Path)
    words.add_argument("--machines", type=int, default=2)
    words.add_argument("--first", type=int, default=0)
    words.add_argument("--again", action="store_true", help="the table of the rows that lie there")
    given = words.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    if given.again:
        counted = json.loads((given.folder / "plan.json").read_text())
    else:
        counted = count(given.folder, range(given.first, given.first + given.machines))
    print("\n".join(summary(counted)))
