"""How often the 95 % bands and the alarms of `vcmm track` are right, and why not: python benchmarks/bench_track_bands.py FOLDER [--machines 12 --first 200 --given]

Machines of referee/fleet.py, followed recording by recording in one process (the functions that the command calls, without its files). After
every fourth recording from day 60 on every number is forecast 0, 7, 30 and 90 days ahead and held against the truth of that day; forecasts over a jump, or after one that no check has seen yet, are left
out. With --given also by a filter that is told the rates (GIVEN: the middle of what the fleet is drawn from), which tells what the learning of the
rates costs from what the filter, its shapes and its jumps do. Alarms and changes are judged by referee/follow.py. Rows are kept in FOLDER and gone on with.
"""

from __future__ import annotations

import argparse
import json
import tempfile
from pathlib import Path
from typing import Any

import numpy as np

from referee.fleet import write_machine
from referee.follow import NUMBERS, alarm_lines, false_alarms, judge_changes, share_of_machines
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.learn.tracking.alarms import ALPHA
from vcmm.learn.tracking.changes import jumps_of, update
from vcmm.learn.tracking.compress import SeenRecording, see_recording
from vcmm.learn.tracking.follow import follow_one, start_following
from vcmm.learn.tracking.kalman import GaussianState
from vcmm.learn.tracking.learn_rates import columns_for
from vcmm.learn.tracking.quantities import TrackedMachine, tracked_machine
from vcmm.learn.tracking.rates import GroupRates, WanderingMotion, first_state, motion_of

AGES, FROM, EVERY = (0, 7, 30, 90), 60, 4
# in usual sizes (5 um of a table of unit rms, 10 urad): 6 um/m, 0.5 um and 8 urad of walk in a year, 4 um/m of wear in one of three, 3 um/m and urad of season
GIVEN = {
    "translations": (0.51, 0.2, 0.4), "bends": (0.11, 0.0, 0.0), "squareness[B0Z]": (0.9, 0.0, 0.3),
    "squareness": (0.9, 0.0, 0.0),
}  # fmt: skip


def given_rates(tracked: TrackedMachine) -> tuple[GroupRates, ...]:
    return tuple(GroupRates(*next(v for k, v in GIVEN.items() if g.startswith(k))) for g in tracked.groups)


def picks(tracked: TrackedMachine) -> np.ndarray:
    """(6, K): end less start of the curves, um, and squarenesses, urad."""
    out = np.zeros((len(NUMBERS), tracked.factor.shape[0]))
    for i, (name, (_, _)) in enumerate(NUMBERS.items()):
        rows = tracked.rows[name]
        out[i, rows.start] = 1e6
        if rows.stop - rows.start > 1:
            out[i, [rows.start, rows.stop - 1]] = -1e3, 1e3
    return out


def forecasts(
    tracked: TrackedMachine, motion: WanderingMotion, state: GaussianState, days: tuple[int, int], theta: np.ndarray, told: list[Any]
) -> list[list[Any]]:  # fmt: skip
    """[number, age, day, error over u, u] of every forecast that is made on a day. days: of the last check that sees all numbers, and this one."""
    known, now = days
    truth, growth, pick = (
        np.stack([theta[:, k] * s for k, s in NUMBERS.values()], 1),
        tracked.growth,
        picks(tracked),
    )
    ways = pick @ np.concatenate([tracked.factor, growth, growth, growth, 0 * growth, 0 * growth, growth], 1)
    out = []
    for age in (a for a in AGES if now + a < len(theta)):
        day, later = now + age, motion.step(state, float(age))
        mean, u = ways @ later.mean, np.sqrt(((ways @ later.factor) ** 2).sum(1))
        for j, (number, _) in enumerate(NUMBERS.values()):
            if not any(known < d <= day and n in (number, -1) and (n >= 0 or d == day) for d, _, n in told):
                z = float((mean[j] - truth[day, j]) / u[j])
                out.append([list(NUMBERS)[j], age, now, z, float(u[j])])
    return out


def days_of(seen: list[SeenRecording], i: int) -> tuple[int, int]:
    """Days of the last check that sees all numbers (a laser sees one alone), and of recording i."""
    return int(max(s.when for s in seen[: i + 1] if "laser" not in s.name)), int(seen[i].when)


def is_asked(i: int, one: SeenRecording) -> bool:
    return one.when >= FROM and i % EVERY == 0


def by_learnt_rates(
    tracked: TrackedMachine, seen: list[SeenRecording], theta: np.ndarray, told: list[Any]
) -> dict[str, Any]:
    """Forecasts, alarms and changes of the machine as the command follows it."""
    followed, out = start_following(tracked, ALPHA), []
    for i, one in enumerate(seen):
        followed = follow_one(followed, one, "")
        if is_asked(i, one):
            out += forecasts(tracked, followed.motion, followed.state, days_of(seen, i), theta, told)
    document = {
        "checks": [
            {"recording": c.name, "alarm": c.alarm, "changed": [{"name": n} for n, _ in c.suspects]}
            for c in followed.checks
        ]
    }
    return {"learnt": out, "false": false_alarms(document, told), "changes": judge_changes(document, told)}


def by_given_rates(
    tracked: TrackedMachine, seen: list[SeenRecording], theta: np.ndarray, told: list[Any]
) -> list[list[Any]]:
    """Forecasts of a filter that is told the rates."""
    motion = motion_of(tracked.group_of_mode, tracked.stated, given_rates(tracked))
    state, before, out = first_state(motion), None, []
    for i, one in enumerate(seen):
        days = 0.0 if before is None else one.when - before
        columns = columns_for(one, tracked.stated)
        state = update(motion.step(state, days), columns, one.value, jumps_of(tracked), days).state
        before = one.when
        if is_asked(i, one):
            out += forecasts(tracked, motion, state, days_of(seen, i), theta, told)
    return out


def count(folder: Path, seed: int, events: bool, also_given: bool) -> dict[str, Any]:
    """Forecasts, alarms and changes of one machine."""
    with tempfile.TemporaryDirectory(dir=folder) as name:
        theta, told = write_machine(Path(name), seed, events)
        machine = load_machine(Path(name) / "machine.toml")
        tracked, seen = tracked_machine(machine), []
        for path in (Path(name) / "checks").glob("*.toml"):
            recording, _ = load_recording(path, machine, gaps=True)
            seen.append(see_recording(tracked, recording, path.name, float(path.name[:3])))
    seen.sort(key=lambda s: (s.when, s.name))
    row = {"seed": seed, **by_learnt_rates(tracked, seen, theta, told)}
    return row | ({"given": by_given_rates(tracked, seen, theta, told)} if also_given else {})


def held(rows: list[dict[str, Any]], way: str, age: int, kind: str) -> tuple[str, np.ndarray]:
    """Share within the band with its interval over machines, and all errors over u."""
    own = [[f[3] for f in row[way] if f[1] == age and kind in f[0]] for row in rows if way in row]
    if not own:
        return "–", np.zeros(0)
    share = share_of_machines([np.mean(np.abs(z) < 1.96) for z in own if z])
    return "{:.3f} ({:.3f} to {:.3f})".format(*share), np.concatenate([np.array(z) for z in own])


def lines(rows: list[dict[str, Any]]) -> list[str]:
    """Bands by age and kind, and by number; then alarms and changes."""
    out = [
        f"{len(rows)} machines, seeds {min(r['seed'] for r in rows)} to {max(r['seed'] for r in rows)}",
        "",
        "| age of the last check | numbers | within the 95 % band | of | rms of error over u | with given rates |",
        "|---|---|---|---|---|---|",
    ]
    for age in AGES:
        for kind, word in (("component", "slopes"), ("squareness", "squareness"), ("", "all numbers")):
            text, z = held(rows, "learnt", age, kind)
            out.append(
                f"| {age} d | {word} | {text} | {len(z)} | {np.sqrt((z**2).mean()):.2f} | {held(rows, 'given', age, kind)[0]} |"
            )
    out += ["", "| number | " + " | ".join(f"{a} d" for a in AGES) + " |", "|---" * (len(AGES) + 1) + "|"]
    for name in NUMBERS:
        out.append(f"| {name} | " + " | ".join(held(rows, "learnt", a, name)[0] for a in AGES) + " |")
    return [
        *out,
        "",
        "| what | figure | 95 % interval | of | bar |",
        "|---|---|---|---|---|",
        *alarm_lines(rows),
    ]


if __name__ == "__main__":
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("folder", type=Path)
    words.add_argument("--machines", type=int, default=12)
    words.add_argument("--first", type=int, default=200)
    words.add_argument("--given", action="store_true", help="with rates that are given, too")
    words.add_argument("--again", action="store_true", help="the tables of the rows that lie there")
    words.add_argument("--quiet", action="store_true", help="no collisions, no new encoder, no open door")
    given = words.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    journal = given.folder / "rows.jsonl"
    known = [json.loads(text) for text in journal.read_text().splitlines()] if journal.exists() else []
    for seed in range(given.first, given.first + given.machines):
        if not given.again and seed not in {r["seed"] for r in known}:
            known.append(count(given.folder, seed, not given.quiet, given.given))
            with journal.open("a") as stream:
                stream.write(json.dumps(known[-1]) + "\n")
    print("\n".join(lines(known)))
