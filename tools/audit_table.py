"""The published table of coverage: tasks of all kinds audited, written to docs/audit.md. One command: make audit.

python tools/audit_table.py [--parts 2000] [--minutes 10]     goes on where the last run stopped
python tools/audit_table.py --check 100                       counts so many parts of each anew and says where the page is out of date
"""

from __future__ import annotations

import argparse
import json
import math
import sys
import tempfile
import time
from dataclasses import asdict, dataclass, replace
from pathlib import Path

from vcmm.answer.evaluation.inversion import inversion_of
from vcmm.answer.evaluation.pairs import both
from vcmm.answer.inference.audit import AuditResult, IntervalLengths, audit_task, beside_oracle
from vcmm.files.own.scenario import load_scenario
from vcmm.show.tables.audit import verdict
from vcmm.task.measuring.scenario import Scenario

ROOT = Path(__file__).resolve().parents[1]
PAGE, COUNTS = ROOT / "docs" / "audit.md", ROOT / "tools" / "audit_counts.json"
CHECK = ROOT / "tools" / "audit_check.json"  # what --check found last
COLUMNS = ("prior", "0", "2", "6", "20", "other family")
MACHINE = """vcmm = "scenario/1"
[machine]
name = "CMM"
structure = "w b Y X Z t"
[machine.axes.X]
travel = ["0 mm", "600 mm"]
[machine.axes.Y]
travel = ["0 mm", "500 mm"]
[machine.axes.Z]
travel = ["-400 mm", "0 mm"]
[machine.repeatability]
law = "normal"
u = "0.5 um"
[[machine.effects]]
effect = "squareness"
pair = "C0Y"
angle = "0 urad"
[[machine.inputs]]
effect = "squareness"
pair = "C0Y"
parameter = "angle"
u = "2 urad"
[pose]
shift = "300 250 -200 mm"
[part.features]
top = { type = "plane", point = "0 0 20 mm", normal = [0, 0, 1], size = "80 80 mm" }
side = { type = "plane", point = "40 0 10 mm", normal = [1, 0, 0], size = "80 20 mm" }
edge = { type = "line", point = "-40 0 20 mm", direction = [1, 0, 0], normal = [0, 0, 1], length = "80 mm" }
ring = { type = "circle", point = "0 0 10 mm", axis = [0, 0, 1], diameter = "30 mm", inside = true }
bore = { type = "cylinder", point = "0 0 0 mm", axis = [0, 0, 1], diameter = "30 mm", length = "20 mm", inside = true }
low = { type = "plane", point = "0 0 0 mm", normal = [0, 0, -1], size = "80 80 mm" }
collar = { type = "cylinder", point = "0 0 20 mm", axis = [0, 0, 1], diameter = "50 mm", length = "20 mm" }
[plan]
styli.down = { offset = "0 0 -100 mm", tip_diameter = "2 mm" }
"""
STEP = '[[plan.steps]]\nfeature = "{}"\nstylus = "down"\npoints = {{ {} }}\n'
SEED = 7
DENSITIES = ("few", "some", "many")
PLANE = {d: f'strategy = "grid", n = [{n}, {n}]' for d, n in zip(DENSITIES, (3, 4, 6))}
LINE = {d: f'strategy = "even", n = {n}' for d, n in zip(DENSITIES, (9, 15, 25))}
RING = {d: f'strategy = "even", n = {n}' for d, n in zip(DENSITIES, (8, 15, 36))}
BORE = {
    "few": 'strategy = "levels", at = ["4 mm", "16 mm"], n = 6',
    "some": 'strategy = "levels", at = ["3 mm", "10 mm", "17 mm"], n = 9',
    "many": 'strategy = "levels", at = ["3 mm", "10 mm", "17 mm"], n = 16',
}
POINTS = {"top": PLANE, "side": PLANE, "low": PLANE, "edge": LINE, "ring": RING, "bore": BORE, "collar": BORE}
ZONE = '\ncriterion = "C"'
TASKS: dict[str, tuple[str, str, str]] = {  # name: (type and keys, feature, datums)
    "flatness": ('type = "flatness"', "top", ""),
    "straightness": ('type = "straightness"', "edge", ""),
    "roundness": ('type = "roundness"', "ring", ""),
    "cylindricity": ('type = "cylindricity"', "bore", ""),
    "surface profile": ('type = "surface_profile"', "top", "low"),
    "surface profile of a bore": ('type = "surface_profile"', "bore", "low"),
    "line profile": ('type = "line_profile"', "edge", "low"),
    "parallelism": ('type = "parallelism"', "top", "low"),
    "perpendicularity": ('type = "perpendicularity"', "bore", "top"),
    "perpendicularity of planes": ('type = "perpendicularity"', "side", "top"),
    "position": ('type = "position"', "bore", "top side"),
    "coaxiality": ('type = "coaxiality"', "collar", "bore"),
    "circular run-out": ('type = "circular_runout"', "ring", "bore"),
    "total run-out": ('type = "total_runout"', "collar", "bore"),
    "flatness, minimum zone": ('type = "flatness"' + ZONE, "top", ""),
    "straightness, minimum zone": ('type = "straightness"' + ZONE, "edge", ""),
    "roundness, minimum zone": ('type = "roundness"' + ZONE, "ring", ""),
    "cylindricity, minimum zone": ('type = "cylindricity"' + ZONE, "bore", ""),
    "size GX": ('type = "size"\ncriterion = "GX"', "ring", ""),
    "size GN": ('type = "size"\ncriterion = "GN"', "ring", ""),
}


def scenario_text(name: str, density: str) -> str:
    keys, feature, datums = TASKS[name]
    named = [feature, *datums.split()]
    steps = "".join(STEP.format(f, POINTS[f][density]) for f in named)
    zone = "" if "size" in keys else '\nzone = "0.02 mm"'
    listed = ", ".join(f'"{d}"' for d in datums.split())
    given = f"\ndatums = [{listed}]" if datums else ""
    return f'{MACHINE}{steps}[[part.characteristics]]\nname = "{name}"\n{keys}\nof = "{feature}"{given}{zone}\n[job]\ntrials = 24000\n'


def scenario_of(name: str, density: str, folder: Path) -> Scenario:
    path = folder / "audit_task.toml"
    path.write_text(scenario_text(name, density), encoding="utf-8")
    return load_scenario(path)


def rows_of(name: str, density: str, parts: int, folder: Path) -> tuple[AuditResult, ...]:
    scenario = scenario_of(name, density, folder)
    return audit_task(
        scenario.task(), replace(scenario.settings, seed=SEED), parts
    )  # belts: the columns of the page


def oracle_of(name: str, density: str, parts: int) -> IntervalLengths | None:
    """IntervalLengths beside an oracle's of the one characteristic of a task, over the prior."""
    with tempfile.TemporaryDirectory() as folder:
        scenario = scenario_of(name, density, Path(folder))
    inversion = inversion_of(scenario.task(), replace(scenario.settings, seed=SEED), [0])
    return beside_oracle(inversion, 0, both(inversion.drawing, parts, SEED + 1000))


@dataclass(frozen=True)
class Counted:
    """One row of the table: attained shares in the order of the columns."""

    task: str
    parts: int
    claimed: bool
    attained: tuple[float, ...]
    verdicts: tuple[str, ...]
    why: str = ""  # it is not claimed
    lengths: IntervalLengths | None = None


def counted(name: str, density: str, parts: int) -> Counted:
    with tempfile.TemporaryDirectory() as folder:
        rows = rows_of(name, density, parts, Path(folder))
    return Counted(
        f"{name}, {density} points", parts, rows[0].claimed, tuple(r.attained for r in rows), tuple(verdict(r) for r in rows), rows[0].why
    )  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("--parts", type=int, default=2000)
    parser.add_argument(
        "--minutes", type=float, default=math.inf, help="stop after so long; the next run goes on"
    )
    parser.add_argument("--fresh", action="store_true", help="count all of them again")
    parser.add_argument("--only", default="")
    parser.add_argument(
        "--check", type=int, default=0, help="parts of each task beside the page; counts nothing for it"
    )
    given = parser.parse_args()
    if given.check:
        return out_of_date(given.check, given.only)
    done = {} if given.fresh else read_counts()
    start = time.monotonic()
    for density in DENSITIES:
        for name in TASKS:
            before = done.get(f"{name}, {density} points")
            enough = before is not None and before.parts >= given.parts
            if given.only not in name or (enough and before.lengths):
                continue
            if time.monotonic() - start > 60 * given.minutes:
                break
            row = before if enough else counted(name, density, given.parts)
            row = replace(row, lengths=oracle_of(name, density, given.parts))
            done[row.task] = row
            print(line(row), flush=True)
            COUNTS.write_text(
                json.dumps([asdict(r) for r in done.values()], indent=1) + "\n", encoding="utf-8"
            )
    PAGE.write_text(page(done), encoding="utf-8")
    return 1 if any("outside" in row.verdicts for row in done.values()) else 0


def out_of_date(parts: int, only: str = "") -> int:
    """Prints tasks of the page whose claim is another now, or whose counts are; 1 where there are any. Two counts differ where Fisher's exact
    test says so at 5 % over all of them (Bonferroni).
    """
    tasks = {f"{n}, {d} points": (n, d) for n in TASKS for d in DENSITIES if only in n}
    found, said_of_all, before = 0, list[str](), read_counts()
    for number, (task, (name, density)) in enumerate(tasks.items(), 1):
        if task not in before:
            print(f"{task}: not on the page")
            continue
        old, new = before[task], counted(name, density, parts)
        said = [] if old.claimed == new.claimed else [f"claimed {old.claimed} on the page, {new.claimed} now"]
        for column, a, b in zip(COLUMNS, old.attained, new.attained):
            p = differ(round(a * old.parts), old.parts, round(b * parts), parts)
            if p < 0.05 / (len(COLUMNS) * len(tasks)):
                said.append(
                    f"{column}: {a:.1%} of {old.parts} on the page, {b:.1%} of {parts} now (p = {p:.1g})"
                )
        found += len(said)
        if said:
            said_of_all.append(f"{task}: {'; '.join(said)}")
            print(said_of_all[-1], flush=True)
        CHECK.write_text(
            json.dumps({"parts": parts, "tasks": number, "of": len(tasks), "differ": said_of_all}, indent=1)
            + "\n"
        )
    PAGE.write_text(page(before), encoding="utf-8")
    print(f"{len(tasks)} tasks, {parts} parts a column: {found} differences from the page")
    return int(found > 0)


def differ(held: int, n: int, other: int, m: int) -> float:
    """p value of Fisher's exact test that held of n and other of m have one share."""
    from scipy.stats import fisher_exact

    return float(fisher_exact([[held, n - held], [other, m - other]])[1])


def up_to_date() -> str:
    """What the last --check said of the page."""
    if not CHECK.exists():
        return ""
    last = json.loads(CHECK.read_text())
    again = last.get("recounted", ())  # those that differed, once their rows of the table are new
    lines = "".join(f"\n- {text}" for text in last["differ"])
    rows = "whose rows were counted anew since" if again else "whose numbers are of an earlier version there"
    return (
        f"The last check counted {last['parts']} parts of {last['tasks']} of {last['of']} tasks anew; {len(last['differ'])} differed from the table, "
        f"{rows}:\n{lines}\n"
    )


def read_counts() -> dict[str, Counted]:
    """What earlier runs counted, by task."""
    if not COUNTS.exists():
        return {}
    rows = [
        Counted(
            **{
                **r,
                "attained": tuple(r["attained"]),
                "verdicts": tuple(r["verdicts"]),
                "lengths": IntervalLengths(**r["lengths"]) if r.get("lengths") else None,
            }
        )
        for r in json.loads(COUNTS.read_text())
    ]
    return {r.task: r for r in rows}


def line(row: Counted) -> str:
    outside = [kind for kind, v in zip(COLUMNS, row.verdicts) if v == "outside"]
    words = "claimed" if row.claimed else "not claimed"
    words += f": outside {', '.join(outside)}" if outside else ""
    beside = f"{row.lengths.ratio:.2f}" if row.lengths else "-"
    return (
        f"| {row.task} | {row.parts} | {' | '.join(f'{a:.1%}' for a in row.attained)} | {beside} | {words} |"
    )


def beside_oracles(rows: list[Counted]) -> str:
    """The column `length` in words, and where coverage above 95 % comes from."""
    found = [row.lengths for row in rows if row.lengths]
    if not found:
        return ""
    ratios = sorted(one.ratio for one in found)
    claimed = sorted(row.lengths.ratio for row in rows if row.lengths and row.claimed)
    held, own, oracle = (
        sum(getattr(one, k) for one in found) / len(found) for k in ("belts_held", "own_held", "oracle_held")
    )
    return f"""*Length* is the mean length of the intervals over the prior in lengths of the theoretical best, which knows which family of forms every part
came from, how the sizes of its forms are spread, and the noise: its interval is the central 95 % of the true values of the parts of that family that
indicated as much (and whose residuals are as large, where the inverse uses them). {len(ratios)} tasks: {ratios[0]:.2f} to {ratios[-1]:.2f} times the theoretical best,
the middle one {ratios[len(ratios) // 2]:.2f}; of the {len(claimed)} claimed ones {claimed[0]:.2f} to {claimed[-1]:.2f}, the middle one {claimed[len(claimed) // 2]:.2f}.

The bar over the prior was 93 to 97 %, and most tasks lie above it. Why, in means over the tasks: the theoretical best attains {oracle:.1%}; the
belts of the part's own family {own:.1%}, because they hold at every size of the form, also where a perfect part would do and only the upper end can
miss; the belts of both families together, which are given, {held:.1%}, because the family of a part is not known. Both are the
price of holding at a fixed form and for forms of another kind; shorter intervals with 95 % over the prior would fail there."""


def page(done: dict[str, Counted]) -> str:
    order = [f"{name}, {density} points" for name in TASKS for density in DENSITIES]
    rows = [done[task] for task in order if task in done]
    reasons: dict[str, list[str]] = {}
    for row in rows:
        if not row.claimed:
            reasons.setdefault(row.why, []).append(row.task)
    why = "\n".join(f"- {'; '.join(tasks)}: {reason}" for reason, tasks in reasons.items())
    return f"""# Coverage, counted

`make audit` (`python tools/audit_table.py`, 2000 parts a column, seed 7) wrote this page; `python tools/audit_table.py --check 100` counts
100 parts of every task and column anew in minutes and names what is out of date. Every task below was measured as many times per column as *parts* says, each time with another part and
another machine drawn from what is known, and the share of 95 % intervals that held the true value was counted. The columns: parts over
the whole prior (forms from nothing to 40 times the noise of the machine); forms of 0, 2, 6 and 20 times the noise; parts of another
family of forms that the inverse has never seen. *Claimed* is what `vcmm evaluate` says of itself (`coverage_claimed`); what is not claimed
is not decided. {len(rows)} of {len(order)} tasks are counted; the next run counts those that are missing or have too few parts, and
`--fresh` all of them. A count of 200 parts errs by 1.5 %, one of 2000 by 0.5 % (one standard deviation). How it works: [evaluate](evaluate.md).

This table counts the belts by themselves, on machines as they are stated. `vcmm audit` of a scenario also counts what users get: points of parts with form (sizes
and distances among them) are evaluated as a file is, on machines from perfect to the limit, and each row names the family that was drawn. A judge that
shares nothing with vcmm counts too: [referee](referee.md).

{up_to_date()}
| task | parts | {" | ".join(COLUMNS)} | length | coverage |
|---|---|---|---|---|---|---|---|---|---|
{chr(10).join(line(row) for row in rows)}

Bands of a claimed coverage: 93 to 99 % over the prior (the interval holds each of two families, so it holds more of both together), at
least 93 % at every fixed form, at least 90 % for the other family. *Outside* is the verdict of an exact binomial test against the nearer end
of the band (below 2.5 %); of {6 * len(rows)} counts some lie a little outside by chance.

{beside_oracles([row for row in rows if row.lengths])}

Not claimed, by what the task says of itself before it is audited:

{why}
"""


if __name__ == "__main__":
    sys.exit(main())
