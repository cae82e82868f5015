"""A dome led by five axes under a head, cut and inspected, processor time: python benchmarks/bench_five_axes.py [BLOCKS ...] [--stock]

Sphere of R 30, ball of R 5 in a spiral, B and C turning all the time (G43.4). The kernels are compiled by a first small program that is not counted.
"""

from __future__ import annotations

import sys
import tempfile
import time
from pathlib import Path

import numpy as np

import vcmm
from vcmm.shop.machining.job import cut

RADIUS, BALL = 30.0, 5.0
MACHINE = """vcmm = "machine/1"
name = "head"
kind = "machine-tool"
structure = "w b X Y Z C B t"
axes.X = { travel = ["-500 mm", "500 mm"] }
axes.Y = { travel = ["-500 mm", "500 mm"] }
axes.Z = { travel = ["-500 mm", "500 mm"] }
axes.B = { travel = ["-110 deg", "110 deg"], centre = ["0 mm", "0 mm", "150 mm"] }
axes.C = { travel = ["-100000 deg", "100000 deg"], centre = ["0 mm", "0 mm", "150 mm"] }
[[effects]]
effect = "scale_factor"
axis = "X"
k = "20 um/m"
"""
SETUP = """vcmm = "setup/1"
dialect = "fanuc"
offsets.G54 = ["0 mm", "0 mm", "-300 mm"]
tools.1 = { length = "100 mm", diameter = "10 mm", shape = "ball" }
"""
STOCK = '[stock]\nbox = ["80 mm", "80 mm", "40 mm"]\ncorner = ["-40 mm", "-40 mm", "-5 mm"]\n'
SCENARIO = """vcmm = "scenario/1"
machine = "mill.toml"
cut = { program = "part.nc", setup = "setup.toml" }
[part]
mesh = "dome.obj"
features.dome = { type = "mesh" }
[[part.characteristics]]
name = "profile"
type = "surface_profile"
of = "dome"
zone = "0.5 mm"
[plan]
styli.ball = { offset = "0 0 -80 mm", tip_diameter = "2 mm" }
steps = [{ feature = "dome", stylus = "ball", points = "points.csv" }]
[job]
trials = 2000
"""


def program(blocks: int) -> str:
    turns, share = 6 if blocks < 1000 else 40, np.linspace(0, 1, blocks)
    polar, around = np.radians(5 + 55 * share), 2 * np.pi * turns * share
    lean = 0.6 * polar
    normal, axis = (
        np.c_[np.sin(a) * np.cos(around), np.sin(a) * np.sin(around), np.cos(a)] for a in (polar, lean)
    )
    tip = (RADIUS + BALL) * normal - BALL * axis
    words = [
        "X{:.4f} Y{:.4f} Z{:.4f} B{:.4f} C{:.4f}".format(*p, b, c)
        for p, b, c in zip(tip, np.degrees(lean), np.degrees(around))
    ]
    head = f"%\nO1\nG21 G17 G40 G49 G80 G90 G94\nT1 M6\nG54 S8000 M3\nG0 X{tip[0, 0]:.3f} Y0.\nG43.4 H1 Z80. B{np.degrees(lean[0]):.4f} C0.\n"
    return head + f"G1 {words[0]} F2000.\n" + "\n".join(words[1:]) + "\nG0 Z120.\nG49\nM30\n%\n"


def write(folder: Path, blocks: int, stock: bool) -> Path:
    polar, around = np.radians(np.linspace(3, 62, 60)), 2 * np.pi * np.arange(120) / 120
    corners = [(np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)) for a in polar for b in around]
    faces = []
    for i in range(59):
        for j in range(120):
            a, b, c, d = (
                i * 120 + j,
                i * 120 + (j + 1) % 120,
                (i + 1) * 120 + j,
                (i + 1) * 120 + (j + 1) % 120,
            )
            faces += [f"f {a + 1} {c + 1} {b + 1}", f"f {b + 1} {c + 1} {d + 1}"]
    vertices = ["v {:.9f} {:.9f} {:.9f}".format(*(RADIUS * np.array(n))) for n in corners]
    (folder / "dome.obj").write_text("\n".join([*vertices, *faces]) + "\n")
    looks = [
        (a, b) for a in np.radians([12, 20, 28, 36, 44, 52]) for b in 2 * np.pi * (np.arange(12) + 0.3) / 12
    ]
    normals = [(np.sin(a) * np.cos(b), np.sin(a) * np.sin(b), np.cos(a)) for a, b in looks]
    rows = [",".join(f"{v:.9f}" for v in (*(RADIUS * np.array(n)), *n)) for n in normals]
    (folder / "points.csv").write_text("x_mm,y_mm,z_mm,nx,ny,nz\n" + "\n".join(rows) + "\n")
    (folder / "part.nc").write_text(program(blocks))
    (folder / "mill.toml").write_text(MACHINE)
    (folder / "setup.toml").write_text(SETUP + (STOCK if stock else ""))
    (folder / "dome.toml").write_text(SCENARIO)
    return folder / "dome.toml"


def seconds(blocks: int, stock: bool) -> float:
    with tempfile.TemporaryDirectory() as folder:
        scenario = vcmm.load_cut(write(Path(folder), blocks, stock))
        start = time.process_time()
        cut(scenario)
        return time.process_time() - start


def main(words: list[str]) -> None:
    stock = "--stock" in words
    seconds(40, stock)
    for blocks in [int(w) for w in words if w.isdigit()] or [185, 10_000]:
        print(
            f"{blocks:6d} blocks{', stock carved' if stock else ''}: {seconds(blocks, stock):6.1f} s",
            flush=True,
        )


if __name__ == "__main__":
    main(sys.argv[1:])
