"""Counts one cell: simulated parts go through the command line, and what it claims is held against the truth.

Bounds are those of Clopper and Pearson (Biometrika 26, 1934, 404), 95 %, two-sided.
"""

from collections import Counter
from itertools import pairwise
from pathlib import Path

import numpy as np
from numpy.typing import NDArray
from scipy.stats import beta

from referee import files, simulate
from referee.tasks import TASKS

Array = NDArray[np.float64]
BATCH = 60  # parts in one file
BINS = (0.0, 0.05, 0.2, 0.5, 0.8, 0.95, 1.0)


def bounds(right: int, count: int) -> tuple[float, float]:
    """Exact 95 % bounds of a share."""
    if count == 0:
        return 0.0, 1.0
    low = float(beta.ppf(0.025, right, count - right + 1)) if right else 0.0
    high = float(beta.ppf(0.975, right + 1, count - right)) if right < count else 1.0
    return low, high


def prepare(folder: Path, seed: int, cell: str, task: str, machine: str, forms: dict | None = None) -> Array:
    """Write machine and scenario of a cell; the table of known errors comes back."""
    known = simulate.table(seed, cell)
    certificate = files.CERTIFICATE if machine.startswith("cert_") else None
    files.machine_file(folder, certificate, simulate.NOISES.get(machine, {}).get("dof", np.inf), known)
    files.scenario_file(folder, TASKS[task], simulate.nominal(TASKS[task]), forms=forms)
    return known


def stated_forms(task: str, family: str) -> dict | None:
    """The form that the scenario states, where the family is a stated one."""
    if family != "known_lobes":
        return None
    return dict.fromkeys(TASKS[task].features, '{ lobes = 3, amplitude = "1 um" }')


def conforms(task: str, name: str, true: float) -> bool:
    """Whether a true value keeps the tolerance of the drawing."""
    line = next(c for c in TASKS[task].characteristics if c.name == name)
    if "zone" in line.keys:
        return true <= line.keys["zone"]
    low, high = line.keys["limits"]
    return line.nominal + low <= true <= line.nominal + high


def judged(folder: Path, seed: int, cell: str, parts: int) -> dict:
    """Measure the parts of a cell, ask the command line, and put truth and answer side by side.

    Returns
    -------
    dict
        By characteristic a list of dictionaries: truth, own, interval, claimed, decision, p, conforms, measured, why.
    """
    _, task, family, machine = cell.split("/")
    known = prepare(folder, seed, cell, task, machine, stated_forms(task, family))
    digits = simulate.NOISES.get(machine, {}).get("digits", 0.0)
    result: dict = {c.name: [] for c in TASKS[task].characteristics}
    for start in range(0, parts, BATCH):
        measured = [
            simulate.measure(seed, cell, i, task, family, machine, known)
            for i in range(start, min(parts, start + BATCH))
        ]
        name = f"points{start}.csv"
        files.points_file(folder / name, [m.points for m in measured], digits)
        document = files.call(folder, "evaluate", "scenario.toml", "--points", name, "--seed", str(seed))
        for part, answer in zip(measured, document.get("parts", [document])):
            for line in answer["characteristics"]:
                result[line["name"]].append(record(task, part, line))
    return result


def record(task: str, part: simulate.Measured, line: dict) -> dict:
    """One characteristic of one part: what is true and what was claimed."""
    name = line["name"]
    true = line.get("true_value") or {
        "interval_mm": line["interval_mm"],
        "coverage_claimed": line["coverage_shown"],
    }
    low, high = true["interval_mm"]
    return {
        "truth": part.truth[name],
        "own": part.value[name],
        "low": -np.inf if low is None else low,
        "high": np.inf if high is None else high,
        "claimed": bool(true["coverage_claimed"]) and bool(line["coverage_shown"]),
        "decision": line["decision"],
        "p": line["p_conform"],
        "conforms": conforms(task, name, part.truth[name]),
        "measured": line.get("measured_mm"),
        "why": (true.get("reason") or line.get("why_not_shown") or "")[:160],
    }


def oracle(own: Array, truth: Array, form: bool) -> float:
    """Median length of the interval of one who knows family and machine: 95 % of true values at such a reading.

    Errors of sizes are those of all parts; forms are compared with the fifth of parts that read most nearly alike.
    """
    error = truth - own
    if not form:
        return float(np.ptp(np.quantile(error, [0.025, 0.975])))
    near = max(20, len(own) // 5)
    lengths = []
    for reading in own:
        chosen = np.argsort(np.abs(np.log(own) - np.log(reading)))[:near]
        lengths.append(np.ptp(np.quantile(error[chosen], [0.025, 0.975])))
    return float(np.median(lengths))


def evaluate(folder: Path, seed: int, cell: str, parts: int) -> list[dict]:
    """Rows of an `evaluate` cell: true values held, decisions, lengths."""
    rows = []
    for name, records in judged(folder, seed, cell, parts).items():
        claimed = [r for r in records if r["claimed"]]
        misses = [
            i for i, r in enumerate(records) if r["claimed"] and not r["low"] <= r["truth"] <= r["high"]
        ]
        accepted = [r for r in records if r["decision"] == "conforms"]
        rejected = [r for r in records if r["decision"] == "does not conform"]
        own, truth = (np.array([r[k] for r in records]) for k in ("own", "truth"))
        lengths = [r["high"] - r["low"] for r in claimed]
        whys = Counter(r["why"] for r in records if not r["claimed"])
        departures = [abs(r["measured"] - r["own"]) for r in records if r["measured"] is not None]
        rows.append(
            {
                "characteristic": name,
                "n": len(records),
                "claimed": len(claimed),
                "held": len(claimed) - len(misses),
                "accepted": len(accepted),
                "bad": sum(not r["conforms"] for r in accepted),
                "rejected": len(rejected),
                "good": sum(r["conforms"] for r in rejected),
                "length_um": 1e3 * float(np.median(lengths)) if lengths else None,
                "oracle_um": 1e3 * oracle(own, truth, "size" not in name and name not in ("step", "apart")),
                "fits_um": 1e3 * max(departures) if departures else None,
                "misses": [
                    {
                        "part": i,
                        **{
                            k: 1e3 * (records[i][k] - offset(records[i]))
                            for k in ("low", "truth", "high", "own")
                        },
                    }
                    for i in misses[:5]
                ],
                "why": whys.most_common(1)[0][0] if whys else "",
            }
        )
    return rows


def offset(record: dict) -> float:
    """Nominal of a large dimension, so that misses are printed in um about it."""
    return float(round(record["truth"])) if record["truth"] > 1 else 0.0


def decide(folder: Path, seed: int, cell: str, parts: int) -> list[dict]:
    """Rows of a `decide` cell: in each bin of p_conform how many parts conform.

    A bin is right when the stated probability lies within the exact bounds of the share found (`claimed` is then
    what p_conform promises, `held` what conforms).
    """
    rows = []
    for name, records in judged(folder, seed, cell, parts).items():
        silent = [r["why"] for r in records if r["p"] is None]
        if silent:
            rows.append({"characteristic": f"{name}, no p", "n": len(silent), "claimed": 0, "why": silent[0]})
        for low, high in pairwise(BINS):
            inside = [
                r
                for r in records
                if r["p"] is not None and (low <= r["p"] < high or (high == 1.0 and r["p"] == 1.0))
            ]
            if inside:
                rows.append(
                    {
                        "characteristic": f"{name}, p {low} to {high}",
                        "n": len(inside),
                        "claimed": round(float(sum(r["p"] for r in inside)), 1),
                        "held": sum(r["conforms"] for r in inside),
                        "accepted": sum(r["decision"] == "conforms" for r in inside),
                        "bad": sum(r["decision"] == "conforms" and not r["conforms"] for r in inside),
                    }
                )
    return rows


def beforehand(folder: Path, seed: int, cell: str, parts: int) -> list[dict]:
    """Rows of an `uncertainty` cell: U beforehand against the errors of simulated measurements."""
    _, task, family, machine = cell.split("/")
    known = prepare(folder, seed, cell, task, machine, stated_forms(task, family))
    document = files.call(folder, "uncertainty", "scenario.toml", "--trials", "20000", "--seed", str(seed))
    measured = [simulate.measure(seed, cell, i, task, family, machine, known) for i in range(parts)]
    rows = []
    for line in document["characteristics"]:
        if line["type"] not in ("size", "distance"):
            continue
        name = line["name"]
        shift = line["bias_mm"] if line["bias_corrected"] else 0.0
        low, high = (end - line["value_mm"] for end in line["interval_mm"])
        error = np.array([m.truth[name] - m.value[name] + shift for m in measured])
        held = int(np.sum((low <= error) & (error <= high))) if line["coverage_shown"] else 0
        rows.append(
            {
                "characteristic": name,
                "n": parts,
                "claimed": parts if line["coverage_shown"] else 0,
                "held": held,
                "length_um": 1e3 * (high - low),
                "oracle_um": 1e3 * float(np.ptp(np.quantile(error, [0.025, 0.975]))),
                "why": line.get("why_not_shown") or "",
            }
        )
    return rows
