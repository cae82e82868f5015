"""How often the 95 % bands of `vcmm track` hold, and why not: python benchmarks/bench_track_bands.py FOLDER [--machines 12 --first 200 --quiet]

Machines of referee/fleet.py, followed recording by recording in one process (the functions that the command calls, without its files). After
every fourth recording from day 60 on every number is forecast 0, 7, 30 and 90 days ahead and held against the truth of that day; forecasts over a jump are left
out. Twice: with the rates that are learnt, and with rates that are given (GIVEN: the middle of what the fleet is drawn from), which tells what the learning of the
rates costs from what the filter, its shapes and its jumps do. Rows are kept in FOLDER and gone on with.
"""

from __future__ import annotations

import argparse
import json
from collections.abc import Callable
from pathlib import Path
from typing import Any

import numpy as np

from referee.fleet import write_machine
from referee.follow import NUMBERS, share_of_machines
from vcmm.files.own.machine import load_machine
from vcmm.files.own.recording import load_recording
from vcmm.learn.tracking.changes import jumps_of, update
from vcmm.learn.tracking.compress import SeenRecording, see_recording
from vcmm.learn.tracking.learn_rates import columns_for, is_due, learn_rates
from vcmm.learn.tracking.quantities import TrackedMachine, tracked_machine
from vcmm.learn.tracking.rates import GroupRates, first_rates, first_state, motion_of

AGES, FROM, EVERY = (0, 7, 30, 90), 60, 4
Rates = tuple[GroupRates, ...]
# in usual sizes (5 um of a table of unit rms, 10 urad): 6 um/m, 0.5 um and 8 urad of walk in a year, 4 um/m of wear in one of three, 3 um/m and urad of season
GIVEN = {
    "translations": (0.51, 0.2, 0.4), "bends": (0.11, 0.0, 0.0), "squareness[B0Z]": (0.9, 0.0, 0.3),
    "squareness": (0.9, 0.0, 0.0),
}  # fmt: skip


def given_rates(tracked: TrackedMachine) -> Rates:
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
    tracked: TrackedMachine, seen: list[SeenRecording], theta: np.ndarray, told: list[Any], rates_at: Callable[[int], Rates]
) -> list[list[Any]]:  # fmt: skip
    """[number, age, day, error over u, u] of every forecast."""
    jumps, truth = jumps_of(tracked), np.stack([theta[:, k] * s for k, s in NUMBERS.values()], 1)
    growth, pick, out, used = tracked.growth, picks(tracked), [], None
    ways = pick @ np.concatenate([tracked.factor, growth, growth, growth, 0 * growth, 0 * growth], 1)
    for i, one in enumerate(seen):
        rates = rates_at(i + 1)
        again = rates is not used
        if again:
            used, motion = rates, motion_of(tracked.group_of_mode, tracked.stated, rates)
            state, before = first_state(motion), None
        for each in seen[: i + 1] if again else [one]:
            days = 0.0 if before is None else each.when - before
            moved = motion.step(state, days)
            state = update(moved, columns_for(each, tracked.stated), each.value, jumps, days).state
            before = each.when
        if one.when < FROM or i % EVERY:
            continue
        for age in (a for a in AGES if one.when + a < len(theta)):
            day, later = int(one.when + age), motion.step(state, float(age))
            mean, u = ways @ later.mean, np.sqrt(((ways @ later.factor) ** 2).sum(1))
            for j, (number, _) in enumerate(NUMBERS.values()):
                if not any(
                    one.when < d <= day and n in (number, -1) and (n >= 0 or d == day) for d, _, n in told
                ):
                    z = float((mean[j] - truth[day, j]) / u[j])
                    out.append([list(NUMBERS)[j], age, int(one.when), z, float(u[j])])
    return out


def count(folder: Path, seed: int, events: bool) -> dict[str, Any]:
    """Forecasts of one machine, with learnt and with given rates."""
    place = folder / f"machine_{seed:03d}"
    theta, told = write_machine(place, seed, events)
    machine = load_machine(place / "machine.toml")
    tracked = tracked_machine(machine)
    seen = []
    for path in (place / "checks").glob("*.toml"):
        recording, _ = load_recording(path, machine, gaps=True)
        seen.append(see_recording(tracked, recording, path.name, float(path.name[:3])))
    seen.sort(key=lambda s: (s.when, s.name))
    learnt: list[Rates] = [first_rates(tracked)]
    for k in range(1, len(seen) + 1):
        due = is_due(k)
        learnt.append(learn_rates(tracked, seen[:k], jumps_of(tracked), learnt[-1]) if due else learnt[-1])
    fixed = given_rates(tracked)
    return {
        "seed": seed,
        "learnt": forecasts(tracked, seen, theta, told, lambda k: learnt[k]),
        "given": forecasts(tracked, seen, theta, told, lambda k: fixed),
    }


def lines(rows: list[dict[str, Any]]) -> list[str]:
    out = [
        "| age | kind | learnt rates | of | rms of error over u | given rates |",
        "|---|---|---|---|---|---|",
    ]
    for age in AGES:
        for kind, word in (("component", "slopes"), ("squareness", "squareness"), ("", "all")):
            own = {
                w: [[r[3] for r in row[w] if r[1] == age and kind in r[0]] for row in rows]
                for w in ("learnt", "given")
            }
            held = {
                w: share_of_machines([np.mean(np.abs(z) < 1.96) for z in zs if z]) for w, zs in own.items()
            }
            z = np.concatenate([np.array(v) for v in own["learnt"]])
            text = {w: "{:.3f} ({:.3f} to {:.3f})".format(*v) for w, v in held.items()}
            out.append(
                f"| {age} d | {word} | {text['learnt']} | {len(z)} | {np.sqrt((z**2).mean()):.2f} | {text['given']} |"
            )
    return out


if __name__ == "__main__":
    words = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    words.add_argument("folder", type=Path)
    words.add_argument("--machines", type=int, default=12)
    words.add_argument("--first", type=int, default=200)
    words.add_argument("--quiet", action="store_true", help="no collisions, no new encoder, no open door")
    given = words.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    journal = given.folder / "rows.jsonl"
    known = [json.loads(text) for text in journal.read_text().splitlines()] if journal.exists() else []
    for seed in range(given.first, given.first + given.machines):
        if seed not in {r["seed"] for r in known}:
            known.append(count(given.folder, seed, not given.quiet))
            with journal.open("a") as stream:
                stream.write(json.dumps(known[-1]) + "\n")
    print("\n".join(lines(known)))
