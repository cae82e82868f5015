"""A block as files: four walls, a pocket with a floor that is plunged into, a bore with a floor; one tool of 12 mm."""

from __future__ import annotations

from pathlib import Path

from tests.shop.machining import shop

PROGRAM = """\
%
O1
G21 G17 G40 G49 G80 G90 G94
T1 M6
G54 G0 X-60. Y-60. S3000 M3
G43 H1 Z5.
Z-6.
G1 X-46. Y-50. F600
G1 Y36.
G1 X46.
G1 Y-36.
G1 X-60.
G0 Z5.
X-30. Y-15.
Z1.
G1 Z-8. F200
G1 X-10. F500
Y-9.
X-30.
Y-3.
X-10.
Y3.
X-30.
Y9.
X-10.
Y15.
X-30.
Y-15.
X-10.
Y15.
X-30.
G0 Z5.
X20. Y0.
Z1.
G1 Z-8. F200
G1 X26. F400
G3 X26. Y0. I-6. J0.
G3 X26. Y0. I-6. J0.
G1 X20.
G0 Z50.
M30
%
"""
SETUP = """\
vcmm = "setup/1"
dialect = "fanuc"
[control]
compensation = []
[offsets]
G54 = ["300 mm", "250 mm", "-350 mm"]
[tools.1]
length = "100 mm"
diameter = "12 mm"
teeth = 3
[stock]
box = "88 68 30 mm"
material = "16MnCr5"
"""
SCENARIO = """\
vcmm = "scenario/1"
machine = "mill.toml"
[cut]
program = "part.nc"
setup = "setup.toml"
work_offset = { u = "2 um" }
[part.features]
west = { type = "plane", point = "-40 0 -3 mm", normal = [-1, 0, 0], size = "60 5 mm" }
east = { type = "plane", point = "40 0 -3 mm", normal = [1, 0, 0], size = "60 5 mm" }
north = { type = "plane", point = "0 30 -3 mm", normal = [0, 1, 0], size = "80 5 mm" }
south = { type = "plane", point = "0 -30 -3 mm", normal = [0, -1, 0], size = "80 5 mm" }
floor = { type = "plane", point = "-20 0 -8 mm", normal = [0, 0, 1], size = "28 38 mm" }
pocket_w = { type = "plane", point = "-36 0 -5 mm", normal = [1, 0, 0], size = "24 5 mm" }
pocket_n = { type = "plane", point = "-20 21 -5 mm", normal = [0, -1, 0], size = "14 5 mm" }
bore = { type = "cylinder", point = "20 0 -7 mm", axis = [0, 0, 1], diameter = "24 mm", length = "6 mm", inside = true }
bore_floor = { type = "plane", point = "20 0 -8 mm", normal = [0, 0, 1], size = "12 12 mm" }
[[part.characteristics]]
name = "length"
type = "distance"
between = ["west", "east"]
[[part.characteristics]]
name = "width"
type = "distance"
between = ["south", "north"]
[[part.characteristics]]
name = "floor flat"
type = "flatness"
of = "floor"
zone = "0.01 mm"
[[part.characteristics]]
name = "pocket_w flat"
type = "flatness"
of = "pocket_w"
zone = "0.01 mm"
[[part.characteristics]]
name = "pocket_n flat"
type = "flatness"
of = "pocket_n"
zone = "0.01 mm"
[[part.characteristics]]
name = "bore_floor flat"
type = "flatness"
of = "bore_floor"
zone = "0.01 mm"
[[part.characteristics]]
name = "bore"
type = "size"
of = "bore"
limits = ["-0.02 mm", "0.02 mm"]
[job]
trials = 1000
"""


def write(
    folder: Path, machine: str = "", program: str = PROGRAM, setup: str = SETUP, scenario: str = SCENARIO
) -> Path:
    """All files in a folder; `machine` is added to the machine file."""
    (folder / "part.nc").write_text(program)
    (folder / "setup.toml").write_text(setup)
    (folder / "mill.toml").write_text(shop.MACHINE + machine)
    path = folder / "block.toml"
    path.write_text(scenario)
    return path
