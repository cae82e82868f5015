"""What `vcmm diagnose --out` writes, beside plain least squares on the same rows. One line per recording.

    VCMM_DATA=folder python tools/written_files.py [NAME ...] [--seed 1] [--markdown]

Every folder of data/recordings_2 is diagnosed by the command, and the machine file that it writes is judged by `vcmm compare`: rms
of all rows as they are, the nuisance refitted, nothing clipped. Least squares: the terms that the README of the data says the
rows support (SUPPORTED), sizes and time constants fitted to the same rows. fit: what the diagnosis reports of its written file.
"""

from __future__ import annotations

import argparse
import json
import os
import subprocess
import sys
import tempfile
import time
from collections.abc import Sequence
from dataclasses import replace
from pathlib import Path
from typing import Any

import numpy as np

ROOT = Path(__file__).resolve().parent.parent
sys.path.insert(0, str(ROOT))

from vcmm.core.run import Array  # noqa: E402
from vcmm.files.own.machine import load_machine  # noqa: E402
from vcmm.files.own.recording import load_recording  # noqa: E402
from vcmm.learn.diagnosis.comparison import compare_machines  # noqa: E402
from vcmm.learn.diagnosis.problem import Problem, make_problem  # noqa: E402
from vcmm.physics import BY_NAME  # noqa: E402

Term = dict[str, Any]
PLACES: Term = {"effect": "places"}  # one number per target, whatever the sense
REVERSALS: Term = {"effect": "reversals"}  # one number per target, times the sense


def drift(sensor: str, *lags: float) -> list[Term]:
    return [{"effect": "thermal_drift", "direction": "z", "sensor": sensor, "tau": lag} for lag in lags]


def one(effect: str, **place: str) -> Term:
    return {"effect": effect, **place}


def turns(*harmonics: int) -> list[Term]:
    return [{"effect": "harmonic", "order": h} for h in harmonics]


HEAT = [*drift("column", 600.0), *drift("table", 600.0)]
PLATE = [one("scale_factor", axis="X"), one("scale_factor", axis="Y"), one("squareness", pair="C0Y")]
BALL_BAR = [one("squareness", pair="C0Y"), one("backlash", axis="Y")]
SUPPORTED: dict[str, list[Term]] = {
    "heatK": drift("table", 400.0, 15000.0),
    "synK": drift("table", 310.0, 18200.0),
    "heatC": HEAT,
    "heatC1": HEAT,
    "heatC2": HEAT,
    "s60res": [one("backlash", axis="X")],
    "syn_c": [one("backlash", axis="X")],
    "syn1": [one("backlash", axis="X")],
    "s60laser": [PLACES],
    "plateA": PLATE,
    "plateB": PLATE,
    "rot1": [one("servo_lag", axis="A"), *turns(1, 2, 4)],
    "mcuA": [PLACES, REVERSALS],
    "mcuB": [PLACES, REVERSALS],
    "square": [one("squareness", pair="C0Y")],
    "square_ok": [one("squareness", pair="C0Y")],
    "dialz": [
        one("backlash", axis="Z"),
        {"effect": "reversal_spike", "axis": "Z", "shape": "exponential", "distance": 0.05},
    ],
    "lin3": [one("backlash", axis="Y"), one("scale_factor", axis="Y")],
    "ballbar": BALL_BAR,
    "ballbar100": BALL_BAR,
    "diagonal_one": BALL_BAR,
    "diagonal_two": BALL_BAR,
}


def least_squares(problem: Problem, terms: Sequence[Term]) -> float:
    """rms of all rows after the terms and the nuisance, sizes linear, time constants and distances by a simplex."""
    from scipy.optimize import minimize

    def left(logs: Array) -> float:
        columns = [problem.nuisance]
        values = iter(np.exp(logs))
        columns += [_columns(problem, t, values) for t in terms]
        whole = np.concatenate(columns, axis=1)
        length = np.linalg.norm(whole, axis=0)
        x = (whole / np.where(length > 0, length, 1.0)) / problem.u[:, None]
        fit = np.linalg.lstsq(x, problem.residual / problem.u, rcond=1e-10)[0]
        rest = problem.residual - (x @ fit) * problem.u
        return float(np.sqrt(np.mean(rest**2)))

    start = np.log([float(t[k]) for t in terms for k in ("tau", "distance") if k in t] or [1.0])
    if not any("tau" in t or "distance" in t for t in terms):
        return left(start)
    tries = [minimize(left, start + step, method="Nelder-Mead").fun for step in (0.0, -1.0, 1.0)]
    return float(min(tries))


def _columns(problem: Problem, term: Term, scanned: Any) -> Array:
    axis = max(problem.run.position, key=lambda a: float(np.ptp(problem.run.position[a])))
    q = problem.per_observation(problem.run.position[axis])
    if term["effect"] in ("places", "reversals"):
        at = (np.round(q, 6)[:, None] == np.unique(np.round(q, 6))).astype(float)
        sense = problem.per_observation(problem.run.columns[f"sense_{axis}"])[:, None]
        return at * (sense if term["effect"] == "reversals" else 1.0)
    if term["effect"] == "harmonic":
        return np.column_stack([np.cos(term["order"] * q), np.sin(term["order"] * q)])
    effect = BY_NAME[term["effect"]](**{k: v for k, v in term.items() if k not in ("effect", "tau")})
    if "tau" in term:
        effect = replace(effect, tau=float(next(scanned)))
    if hasattr(effect, "distance"):
        effect = replace(effect, distance=float(next(scanned, effect.distance)))
    names = {"thermal_drift": "k", "backlash": "gap", "squareness": "angle", "scale_factor": "k",
             "servo_lag": "lag", "reversal_spike": "height"}  # fmt: skip
    return problem.columns(effect, [names[term["effect"]]])


def row(folder: Path, seed: int) -> list[str]:
    """The cells of one recording."""
    unit = 1e3
    recording, machine = load_recording(folder / "recording.toml")
    problem = make_problem(recording, machine)
    if recording.kind == "angle":
        unit = 1e6
    best = least_squares(problem, SUPPORTED.get(folder.name, [])) * unit
    with tempfile.TemporaryDirectory() as work:
        start = time.perf_counter()
        code = "from vcmm.face.cli import main; main()"
        words = ["diagnose", str(folder / "recording.toml"), "--seed", str(seed), "--json", "--out", work]
        done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True)
        seconds = time.perf_counter() - start
        before = compare_machines("own", [(recording, machine)]).rms * unit
        if done.returncode:
            return [folder.name, f"exit {done.returncode}: {done.stderr.strip()[-160:]}", f"{before:.4g}", "-", "-",
                    f"{best:.4g}", "-", f"{seconds:.0f} s"]  # fmt: skip
        found = json.loads(done.stdout)
        written = Path(work) / "machine.toml"
        after = before
        if written.is_file():
            after = (
                compare_machines(
                    "written", [load_recording(folder / "recording.toml", load_machine(written))]
                ).rms
                * unit
            )
    fit = found["fit"]
    candidates = fit.get("candidates_rms_um")
    shown = f"{fit['rms_after_um']:.6g}" + (f" ({candidates:.4g})" if candidates is not None else "")
    return [folder.name, said(found), f"{before:.4g}", shown, f"{after:.6g}", f"{best:.4g}", f"{after / best:.2f}",
            f"{seconds:.0f} s"]  # fmt: skip


def said(found: dict[str, Any]) -> str:
    """Verdict, names, rivals, what to measure next."""
    names = []
    for a in found["answer"]:
        where = " ".join(str(v) for v in a["where"].values())
        values = ", ".join(
            f"{k} {v['value']:.3g}±{v['u']:.2g} {v['unit']}" for k, v in a["parameters"].items()
        )
        rivals = f" or {', '.join(a['cannot_be_told_from'])}" if a["cannot_be_told_from"] else ""
        doubt = "?" if a["doubtful"] else ""
        names.append(f"{doubt}{a['effect']} {where} [{values}] p {a['probability']:.2f}{rivals}")
    unknown = f"; unknown over {', '.join(found['unknown']['covariates'])}" if found["unknown"] else ""
    following = f"; next: {found['next_measurement'][0]['do']}" if found["next_measurement"] else ""
    pulls = [
        f"{p['input']} {p['pull']:.1f}" for p in found.get("calibration_pulls", ()) if abs(p["pull"]) > 3
    ]
    pulled = f"; pulls {', '.join(pulls)}" if pulls else ""
    return f"{found['verdict']}: {'; '.join(names) or 'no name'}{unknown}{pulled}{following}"


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="folders of data/recordings_2; all by default")
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--brief", action="store_true", help="without what was said")
    args = parser.parse_args()
    data = os.environ.get("VCMM_DATA")
    if not data:
        print("VCMM_DATA is not set: it names the folder that holds data/recordings_2", file=sys.stderr)
        return 3
    top = Path(data) / "data" / "recordings_2"
    head = ["recording", "said", "before", "fit (candidates)", "written", "least squares", "ratio", "time"]
    print("| " + " | ".join(h for h in head if not (args.brief and h == "said")) + " |")
    print("|" + "---|" * (len(head) - args.brief))
    for name in args.names or sorted(p.name for p in top.iterdir() if p.is_dir()):
        cells = row(top / name, args.seed)
        print(
            "| " + " | ".join(c for i, c in enumerate(cells) if not (args.brief and i == 1)) + " |",
            flush=True,
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
