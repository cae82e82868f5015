"""A block with four walls, a bore and a floor as files, cut by two tools, and its measured points with something concealed."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import vcmm
from tests.shop.machining import shop
from vcmm.answer.evaluation.linear import build
from vcmm.shop.machining.job import finished_part
from vcmm.shop.machining.preparation import set_up

PROGRAM = """\
%
O1 (BLOCK)
G21 G17 G40 G49 G80 G90 G94
T1 M6
G54 G0 X-60. Y-70. S3000 M3
G43 H1 Z5.
Z-10.
G1 X-60. Y40. F600
G1 X60. Y40. F900
G1 X60. Y-40. F600
G1 X-70. Y-40. F900
G0 Z100.
T2 M6
G54 G0 X0 Y0 S4000 M3
G43 H2 Z5.
G1 Z-8. F200
G1 X10. Y0 F400
G3 X10. Y0 I-10. J0
G1 X0 Y0
G0 Z5.
X-35. Y-20.
G1 Z-3. F200
G1 X35. F500
Y-15.
X-35.
G0 Z100.
M30
%
"""
FEATURES = """\
[part.features]
left = { type = "plane", point = "-50 0 -6 mm", normal = [-1, 0, 0], size = "50 6 mm" }
right = { type = "plane", point = "50 0 -6 mm", normal = [1, 0, 0], size = "50 6 mm" }
back = { type = "plane", point = "0 30 -6 mm", normal = [0, 1, 0], size = "80 6 mm" }
front = { type = "plane", point = "0 -30 -6 mm", normal = [0, -1, 0], size = "80 6 mm" }
bore = { type = "cylinder", point = "0 0 -7 mm", axis = [0, 0, 1], diameter = "30 mm", length = "4 mm", inside = true }
floor = { type = "plane", point = "0 -18.5 -3 mm", normal = [0, 0, 1], size = "60 4 mm" }
[[part.characteristics]]
name = "width"
type = "distance"
between = ["left", "right"]
[[part.characteristics]]
name = "length"
type = "distance"
between = ["front", "back"]
[[part.characteristics]]
name = "bore"
type = "size"
of = "bore"
[[part.characteristics]]
name = "floor"
type = "flatness"
of = "floor"
[job]
trials = 1000
"""
KNOWN = """\
[repeatability]
u = "0.3 um"
[[effects]]
effect = "scale_factor"
axis = "X"
k = "20 um/m"
[[inputs]]
effect = "scale_factor"
axis = "X"
parameter = "k"
u = "5 um/m"
"""
SET = 'work_offset = { u = "2 um" }\ntools = { 1 = { u_radius = "2 um" }, 2 = { u_radius = "2 um" } }\n'
NOISE = 0.3e-3  # mm, of a measured point


def write(folder: Path, concealed: str = "") -> Path:
    """The scenario file; concealed: added to the machine file."""
    folder.mkdir(exist_ok=True)
    head = (
        f'vcmm = "scenario/1"\nmachine = "mill.toml"\n[cut]\nprogram = "part.nc"\nsetup = "setup.toml"\n{SET}'
    )
    setup = shop.SETUP + '[tools.2]\nlength = "80 mm"\ndiameter = "10 mm"\n'
    return shop.write(folder, KNOWN + concealed, head + FEATURES, PROGRAM, setup)


def measured(folder: Path, concealed: str, seed: int) -> tuple[np.ndarray, np.ndarray]:
    """Points (n, 3) in the drawing frame of a part with a draw of all that is uncertain, noise added, and their features."""
    job = set_up(vcmm.load_cut(write(folder / "concealed", concealed)))
    task, world, _ = finished_part(job)
    model, rng = build(task, world), np.random.default_rng(seed)
    t = task.touches
    out = ((model.points - t.points) * t.normals).sum(axis=1)
    for term in replace(model, operator=np.eye(len(out)), q0=np.zeros(len(out))).terms():
        out = out + term.gain @ (term.law.u * rng.standard_normal(term.gain.shape[1]))
    out = out + NOISE * rng.standard_normal(len(out))
    return t.points + out[:, None] * t.normals, t.run.labels["feature"]


def csv(path: Path, points: np.ndarray, features: np.ndarray, unit: str = "mm") -> Path:
    rows = [f"{f},{x:.6f},{y:.6f},{z:.6f}\n" for f, (x, y, z) in zip(features, points)]
    path.write_text(f"feature,x_{unit},y_{unit},z_{unit}\n" + "".join(rows))
    return path
