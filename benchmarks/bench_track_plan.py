"""What a plan of checks costs beside two fixed intervals: python benchmarks/bench_track_plan.py FOLDER [--machines 12 --first 1000]

Machines and task of referee/plan.py, followed and planned in one process (the functions that the command calls, without its files). From day 180 to day 360 the
first check of the plan is done on its day, taken in, and the rest of the half year planned anew. Held against it, all by the same covariances:

    own     the cheapest fixed interval that this machine's own model says keeps the limit: no shop has that without it
    fleet   one check at one interval for all machines, the cheapest with which U is below the limit on 0.95 of all days of the fleet,
            chosen when all is known

Also counted: days on which U is below the limit by plan, and true departures of X between the planes, 7 and 30 days after each check, that stay below it. Rows are
kept in FOLDER and gone on with.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from referee import fleet
from referee.follow import exact_share, share_of_machines
from referee.plan import CHECKS, END, KIND, LIMIT, START, begin, check
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.files.own.scenario import load_scenario
from vcmm.learn.tracking.alarms import ALPHA
from vcmm.learn.tracking.compress import see_recording
from vcmm.learn.tracking.follow import FollowedMachine, follow_one, start_following
from vcmm.learn.tracking.kalman import condition, innovation
from vcmm.learn.tracking.learn_rates import columns_for
from vcmm.learn.tracking.machine_at import machine_on
from vcmm.learn.tracking.next_check import ShopCheck, plan_checks
from vcmm.learn.tracking.quantities import tracked_machine
from vcmm.learn.tracking.task_limits import K, TaskLimit, limits_of

SHOP = tuple(ShopCheck(*c) for c in CHECKS)
COST = {c.name: c.cost for c in SHOP}
INTERVALS = (3, 5, 7, 10, 14, 21, 28, 35, 42, 49, 56, 70, 84, 91, 112, 182)
DAYS = END - START + 1


def take_in(followed: FollowedMachine, folder: Path, name: str, when: int) -> FollowedMachine:
    """One more recording of the folder."""
    recording, _ = load_recording(folder / "checks" / f"{name}.toml", followed.tracked.machine, gaps=True)
    seen = see_recording(followed.tracked, recording, f"{name}.toml", float(when))
    return follow_one(followed, seen, fleet.date_of(when))


def expanded(followed: FollowedMachine, limit: TaskLimit, when: float) -> float:
    """U of the task on a day, um."""
    state = followed.at(when)
    return 1e3 * K * float(np.sqrt(limit.rest**2 + ((limit.gain @ state.factor) ** 2).sum()))


def days_at(followed: FollowedMachine, limit: TaskLimit, one: ShopCheck, interval: int) -> int:
    """Days with U below the limit where a check is done every so many days from START on."""
    like = next(s for s in followed.recordings if s.name == one.like)
    columns, state, kept = columns_for(like, followed.tracked.stated), followed.state, 0
    for day in range(START, END + 1):
        state = followed.motion.step(state, 1.0) if day > START else state
        if (day - START) % interval == 0 and day < END:
            state = condition(state, innovation(state, columns, like.value))
        square = limit.rest**2 + ((limit.gain @ state.factor) ** 2).sum()
        kept += bool(K * np.sqrt(square) <= limit.limit)
    return kept


def by_plan(folder: Path, followed: FollowedMachine, limit: TaskLimit, theta: np.ndarray, rng: np.random.Generator) -> dict[str, Any]:  # fmt: skip
    """Half a year by plan: cost, days kept, true departures, what was done."""
    day, cost, errors, done, below = START, 0.0, [], [], {}
    while True:
        _, plan = plan_checks(followed, float(day), SHOP, (limit,), END - day)
        then = day + plan.checks[0].day if plan.checks else END + 1
        for one in range(day, min(then, END) + 1):
            below[one] = max(below.get(one, False), bool(expanded(followed, limit, one) <= LIMIT))
        if done:
            ways = followed.ways[followed.tracked.rows["component_table[EXX].values"]][[0, -1]]
            for age in (a for a in (7, 30) if day + a <= min(then, END)):
                mean = 1e3 * (ways @ followed.at(float(day + age)).mean)
                true = theta[day + age][0] * fleet.LENGTH * 1e3
                errors.append(abs(mean[1] - mean[0] - true) * 460 / fleet.LENGTH)
        if then >= END or (done and then == day):
            break
        day, name = then, plan.checks[0].check.name
        check(folder, KIND[name], day, theta, rng)
        followed = take_in(followed, folder, f"{day:03d}_{KIND[name]}", day)
        cost += COST[name]
        done.append((day, name))
    return {"cost": cost, "below": sum(below.values()), "errors": errors, "done": done}


def count(folder: Path, seed: int) -> dict[str, Any]:
    """Costs of one machine by plan, at its own interval, and the days kept at each interval of INTERVALS."""
    with tempfile.TemporaryDirectory(dir=folder) as name:
        home = Path(name) / "machine"
        theta = begin(home, seed)
        machine = load_machine(home / "machine.toml")
        followed = start_following(tracked_machine(machine), ALPHA)
        for path in sorted((home / "checks").glob("*.toml")):
            followed = take_in(followed, home, path.stem, int(path.name[:3]))
        (limit,) = limits_of(
            [f"length = {LIMIT} um"], load_scenario(home / "task.toml"), machine_on(followed, float(START))
        )
        _, first = plan_checks(followed, float(START), SHOP, (limit,), END - START)
        at = {
            one.name: {d: days_at(followed, limit, one, d) for d in INTERVALS}
            for one in SHOP
            if one.name != "ball bar"
        }
        return {
            "seed": seed, "own": first.fixed, "days_at": at, "first_plan": first.cost,
            "plan": by_plan(home, followed, limit, theta, np.random.default_rng([seed, 35])),
        }  # fmt: skip


def cost_at(name: str, interval: int) -> float:
    """The first check on the first day."""
    return COST[name] * (1 + (END - START - 1) // interval)


def fleet_interval(rows: list[dict[str, Any]]) -> tuple[str, int, float, float] | None:
    """(check, days, cost of a machine, share of days) of the cheapest interval for all with 0.95 of days below the limit."""
    found = []
    for name in rows[0]["days_at"]:
        for d in INTERVALS:
            share = sum(r["days_at"][name][str(d)] for r in rows) / (DAYS * len(rows))
            if share >= 0.95:
                found.append((name, d, cost_at(name, d), share))
    return min(found, key=lambda f: f[2]) if found else None


def lines(rows: list[dict[str, Any]]) -> list[str]:
    """The table."""
    errors = [e for r in rows for e in r["plan"]["errors"]]
    cost = sum(r["plan"]["cost"] for r in rows)

    def text(found: tuple[float, float, float]) -> str:
        return "{:.3f} ({:.3f} to {:.3f})".format(*found)

    out = [
        f"{len(rows)} machines, seeds {min(r['seed'] for r in rows)} to {max(r['seed'] for r in rows)}", "",
        "| what | figure | of | bar |", "|---|---|---|---|",
        f"| days by plan with U below the limit | {text(share_of_machines([r['plan']['below'] / DAYS for r in rows]))} | {DAYS * len(rows)} days | 0.95 |",
        f"| true departure below the limit | {text(exact_share(sum(e <= LIMIT for e in errors), len(errors)))} | {len(errors)} forecasts | 0.95 |",
    ]  # fmt: skip
    own = [r for r in rows if r["own"]]
    if own:
        ratio = sum(r["plan"]["cost"] for r in own) / sum(r["own"][2] for r in own)
        mean = share_of_machines([r["plan"]["cost"] / r["own"][2] for r in own])
        out.append(
            f"| cost over that of each machine's own fixed interval | {ratio:.2f}; mean of machines {text(mean)} | {len(own)} machines | 0.7 |"
        )
    one = fleet_interval(rows)
    if one:
        mean = share_of_machines([r["plan"]["cost"] / one[2] for r in rows])
        out.append(
            f"| cost over that of one interval for the fleet ({one[0]} every {one[1]} d, {one[2]:g} a machine, {one[3]:.3f} of days) | "
            f"{cost / (one[2] * len(rows)):.2f}; mean of machines {text(mean)} | {len(rows)} machines | 0.7 |"
        )
    return out


if __name__ == "__main__":
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("folder", type=Path)
    words.add_argument("--machines", type=int, default=12)
    words.add_argument("--first", type=int, default=1000)
    words.add_argument("--again", action="store_true", help="the table of the rows that lie there")
    given = words.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    journal = given.folder / "plan.jsonl"
    known = [json.loads(text) for text in journal.read_text().splitlines()] if journal.exists() else []
    for seed in range(given.first, given.first + given.machines):
        if not given.again and seed not in {r["seed"] for r in known}:
            row = json.loads(json.dumps(count(given.folder, seed)))
            known.append(row)
            with journal.open("a") as stream:
                stream.write(json.dumps(row) + "\n")
    print("\n".join(lines(known)))
