"""A shaft of a lathe with driven tools as files: turned seat, cross hole at C 30, face holes at C 0 and 90, a flat at C 90 by Y."""

from __future__ import annotations

from pathlib import Path

from tests.shop.machining import lathe

BASE = lathe.MACHINE.replace("Z X t", "Z X Y t") + '[axes.Y]\ntravel = ["-60 mm", "60 mm"]\n'
TURNED = "G0 X44. Z2.\nX40.\nG1 Z-60. F0.1\nX52.\nG0 X120. Z50.\nM5\n"
CROSS = "T0202\nG0 X50. Z-20. C30.\nG87 X12. R-3. F100.\nG80\nG0 X120. Z50.\n"
FACE = "T0303\nG0 X24. Z5. C0.\nG83 Z-15. R-3. Q5. F100.\nC90.\nG80\nG0 X120. Z50.\n"
FLAT = "T0404\nG0 X60. Z-45. C90.\nY-20.\nG1 X36. F200.\nY20.\nG0 X60.\nY0.\nG0 X120. Z50.\n"
PROGRAM = lathe.HEAD + TURNED + "G98\n" + CROSS + FACE + FLAT + "M5\nM30\n%\n"
SINUMERIK = """; driven tools
G18 G71 G90 G40 DIAMON G54
T1 D1
G97 S1000 M3
G95 G0 X44 Z2
X40
G1 Z-60 F0.1
X52
G0 X120 Z50
M5
G94
T2 D1
SETMS(3)
S3=2000 M3=3
SPOS[1]=30
G0 X50 Z-20
G0 X44
G1 X12 F100
G0 X50
G0 X120 Z50
T3 D1
G0 C0
G0 X24 Z5
G17
CYCLE83(5,0,2,-15,,-5,,0,0,0,1,0)
C90
CYCLE83(5,0,2,-15,,-5,,0,0,0,1,0)
G18
G0 X120 Z50
T4 D1
G0 X60 Z-45 C90
Y-20
G1 X36 F200
Y20
G0 X60
Y0
G0 X120 Z50
M30
"""
LINUXCNC = """G21 G18 G90 G40 G7 G54
T1 M6 G43
G97 S1000 M3
G95 G0 X44 Z2
X40
G1 Z-60 F0.1
X52
G0 X120 Z50
M5
G94
T2 M6 G43
M3 S2000
G0 X50 Z-20 C30
G0 X44
G1 X12 F100
G0 X50
G0 X120 Z50
T3 M6 G43
G0 C0
G0 X24 Z5
G17
G83 X24 Y0 Z-15 R2 Q5 F100
G80
G0 C90
G83 X24 Y0 Z-15 R2 Q5
G80
G18
G0 X120 Z50
T4 M6 G43
G0 X60 Z-45 C90
Y-20
G1 X36 F200
Y20
G0 X60
Y0
G0 X120 Z50
M2
"""
DRIVEN = """\
[tools.2]
length = "30 mm"
offset_x = "70 mm"
shape = "drill"
diameter = "6 mm"
driven = "x"
[tools.3]
length = "90 mm"
offset_x = "20 mm"
shape = "drill"
diameter = "5 mm"
driven = "z"
[tools.4]
length = "30 mm"
offset_x = "70 mm"
shape = "flat"
diameter = "10 mm"
driven = "x"
"""
SETUP = lathe.SETUP.replace("[control]", DRIVEN + "[control]")
CROSS_HOLE = (
    'cross = { type = "cylinder", point = "8 4.618802153517006 -20 mm", axis = [0.8660254037844387, 0.5, 0], diameter = "6 mm", '
    'length = "8 mm", inside = true }\n'
)
FEATURES = (
    'seat = { type = "cylinder", point = "0 0 -58 mm", axis = [0, 0, 1], diameter = "40 mm", length = "8 mm" }\n'
    + CROSS_HOLE
    + 'hole0 = { type = "cylinder", point = "12 0 -10 mm", axis = [0, 0, 1], diameter = "5 mm", length = "8 mm", inside = true }\n'
    + 'hole90 = { type = "cylinder", point = "0 12 -10 mm", axis = [0, 0, 1], diameter = "5 mm", length = "8 mm", inside = true }\n'
    + 'flat = { type = "plane", point = "0 18 -45 mm", normal = [0, 1, 0], size = "14 8 mm" }\n'
)
CHARACTERISTICS = """\
[[part.characteristics]]
name = "place of the cross hole"
type = "position"
of = "cross"
zone = "0.05 mm"
[[part.characteristics]]
name = "diameter"
type = "size"
of = "seat"
limits = ["-0.02 mm", "0.02 mm"]
[job]
trials = 1000
"""
SCENARIO = lathe.SCENARIO.split("[part.features]\n")[0] + "[part.features]\n" + FEATURES + CHARACTERISTICS


def write(folder: Path, machine: str = "", **more: str) -> Path:
    """All files of the job in a folder; `machine` is added to the machine file."""
    own = {"base": BASE, "program": PROGRAM, "scenario": SCENARIO, "setup": SETUP}
    return lathe.write(folder, machine, **(own | more))
