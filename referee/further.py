"""Counts of a certificate's monotony and of the gain that a better place promises."""

from pathlib import Path

import numpy as np

from referee import files, machines, simulate
from referee.kinematics import pose
from referee.tasks import TASKS, value

WORSE = {
    "E0 twice": ("fixed", "slope"),
    "R0 twice": ("r0",),
    "P_Form twice": ("form",),
    "P_Size twice": ("size",),
}


def monotone(folder: Path, seed: int, cell: str, parts: int) -> list[dict]:
    """Rows of a `monotone` cell: a worse limit gives no shorter interval and no better decision.

    The same readings are evaluated under a certificate and under worse ones. An end may move by three of its own
    printed standard uncertainties or 3 % of the length, whichever is more.
    """
    _, task, family, machine = cell.split("/")
    parts = min(parts, 20)
    files.scenario_file(folder, TASKS[task], simulate.nominal(TASKS[task]))
    known = simulate.table(seed, cell)
    measured = [simulate.measure(seed, cell, i, task, family, machine, known) for i in range(parts)]
    files.points_file(folder / "points0.csv", [m.points for m in measured])

    def ask(certificate: dict) -> list[dict]:
        files.machine_file(folder, certificate)
        document = files.call(
            folder, "evaluate", "scenario.toml", "--points", "points0.csv", "--seed", str(seed)
        )
        return [{c["name"]: c for c in p["characteristics"]} for p in document.get("parts", [document])]

    first = ask(files.CERTIFICATE)
    rows = []
    for label, keys in WORSE.items():
        second = ask({k: v * (2 if k in keys else 1) for k, v in files.CERTIFICATE.items()})
        for line in TASKS[task].characteristics:
            pairs = [(a[line.name], b[line.name]) for a, b in zip(first, second)]
            wrong = [i for i, (a, b) in enumerate(pairs) if not _no_better(a, b)]
            rows.append(
                {
                    "characteristic": f"{line.name}, {label}",
                    "n": parts,
                    "claimed": parts,
                    "held": parts - len(wrong),
                    "misses": [{"part": i} for i in wrong[:5]],
                    "length_um": _median([b for _, b in pairs]),
                    "oracle_um": _median([a for a, _ in pairs]),
                    "why": "length: under the worse limit, oracle: under the first",
                }
            )
    files.machine_file(folder, files.CERTIFICATE)
    return rows


def _ends(line: dict) -> tuple[float, float]:
    low, high = (line.get("true_value") or line)["interval_mm"]
    return -np.inf if low is None else low, np.inf if high is None else high


def _median(lines: list[dict]) -> float:
    return 1e3 * float(np.median([_ends(x)[1] - _ends(x)[0] for x in lines]))


def _no_better(first: dict, second: dict) -> bool:
    """Whether the second answer is no shorter and no more decided than the first."""
    a, b = (e[1] - e[0] for e in (_ends(first), _ends(second)))
    spread = [
        u or 0.0
        for x in (first, second)
        for u in ((x.get("true_value") or {}).get("interval_u_mm") or [0, 0])
    ]
    if b < a - max(0.03 * a, 3 * float(np.linalg.norm(spread))):
        return False
    if first["decision"] == "undecided":
        return second["decision"] == "undecided"
    return second["decision"] in (first["decision"], "undecided")


PLACEMENT = """
[placement]
x = ["150 mm", "450 mm"]
y = ["150 mm", "350 mm"]
objective = "U"
"""


def place(folder: Path, seed: int, cell: str, parts: int) -> list[dict]:
    """Rows of a `place` cell: the gain in U of the first characteristic against that of an own simulation.

    The place found is held against the present one and the worst that was seen.

    Machines come from the stated law about a known table; U is half of the central 95 % of errors of five times as
    many simulated measurements as parts (never fewer than 600) of a perfect part. Right is a promise within 5 % of U plus three
    standard errors of the simulation.
    """
    _, task, _, machine = cell.split("/")
    known = simulate.table(seed, cell)
    files.machine_file(folder, None, table=known)
    plan = TASKS[task]
    files.scenario_file(folder, plan, simulate.nominal(plan), extra=PLACEMENT)
    words = ("--evaluations", "300", "--scan", "128", "--trials", "5000", "--seed", str(seed))
    document = files.call(folder, "place", "scenario.toml", *words)
    count = max(600, 5 * parts)
    name = plan.characteristics[0].name
    found = [(document["pose"], document["objective"])]
    found += [(document[k]["pose"], document[k]) for k in ("present", "worst")]
    promised, own = [], []
    for place_, answer in found:
        promised.append(next(c["U_mm"] for c in answer["characteristics"] if c["name"] == name))
        frame = pose(np.array(place_["shift_mm"]), np.array(place_["turn_deg"]))
        own.append(_spans(seed, cell, task, machine, known, frame, count))
    rows = []
    for label, other in (("present", 1), ("worst", 2)):
        gain = 1 - promised[0] / promised[other]
        seen = 1 - own[0][0] / own[other][0]
        error = (1 - seen) * float(np.hypot(own[0][1] / own[0][0], own[other][1] / own[other][0]))
        rows.append(
            {
                "characteristic": f"{name}, gain against {label} {gain:.3f}, own {seen:.3f} +- {error:.3f}",
                "n": 1,
                "claimed": 1,
                "held": int(abs(gain - seen) <= 0.05 + 3 * error),
                "length_um": 2e3 * own[0][0],
                "oracle_um": 2e3 * own[other][0],
                "why": f"length: 2 U at the place found, oracle: at the {label} one, both by own simulation",
            }
        )
    return rows


def _spans(
    seed: int, cell: str, task: str, machine: str, known: np.ndarray, frame: tuple, count: int
) -> tuple:
    """Half of the central 95 % of the errors of the first characteristic at a pose, and its standard error."""
    plan = TASKS[task]
    line = plan.characteristics[0]
    touches = simulate.nominal(plan)
    names = list(touches)
    points = np.concatenate([touches[n][0] for n in names])
    normals = np.concatenate([touches[n][1] for n in names])
    cuts = np.cumsum([len(touches[n][0]) for n in names])[:-1]
    values = np.empty(count)
    for i in range(count):
        rng = simulate.stream(seed, cell, i)
        drawn = simulate.draw_machine(rng, machine, known)
        read = machines.touch(rng, drawn, points, normals, frame)
        values[i] = value(line, plan.features, dict(zip(names, np.split(read, cuts))))
    half = 0.5 * float(np.ptp(np.quantile(values, [0.025, 0.975])))
    groups = [0.5 * np.ptp(np.quantile(g, [0.025, 0.975])) for g in np.array_split(values, 10)]
    return half, float(np.std(groups, ddof=1) / np.sqrt(10))
