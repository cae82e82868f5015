"""A drilled hole as files: 10 mm wide, 40 mm deep, beside a faced plane."""

from __future__ import annotations

from pathlib import Path

from tests.shop.machining import shop

DRILL = "G81 Z-45. R2. F200\nG80"
PECK = "G83 Z-45. R2. Q7. F200\nG80"
PROGRAM = """\
%
O1 (HOLE)
G21 G17 G40 G49 G80 G90 G94
T1 M6
G54 G0 X0 Y0 S3000 M3
G43 H1 Z5.
{cycle}
G0 Z50.
T2 M6
G0 X-60. Y0
G43 H2 Z0
G1 X60. F500
G0 Z50.
M30
%
"""
FEATURES = """\
[part.features]
hole = { type = "cylinder", point = "0 0 -40 mm", axis = [0, 0, 1], diameter = "10 mm", length = "40 mm", inside = true }
top = { type = "plane", point = "0 -20 0 mm", normal = [0, 0, 1], size = "60 20 mm" }
[[part.characteristics]]
name = "square"
type = "perpendicularity"
of = "hole"
datums = ["top"]
[job]
trials = 1000
"""


def write(folder: Path, machine: str = "", cycle: str = DRILL, shape: str = "drill") -> Path:
    """The scenario file; machine: added to the machine file."""
    head = 'vcmm = "scenario/1"\nmachine = "mill.toml"\n[cut]\nprogram = "part.nc"\nsetup = "setup.toml"\n'
    setup = shop.SETUP.replace('"20 mm"', '"10 mm"') + f'shape = "{shape}"\n'
    setup += '[tools.2]\nlength = "100 mm"\ndiameter = "80 mm"\n'
    return shop.write(folder, machine, head + FEATURES, PROGRAM.format(cycle=cycle), setup)
