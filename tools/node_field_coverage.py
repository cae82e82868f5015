"""How often the interval of a distance holds the truth on machines whose residual field was found at nodes.

Truth, readings and values are made here, without a line of vcmm; the answers are those of the command line: `vcmm calibrate --nodes`, then
`vcmm evaluate --values` with the known bias taken off. A machine errs by sums of waves (no Gaussian process) that come back every time, and each approach
adds a normal error whose size changes over the volume and whose X and Y go together by 0.7. Five stations of a laser tracer read 48 nodes with 14
approaches, each station in a run of its own, 0.1 um of noise per length; then a part of 189 mm between two faces of 2 x 2 touches is measured.

    python tools/node_field_coverage.py [machines, default 20] [first, default 0] [folder]
"""

from __future__ import annotations

import json
import subprocess
import sys
import tempfile
from pathlib import Path

import numpy as np
from scipy.stats import beta

LENGTH, TOUCHES, APPROACHES, NOISE = 189.0, 4, 14, 1e-4
STATIONS = np.array(
    [[-180.0, -140, 60], [1150, -150, 90], [1160, 950, 40], [-170, 930, 120], [480, 390, 1100]]
)
AXES = (np.linspace(50, 950, 4), np.linspace(50, 750, 3), np.linspace(50, 500, 4))
NODES = np.array(np.meshgrid(*AXES, indexing="ij")).reshape(3, -1).T
PLACES = {
    "1": (200, 200, 120),
    "2": (500, 400, 250),
    "3": (800, 620, 400),
    "4": (330, 560, 300),
    "5": (700, 230, 180),
}
HEAD = (
    'vcmm = "machine/1"\nname = "drawn"\nkind = "cmm"\nstructure = "w b Y X Z t"\n'
    '[axes.X]\ntravel = ["0 mm", "1000 mm"]\n[axes.Y]\ntravel = ["0 mm", "800 mm"]\n[axes.Z]\ntravel = ["0 mm", "600 mm"]\n'
)
RECORDING = (
    'vcmm = "recording/1"\nname = "tracer"\ndata = "tracer.csv"\nmachine = "machine.toml"\nkind = "length"\nobserved = "indicated - true"\n'
    '[nuisance]\nstation = "setup"\nzero = "setup"\n[noise]\nlaw = "normal"\nu = "0.1 um"\n'
)
SCENARIO = """vcmm = "scenario/1"
name = "two faces"
machine = "field.toml"
[part]
expansion = "0 um/(m K)"
[part.features]
left = {{ type = "plane", point = "-94.5 0 0 mm", normal = [-1, 0, 0], size = "100 80 mm" }}
right = {{ type = "plane", point = "94.5 0 0 mm", normal = [1, 0, 0], size = "100 80 mm" }}
[[part.characteristics]]
name = "distance"
type = "distance"
between = ["left", "right"]
limits = ["-0.01 mm", "0.01 mm"]
[pose]
shift = "{0} {1} {2} mm"
[plan]
styli.down = {{ offset = "0 0 0 mm", tip_diameter = "4 mm" }}
[[plan.steps]]
feature = "left"
stylus = "down"
points = {{ strategy = "grid", n = [2, 2], margin = "10 mm" }}
[[plan.steps]]
feature = "right"
stylus = "down"
points = {{ strategy = "grid", n = [2, 2], margin = "10 mm" }}
[job]
trials = 4000
seed = 1
known_bias = "corrected"
"""


class DrawnMachine:
    """Waves of 350 to 1500 mm per direction, together 0.2 to 1 um rms; s of one approach 0.3 to 1.2 um, changing by waves too."""

    def __init__(self, rng: np.random.Generator) -> None:
        self.waves = [self._waves(rng) for _ in range(3)]
        self.rms = rng.uniform(0.2e-3, 1e-3, 3)
        self.level, self.change = rng.uniform(0.3e-3, 1.2e-3, 3), self._waves(rng)
        self.swing = rng.uniform(0.0, 0.5)

    @staticmethod
    def _waves(rng: np.random.Generator) -> tuple[np.ndarray, np.ndarray]:
        way = rng.standard_normal((12, 3))
        way *= (2 * np.pi / np.exp(rng.uniform(np.log(350), np.log(1500), 12)) / np.linalg.norm(way, axis=1))[
            :, None
        ]
        return way, rng.uniform(0, 2 * np.pi, 12)

    @staticmethod
    def _sum(waves: tuple[np.ndarray, np.ndarray], at: np.ndarray) -> np.ndarray:
        return np.sin(at @ waves[0].T + waves[1]).sum(axis=1) / np.sqrt(6)

    def systematic(self, at: np.ndarray) -> np.ndarray:
        return np.column_stack([r * self._sum(w, at) for r, w in zip(self.rms, self.waves)])

    def approach(self, at: np.ndarray, rng: np.random.Generator) -> np.ndarray:
        root = np.linalg.cholesky([[1, 0.7, 0], [0.7, 1, 0], [0, 0, 1]])
        s = self.level * np.exp(self.swing * self._sum(self.change, at))[:, None]
        return s * (rng.standard_normal((len(at), 3)) @ root.T)


def write_readings(machine: DrawnMachine, rng: np.random.Generator, folder: Path) -> None:
    rows = [
        "X_mm,Y_mm,Z_mm,offset_x_mm,offset_y_mm,offset_z_mm,from_x_mm,from_y_mm,from_z_mm,setup,repeat,nx,ny,nz,d_um"
    ]
    tips = np.repeat(NODES, APPROACHES, axis=0)
    for k, start in enumerate(STATIONS):
        actual = tips + machine.systematic(tips) + machine.approach(tips, rng)
        way = tips - start
        dead = rng.uniform(-0.05, 0.05)
        value = (
            np.linalg.norm(way, axis=1)
            - np.linalg.norm(actual - start, axis=1)
            + dead
            + NOISE * rng.standard_normal(len(tips))
        )
        n = way / np.linalg.norm(way, axis=1)[:, None]
        for i, tip in enumerate(tips):
            where = ",".join(f"{v:g}" for v in (*tip, 0, 0, 0, *start))
            rows.append(
                f"{where},s{k},a{i % APPROACHES:02d},{','.join(f'{v:.12f}' for v in n[i])},{value[i] * 1e3:.6f}"
            )
    (folder / "tracer.csv").write_text("\n".join(rows) + "\n")
    (folder / "tracer.toml").write_text(RECORDING)
    (folder / "machine.toml").write_text(HEAD)


def measured(machine: DrawnMachine, rng: np.random.Generator, shift: np.ndarray) -> float:
    """Distance of the mean points of the two faces of a perfect part, mm. Indicated = actual - tip error."""
    grid = np.array([[y, z] for y in (-40.0, 40) for z in (-30.0, 30)])
    mean = []
    for x in (-LENGTH / 2, LENGTH / 2):
        true = np.column_stack([np.full(TOUCHES, x), grid]) + shift
        mean.append(x - (machine.systematic(true) + machine.approach(true, rng))[:, 0].mean())
    return float(mean[1] - mean[0])


def asked(folder: Path, *words: str) -> dict:
    program = Path(sys.executable).parent / "vcmm"
    done = subprocess.run(
        [program, *words, "--json"], cwd=folder, capture_output=True, text=True, check=False
    )
    if done.returncode not in (0, 1):
        raise SystemExit(f"vcmm {' '.join(words)}: {done.stderr}")
    return json.loads(done.stdout)


def exact_bounds(k: int, n: int) -> tuple[float, float]:
    """Clopper-Pearson, 95 %."""
    low = 0.0 if k == 0 else beta.ppf(0.025, k, n - k + 1)
    return float(low), 1.0 if k == n else float(beta.ppf(0.975, k + 1, n - k))


def main(machines: int, first: int, folder: Path) -> None:
    held = raw = count = 0
    z, size, whole = [], [], []
    for m in range(first, first + machines):
        rng = np.random.default_rng([m, 2014])
        drawn = DrawnMachine(rng)
        write_readings(drawn, rng, folder)
        asked(
            folder, "calibrate", "tracer.toml", "--machine", "machine.toml", "--nodes", "--out", "field.toml"
        )
        here = 0
        for shift in PLACES.values():
            (folder / "job.toml").write_text(SCENARIO.format(*shift))
            value = measured(drawn, rng, np.array(shift, dtype=float))
            (folder / "values.csv").write_text(f"characteristic,value_mm\ndistance,{value:.9f}\n")
            one = asked(folder, "evaluate", "job.toml", "--values", "values.csv")["characteristics"][0]
            low, high = one["interval_mm"]
            inside = low <= LENGTH <= high
            held, here, count = held + inside, here + inside, count + 1
            raw += abs(value - LENGTH) <= one["U_mm"]
            size.append((high - low) / 2)
            z.append(((low + high) / 2 - LENGTH) / ((high - low) / 2))
        whole.append(here)
        low, high = exact_bounds(held, count)
        print(f"machine {m}: {here} of {len(PLACES)}; {held} of {count}: {held / count:.3f} ({low:.3f} to {high:.3f}), U {np.mean(size) * 1e3:.2f} um, "
              f"rms of error/U {np.sqrt(np.mean(np.square(z))):.2f}, bias left in: {raw}", flush=True)  # fmt: skip
    shares = np.array(whole) / len(PLACES)
    print(f"by machines: {shares.mean():.3f} +- {shares.std(ddof=1) / np.sqrt(len(shares)):.3f}")


if __name__ == "__main__":
    arguments = sys.argv[1:]
    number, start = (int(a) for a in [*arguments[:2], *("20", "0")[len(arguments[:2]) :]])
    with tempfile.TemporaryDirectory() as temporary:
        main(number, start, Path(arguments[2] if len(arguments) > 2 else temporary))
