"""What `vcmm diagnose --out` says and writes of data/recordings_3, beside least squares that share nothing with the package.

    VCMM_DATA=folder python tools/count_recordings.py [NAME ...] [--seed 0]

Least squares read the CSV by themselves: numpy alone, columns as the README of the data says the rows support them. ratio: rms that the
written machine file leaves (as the command reads it back) over theirs. right: every thing that the rows support is found at its place and
nothing else; open: nothing else is found, and the verdict says that something is left, or what is found is not claimed with 0.9;
wrong: else.
"""

from __future__ import annotations

import argparse
import csv
import json
import os
import subprocess
import sys
import tempfile
from collections.abc import Callable, Mapping, Sequence
from dataclasses import dataclass
from pathlib import Path
from typing import Any

import numpy as np
import numpy.typing as npt

Array = npt.NDArray[np.float64]
Table = Mapping[str, Any]
PLAY = ("backlash", "lost_motion", "hysteresis")
LENGTH = ("scale_factor", "geometric_change", "cosine_error")
HARMONIC = ("rotary_cyclic", "encoder_interpolation", "screw_pitch")
CLAIMED = 0.9  # a probability with which a wrong name is wrong, and not open
GOOD = 1.15  # times least squares


@dataclass(frozen=True)
class Known:
    """what the rows support in words, the names that say it (each group once at least), and rms by least squares in um or urad."""

    supports: str
    names: tuple[tuple[str, ...], ...]
    best: Callable[[Table], float]
    further: tuple[str, ...] = ()  # names that say the same in finer shapes


def table(path: Path) -> Table:
    """Columns of a CSV file: numbers, or texts where they are none."""
    with path.open() as file:
        rows = list(csv.DictReader(file))
    out: dict[str, Any] = {}
    for name in rows[0]:
        cells = [r[name] for r in rows]
        try:
            out[name] = np.array([float(c) for c in cells])
        except ValueError:
            out[name] = np.array(cells)
    return out


def left(value: Array, columns: Sequence[Array]) -> float:
    x = np.column_stack([np.ones(len(value)), *columns])
    x = x / np.linalg.norm(x, axis=0)
    return float(np.sqrt(np.mean((value - x @ np.linalg.lstsq(x, value, rcond=None)[0]) ** 2)))


def positioning(t: Table) -> float:
    d = 1e3 * (t["actual_mm"] - t["target_mm"])
    return left(d, [np.where(t["direction"] == "up", 1.0, -1.0), t["target_mm"]])


def lagged(time: Array, value: Array, tau: float) -> Array:
    """First order, steady before the first reading, linear between readings."""
    out = np.empty_like(value)
    out[0] = value[0]
    for k in range(1, len(value)):
        step = time[k] - time[k - 1]
        slope = (value[k] - value[k - 1]) / step if step > 0 else 0.0
        out[k] = value[k] - slope * tau + (out[k - 1] - value[k - 1] + slope * tau) * np.exp(-step / tau)
    return out


def heating(t: Table) -> float:
    order = np.argsort(t["time_s"], kind="stable")
    time, frame, bed = (t[n][order] for n in ("time_s", "temp_column_C", "temp_table_C"))
    lags = np.geomspace(60.0, 2e4, 60)
    return min(left(t["d_um"][order], [frame, bed, lagged(time, bed, tau)]) for tau in lags)


def harmonics(t: Table) -> float:
    b = np.deg2rad(t["B_deg"])
    waves = [f(k * b) for k in (1, 2, 3, 4) for f in (np.cos, np.sin)]
    return left(t["d_urad"], [*waves, t["sense_B"]])


def proportion(t: Table) -> float:
    return left(t["d_urad"], [t["B_deg"], t["sense_B"]])


def play(t: Table) -> float:
    """The operator of play at its best half width, the slide on one side at first."""
    q = np.deg2rad(t["A_deg"])

    def follower(r: float) -> Array:
        p, out = q[0] - r, np.empty(len(q))
        for k, x in enumerate(q):
            p = max(x - r, min(x + r, p))
            out[k] = p - x
        return out

    return min(left(t["d_urad"], [follower(r)]) for r in np.linspace(5e-5, 6e-4, 56))


AXIS = Known("play and scale", (PLAY, LENGTH), positioning)
KNOWN = {
    "strB": AXIS,
    "strC": AXIS,
    "strD": AXIS,
    "heatB": Known("frame, bed, bed with a lag", (("thermal_drift z column",), ("thermal_drift z table",)), heating),
    "mountG": Known(
        "index, tilts, squareness, flexure; harmonics", (("gravity_flexure",),), lambda t: 709.0,
        (*HARMONIC, "rotary_location", "geometric_change", "squareness"),
    ),
    "enc1b": Known("four harmonics and a reversal", (HARMONIC, PLAY), harmonics),
    "enc5c": Known("proportion and play", (LENGTH, PLAY), proportion, HARMONIC),
    "tankF": Known("a play operator", (PLAY,), play, ("scale_factor",)),
}  # fmt: skip


def ids_of(answer: Mapping[str, Any]) -> set[str]:
    """Its effect, and its effect with its place."""
    return {answer["effect"], " ".join((answer["effect"], *map(str, answer["where"].values())))}


def outcome(known: Known, found: Mapping[str, Any]) -> str:
    """right, open or wrong, by the head of this file."""
    names = [a for a in found["answer"] if not a["doubtful"]]
    allowed = {n for group in known.names for n in group} | set(known.further)
    foreign = [a for a in names if not ids_of(a) & allowed]
    if any(a["probability"] >= CLAIMED for a in foreign):
        return "wrong"
    lacks = [g for g in known.names if not any(ids_of(a) & set(g) for a in names)]
    if not lacks and not foreign:
        return "right"
    return "wrong" if found["verdict"] in ("explained", "nothing missing") else "open"


def row(folder: Path, seed: int) -> list[str]:
    known = KNOWN[folder.name]
    with tempfile.TemporaryDirectory() as work:
        code = "from vcmm.face.cli import main; main()"
        words = ["diagnose", str(folder / "recording.toml"), "--seed", str(seed), "--json", "--out", work]
        done = subprocess.run([sys.executable, "-c", code, *words], capture_output=True, text=True)
    best = known.best(table(folder / "data.csv"))
    if done.returncode:
        return [folder.name, known.supports, f"exit {done.returncode}", "-", f"{best:.4g}", "-", "lost"]
    found = json.loads(done.stdout)
    before, after = found["fit"]["rms_before_um"], found["fit"]["rms_after_um"]
    names = ", ".join(
        f"{a['effect']} {' '.join(map(str, a['where'].values()))} {max(a['probability'], a['family_probability']):.2f}"
        for a in found["answer"]
        if not a["doubtful"]
    )
    ratio = after / best
    how = outcome(known, found) + ("" if ratio <= GOOD else f", {ratio:.2f} times least squares")
    return [folder.name, known.supports, f"{found['verdict']}: {names or 'no name'}", f"{before:.4g} to {after:.4g}",
            f"{best:.4g}", f"{ratio:.2f}", how]  # fmt: skip


def main() -> int:
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="folders of data/recordings_3; all by default")
    parser.add_argument("--seed", type=int, default=0)
    args = parser.parse_args()
    data = os.environ.get("VCMM_DATA")
    if not data:
        print("VCMM_DATA is not set: it names the folder that holds data/recordings_3", file=sys.stderr)
        return 3
    print(
        "| recording | what its rows support | found, with probability | rms, um or urad | least squares | ratio | outcome |"
    )
    print("|" + "---|" * 7)
    for name in args.names or KNOWN:
        print(
            "| " + " | ".join(row(Path(data) / "data" / "recordings_3" / name, args.seed)) + " |", flush=True
        )
    return 0


if __name__ == "__main__":
    sys.exit(main())
