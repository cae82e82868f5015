"""A small cutting scenario as files: a boss of radius 50 mm and a floor, on a three-axis mill."""

from __future__ import annotations

from pathlib import Path

PROGRAM = """\
%
O1 (BOSS)
G21 G17 G40 G49 G80 G90 G94
T1 M6
G54 G0 X-20. Y90. S3000 M3
G43 H1 Z5.
Z-10.
G1 X-20. Y60. F600
G1 X0 Y60.
G2 X0 Y60. I0 J-60.
G1 X20. Y60.
G1 X20. Y90.
G0 Z50.
M30
%
"""
SLOT = """\
%
O1 (SLOT)
G21 G17 G40 G49 G80 G90 G94
T1 M6
G54 G0 X-80. Y0. S3000 M3
G43 H1 Z5.
Z-2.
G1 X80. Y0. F600
G0 Z50.
M30
%
"""
SETUP = """\
vcmm = "setup/1"
dialect = "fanuc"
[offsets]
G54 = ["300 mm", "250 mm", "-350 mm"]
[tools.1]
length = "100 mm"
diameter = "20 mm"
"""
MACHINE = """\
vcmm = "machine/1"
name = "mill"
kind = "machine-tool"
structure = "w X' Y' b Z t"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-500 mm", "0 mm"]
"""
SCENARIO = """\
vcmm = "scenario/1"
machine = "mill.toml"
[cut]
program = "part.nc"
setup = "setup.toml"
work_offset = { u = "2 um" }
[part.features]
boss = { type = "cylinder", point = "0 0 -8 mm", axis = [0, 0, 1], diameter = "100 mm", length = "6 mm" }
[[part.characteristics]]
name = "diameter"
type = "size"
of = "boss"
limits = ["-0.02 mm", "0.02 mm"]
[[part.characteristics]]
name = "form"
type = "cylindricity"
of = "boss"
zone = "0.02 mm"
[job]
trials = 2000
"""


def write(
    folder: Path, machine: str = "", scenario: str = SCENARIO, program: str = PROGRAM, setup: str = SETUP
) -> Path:
    """All files of the job in a folder; `machine` is added to the machine file."""
    (folder / "part.nc").write_text(program)
    (folder / "setup.toml").write_text(setup)
    (folder / "mill.toml").write_text(MACHINE + machine)
    path = folder / "boss.toml"
    path.write_text(scenario)
    return path
