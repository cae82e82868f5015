"""Processor time of a batch of parts: one after the other in calls of their own, and in one file.

python benchmarks/bench_batch.py            one run, both ways; ratios are of the same run
python benchmarks/bench_batch.py --profile  the file alone, and where its time goes
"""

from __future__ import annotations

import contextlib
import cProfile
import io
import pstats
import sys
import tempfile
import time
from collections.abc import Sequence
from pathlib import Path

import numpy as np

from vcmm.face.cli import run

HEAD = """vcmm = "scenario/1"
[machine]
structure = "w b Y X Z t"
[machine.axes.X]
travel = ["0 mm", "600 mm"]
[machine.axes.Y]
travel = ["0 mm", "500 mm"]
[machine.axes.Z]
travel = ["-400 mm", "0 mm"]
[machine.repeatability]
u = "0.4 um"
[[machine.effects]]
effect = "squareness"
pair = "B0Z"
angle = "0 urad"
[[machine.inputs]]
effect = "squareness"
pair = "B0Z"
parameter = "angle"
u = "3 urad"
[pose]
shift = "300 250 -200 mm"
[plan]
styli.down = { offset = "0 0 -100 mm", tip_diameter = "2 mm" }
[[plan.steps]]
feature = "top"
stylus = "down"
points = { strategy = "grid", n = [5, 5], margin = "2 mm" }
[[plan.steps]]
feature = "bore"
stylus = "down"
points = { strategy = "levels", at = ["3 mm", "10 mm", "17 mm"], n = 12 }
[[plan.steps]]
feature = "pin"
stylus = "down"
points = { strategy = "levels", at = ["3 mm", "10 mm", "17 mm"], n = 12 }
[part.features]
top = { type = "plane", point = "0 0 20 mm", normal = [0, 0, 1], u = [1, 0, 0], size = "80 80 mm" }
bore = { type = "cylinder", point = "0 0 0 mm", axis = [0, 0, 1], diameter = "30 mm", length = "20 mm", inside = true }
pin = { type = "cylinder", point = "30 0 0 mm", axis = [0, 0, 1], diameter = "12 mm", length = "20 mm" }
"""
ROUND = {"bore": (0.0, 15.0), "pin": (30.0, 6.0)}
POSITION = [
    'type = "size"\nof = "bore"\nlimits = ["-0.02 mm", "0.02 mm"]',
    'type = "position"\nof = "pin"\ndatums = ["top", "bore"]\nmaterial = "M"\nzone = "0.05 mm"',
    'type = "size"\nof = "pin"\nlimits = ["-0.02 mm", "0.02 mm"]',
]
TWELVE = [
    *POSITION,
    'type = "distance"\nbetween = ["bore", "pin"]\nlimits = ["-0.02 mm", "0.02 mm"]',
    *(f'type = "cylindricity"\nof = "{n}"\nzone = "0.01 mm"' for n in ROUND),
    'type = "flatness"\nof = "top"\nzone = "0.01 mm"',
    *(f'type = "perpendicularity"\nof = "{n}"\ndatums = ["top"]\nzone = "0.01 mm"' for n in ROUND),
    'type = "parallelism"\nof = "pin"\ndatums = ["bore"]\nzone = "0.01 mm"',
    'type = "surface_profile"\nof = "top"\nzone = "0.02 mm"',
    'type = "position"\nof = "bore"\ndatums = ["top"]\nzone = "0.02 mm"',
]


def write(folder: Path, asked: Sequence[str], parts: int) -> list[Path]:
    """scenario.toml, points.csv of all parts, and a file for each."""
    lines = [f'[[part.characteristics]]\nname = "c{i}"\n{keys}' for i, keys in enumerate(asked)]
    (folder / "scenario.toml").write_text(HEAD + "\n".join(lines))
    head, rows, files = "part,feature,x_mm,y_mm,z_mm", [], []
    for number in range(parts):
        rng, own = np.random.default_rng(number), []
        a, b = (v.ravel() for v in np.meshgrid(np.linspace(-38, 38, 5), np.linspace(-38, 38, 5)))
        own += [
            ("top", p) for p in np.stack([a, b, 20 + 1e-3 * np.cos(a / 20) + 4e-4 * rng.normal(size=25)], 1)
        ]
        for name, (x, radius) in ROUND.items():
            t, z = (v.ravel() for v in np.meshgrid(2 * np.pi * np.arange(12) / 12, [3.0, 10.0, 17.0]))
            r = radius + 1e-3 * rng.normal() * np.cos(2 * t + 6 * rng.random()) + 4e-4 * rng.normal(size=36)
            own += [
                (name, p) for p in np.stack([x + 2e-3 * rng.normal() + r * np.cos(t), r * np.sin(t), z], 1)
            ]
        text = [f"p{number},{n}," + ",".join(f"{v:.7f}" for v in p) for n, p in own]
        rows += text
        files.append(folder / f"p{number}.csv")
        files[-1].write_text("\n".join([head, *text]))
    (folder / "points.csv").write_text("\n".join([head, *rows]))
    return files


def seconds(*files: Path) -> float:
    """Processor time of evaluations, one after the other."""
    began = time.process_time()
    for file in files:
        with contextlib.redirect_stdout(io.StringIO()), contextlib.redirect_stderr(io.StringIO()):
            if run(["evaluate", str(file.parent / "scenario.toml"), "--points", str(file), "--json"]) not in (
                0,
                1,
            ):
                raise SystemExit(f"{file}: not evaluated")
    return time.process_time() - began


def main() -> None:
    """Print the table, or a profile."""
    for name, asked, parts in (
        ("40 parts x 12 characteristics", TWELVE, 40),
        ("200 parts x size and position with MMC", POSITION, 200),
    ):
        with tempfile.TemporaryDirectory() as place:
            files = write(Path(place), asked, parts)
            if "--profile" in sys.argv:
                profile = cProfile.Profile()
                profile.enable()
                seconds(Path(place) / "points.csv")
                profile.disable()
                pstats.Stats(profile).sort_stats("tottime").print_stats(30)
                pstats.Stats(profile).sort_stats("cumulative").print_stats(60)
                continue
            seconds(files[0])  # what is compiled and imported
            alone = seconds(*files[1:5]) / 4
            together = seconds(Path(place) / "points.csv")
            print(
                f"{name}: {together:.1f} s in one file; {alone:.2f} s a part by itself, {parts * alone:.0f} s for all: "
                f"{parts * alone / together:.1f} times"
            )


if __name__ == "__main__":
    main()
