"""A small turning scenario as files: a journal, a taper, a shoulder and a ball end, on a lathe with its spindle as axis C."""

from __future__ import annotations

from dataclasses import replace
from pathlib import Path

import numpy as np

import vcmm
from vcmm.core.machine import Machine
from vcmm.shop.machining.job import patch
from vcmm.shop.machining.preparation import set_up
from vcmm.shop.machining.process import PreparedCut

HEAD = "%\nO1 (SHAFT)\nG21 G18 G40 G99\nG28 U0 W0\nG50 S3000\nT0101\nG97 S1000 M3\n"
TAIL = "G0 X120. Z50.\nM5\nM30\n%\n"
# finished along the contour with nose compensation; the ball of radius 10 about Z -10, journal to Z -30, taper to Z -60
CONTOUR = (
    "G0 X-4. Z3.\nG42 G1 X-2. Z0 F0.05\nX0\nG3 X20. Z-10. R10.\nG1 Z-30.\nX30.\nX36. Z-60.\nX40.\nZ-100.\nX48.\n"
    "G40 G0 X60. Z20.\n"
)
SETUP = """\
vcmm = "setup/1"
dialect = "fanuc-lathe"
reference = ["250 mm", "0 mm", "550 mm"]
[offsets]
G54 = ["0 mm", "0 mm", "200 mm"]
[tools.1]
length = "60 mm"
offset_x = "40 mm"
shape = "turning"
nose_radius = "0.8 mm"
orientation = 3
[control]
tolerance = "0 um"
"""
PLAIN = "G0 X44. Z2.\nX40.\nG1 Z-60. F0.1\nX52.\n"
SEAT = 'seat = { type = "cylinder", point = "0 0 -50 mm", axis = [0, 0, 1], diameter = "40 mm", length = "40 mm" }\n'
BAR = '[stock]\ndiameter = "44 mm"\nlength = "90 mm"\nmaterial = "16MnCr5"\nthrust_ratio = 0.45\n'
MACHINE = """\
vcmm = "machine/1"
name = "lathe"
kind = "lathe"
structure = "w C' b Z X t"
[axes.X]
travel = ["-50 mm", "300 mm"]
[axes.Z]
travel = ["-100 mm", "600 mm"]
[axes.C]
travel = ["-360 deg", "360 deg"]
error_frame = "fixed"
"""
SCENARIO = """\
vcmm = "scenario/1"
machine = "lathe.toml"
[cut]
program = "part.nc"
setup = "setup.toml"
[part.features]
ball = { type = "sphere", point = "0 0 -10 mm", diameter = "20 mm" }
journal = { type = "cylinder", point = "0 0 -30 mm", axis = [0, 0, 1], diameter = "20 mm", length = "20 mm" }
step = { type = "plane", point = "0 0 -30 mm", normal = [0, 0, 1], size = "30 30 mm" }
taper = { type = "cone", point = "0 0 -30 mm", axis = [0, 0, -1], diameter = "30 mm", angle = "11.4211863 deg", length = "30 mm" }
seat = { type = "cylinder", point = "0 0 -100 mm", axis = [0, 0, 1], diameter = "40 mm", length = "40 mm" }
[[part.characteristics]]
name = "diameter"
type = "size"
of = "seat"
limits = ["-0.02 mm", "0.02 mm"]
[[part.characteristics]]
name = "roundness"
type = "cylindricity"
of = "seat"
zone = "0.02 mm"
[job]
trials = 2000
"""


def effect(name: str, **values: str) -> str:
    """One [[effects]] table; values are written as they come, texts in quotes."""
    lines = "".join(f'{k} = "{v}"\n' if not v.startswith("[") else f"{k} = {v}\n" for k, v in values.items())
    return f'[[effects]]\neffect = "{name}"\n{lines}'


def write(
    folder: Path, machine: str = "", *, program: str = HEAD + CONTOUR + TAIL, scenario: str = SCENARIO,
    setup: str = SETUP, base: str = MACHINE,
) -> Path:  # fmt: skip
    """All files of the job in a folder; `machine` is added to the machine file."""
    (folder / "part.nc").write_text(program)
    (folder / "setup.toml").write_text(setup)
    (folder / "lathe.toml").write_text(base + machine)
    path = folder / "shaft.toml"
    path.write_text(scenario)
    return path


def shop(path: Path) -> PreparedCut:
    return set_up(vcmm.load_cut(path))


def on_machine(ready: PreparedCut, machine: Machine) -> PreparedCut:
    """The same cut on another machine."""
    return replace(ready, scenario=replace(ready.scenario, machine=machine))


def moved(ready: PreparedCut, feature: str) -> tuple[np.ndarray, np.ndarray]:
    """How far errors of the machine have moved the surface (n,) mm, and the points (n, 3) in the drawing."""
    over = ready.process.net(ready, ready.scenario.part.features[feature], 15)
    found = patch(ready, over)
    return found.height - found.nominal, over.points


def nominal(ready: PreparedCut, feature: str) -> tuple[np.ndarray, np.ndarray]:
    """What a perfect lathe leaves (n,) mm above nominal, feed marks, and the points."""
    over = ready.process.net(ready, ready.scenario.part.features[feature], 15)
    return patch(ready, over).nominal, over.points


def plain(tmp_path: Path, machine="", setup=SETUP, program=PLAIN, **more):
    """One pass along a bar."""
    head, tail = SCENARIO.split("[part.features]\n")
    scenario = head + "[part.features]\n" + SEAT + tail[tail.index("[[part") :]
    return write(tmp_path, machine, program=HEAD + program + TAIL, scenario=scenario, setup=setup, **more)
