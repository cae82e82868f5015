"""One right set of files per reader, with the command that reads it. All are small, so that a mutation costs milliseconds."""

from __future__ import annotations

import math
import shutil
from dataclasses import dataclass
from pathlib import Path

from tests.files.foreign.samples import DCC, DMIS, QIF
from tests.plate import PLATE
from tests.shop.machining import shop
from vcmm.files.own.library import example as shipped

AXES = """[axes.X]
travel = ["-10 mm", "600 mm"]
dynamics = { speed = "400 mm/s", acceleration = "2 m/s^2", jerk = "40 m/s^3", gain = "30 1/s", feed_forward = 0.9 }
[axes.Y]
travel = ["0 mm", "500 mm"]
measured_at = "0 250 -100 mm"
[axes.Z]
travel = ["-400 mm", "0 mm"]
"""
MACHINE = (
    """vcmm = "machine/1"
name = "bridge CMM"
kind = "cmm"
structure = "w X' b Y Z t"
"""
    + AXES
    + """[errors]
table = "errors.csv"
uncertainty = { translation = "0.3 um", rotation = "1 urad", squareness = "1 urad", correlation_length = "150 mm" }
[repeatability]
law = "t"
scale = "0.4 um"
dof = 10
[environment]
scales = { expansion = "8.0 um/(m K)", u_expansion = "0.5 um/(m K)", compensated = true, u_sensor = "0.05 K" }
[[effects]]
effect = "backlash"
axis = "X"
gap = "2 um"
[[effects]]
effect = "component_polynomial"
component = "EXY"
coefficients = ["0 um", "2 um", "-4 um"]
[[inputs]]
effect = "backlash"
axis = "X"
parameter = "gap"
law = "uniform"
half_width = "1 um"
redraw = "setup"
evidence = "ball bar"
[[inputs]]
channel = "temp_part_C"
u = "0.1 K"
"""
)
ERRORS = """X EXX EYX EZX EAX EBX ECX
-10 0.0 0.0 0.0 0.0 0.0 0.0
300 0.0011 0.0004 -0.0002 0.000002 0.000001 -0.000003
600 0.0009 -0.0003 0.0005 0.000004 -0.000002 0.000001
#
C0Y B0Z
0.000004 -0.000002
"""
ETALON = """[C0Y]
VALUE = 0.0000048
[EXX]
Gridpoints = {
-10.0 0.0
300.0 0.0012
600.0 0.0007
} // end of EXX
"""
COVARIANCE = """error,position,EXX@-10,EXX@300,EXX@600,C0Y
EXX,-10,1e-8,0,0,0
EXX,300,0,4e-8,1e-8,0
EXX,600,0,1e-8,9e-8,0
C0Y,,0,0,0,1e-12
"""
BARE = 'vcmm = "machine/1"\nstructure = "w X\' b Y Z t"\n' + AXES
RTL = """HEADER::
File Type: linear
TARGET DATA::
Target-count: 3
Targets :
0.000 100.000
200.000
USER-TEXT::
Axis: X
RUNS::
Run-count: 2
DEVIATIONS::
Run Target Data:
1 1 0.0
1 2 1.5
1 3 3.0
2 3 4.0
2 2 2.5
2 1 1.0
ENVIRONMENT::
Air temp : 20.10
Mat temp 1 : 20.0
Mat temp 2 : 20.5
EOF::
"""
LINE = '[line]\naxis = "X"\nat = { Y = "250 mm", Z = "-100 mm" }\noffset = "0 0 -80 mm"\n'
RECORDING = 'vcmm = "recording/1"\nname = "r"\nmachine = "machine.toml"\n'
TOUCHES = RECORDING + (
    'data = "touches.csv"\nkind = "probe"\nobserved = "indicated - true"\n[nuisance]\nrigid = "pose"\n'
    '[noise]\nlaw = "t"\nscale = "0.4 um"\ndof = 10\n[[series]]\ndata = "log.csv"\n'
)
TOUCHES_CSV = "time_s,X_mm,Y_mm,Z_mm,offset_z_mm,nx,ny,nz,temp_scale_x_C,pose,stylus,d_um\n" + "".join(
    f"{10 * i},{50 + 40 * i},{40 * i},{-20 * i},-80,{(1, 0, 0)[i % 3]},{(0, 1, 0)[i % 3]},{(0, 0, 1)[i % 3]},20.{i},p{i // 4},down,{0.3 * (-1) ** i}\n"
    for i in range(12)
)
LOG = "time_s,temp_air_C,pressure_hPa\n0,20.1,1013\n60,20.2,1012\n120,20.3,1011\n"
POINTS = "feature,x,y,z,i,j,k,mx,my,mz\n" + "".join(
    f"top,{20 * i},{10 * i},0,0,0,1,{20 * i},{10 * i},{0.001 * i}\n" for i in range(6)
)
RUNS = "target_mm,run,direction,deviation_um,temp_air_C\n" + "".join(
    f"{t},{'ab'[r]},{d},{0.01 * t + r},20.{r}\n"
    for r in (0, 1)
    for d, order in (("up", (0, 100, 200)), ("down", (200, 100, 0)))
    for t in order
)
SCOPE = "time_s,X_commanded_mm,X_actual_mm\n" + "".join(
    f"{0.01 * i:.2f},{10 + i},{10 + i + 0.001 * (i % 2)}\n" for i in range(8)
)
SETUP = """vcmm = "setup/1"
machine = "machine.toml"
dialect = "fanuc"
reference = "0 0 0 mm"
[offsets]
G54 = ["200 mm", "200 mm", "-300 mm"]
[rotations]
G54 = "5 deg"
[tools.1]
length = "150 mm"
diameter = "12 mm"
shape = "flat"
teeth = 2
stick_out = "40 mm"
[stock]
box = ["100 mm", "60 mm", "30 mm"]
corner = ["0 mm", "0 mm", "-30 mm"]
material = "Al7075"
[control]
tolerance = "10 um"
"""
PROGRAM = """%
O2424 (SLOT)
G21 G17 G40 G49 G80 G90 G94
T1 M6
G54 G0 S4000 M3
G43 H1 Z20.
#100 = 5.5
G0 X10. Y10.
Z1.
G1 Z-2.0 F300
X40. F900
G2 X50. Y20. I0. J10.
G3 X40. Y30. R10.
G81 X20. Y20. Z-5. R2. F200
G80
IF [#100 GT 3] GOTO 100
X[#100*2]
N100 G0 Z20.
M98 P1000 L3
M30
O1000
G91 G1 X1.
G90
M99
%
"""
POSITIONS = "X_mm,Y_mm,Z_mm,offset_z_mm,sense_X,temp_scale_x_C\n0,0,-10,-80,1,20.1\n100,50,-20,-80,-1,20.2\n"
PLAN_POINTS = "x_mm,y_mm,z_mm,nx,ny,nz\n-20,-20,20,0,0,1\n20,-20,20,0,0,1\n0,20,20,0,0,1\n20,25,20,0,0,1\n"
DESIGN = """vcmm = "design/1"
structure = "w b Y X Z t"
budget = "120 min"
[axes.X]
travel = ["0 mm", "600 mm"]
[axes.Y]
travel = ["0 mm", "500 mm"]
[axes.Z]
travel = ["-400 mm", "0 mm"]
[[setups]]
name = "laser along X"
instrument = "laser linear"
minutes = 20
u = "0.2 um"
axis = "X"
at = { Y = "250 mm", Z = "-200 mm" }
n = 5
own = { scale = "0.3 um/m" }
"""
SINUMERIK = """G17 G90 G54 G71
T1 D1
M6
S1000 M3
R1=10.5 R2=R1*2
G0 X=R1 Y10
G1 Z-2 F300
FOR R3=1 TO 3
X=IC(2)
ENDFOR
IF R1>5 GOTOF ENDE
G2 X20 Y20 CR=15
ENDE:
CYCLE81(5,0,2,-5)
M30
"""
HEIDENHAIN = """BEGIN PGM SLOT MM
BLK FORM 0.1 Z X+0 Y+0 Z-20
BLK FORM 0.2 X+100 Y+100 Z+0
TOOL CALL 1 Z S4000
Q1 = +5.5
L X+50 Y+10 R0 FMAX M3
L Z-2 F300
CC X+50 Y+50
C X+90 Y+50 DR+
LBL 1
L IX+1
CALL LBL 1 REP2
FN 9: IF +Q1 EQU +5 GOTO LBL 2
LBL 2
L Z+50 R0 FMAX M30
END PGM SLOT MM
"""


@dataclass(frozen=True)
class Case:
    """A reader: the files of its folder (name -> text), the command, and which files are mutated."""

    name: str
    files: dict[str, str]
    command: tuple[str, ...]
    mutated: tuple[str, ...]
    survey: bool = (
        False  # a program or a file of another system: what is unusual in it may be read with a remark
    )

    def lay_out(self, folder: Path) -> None:
        shutil.rmtree(folder / "made", ignore_errors=True)
        for name, text in self.files.items():
            (folder / name).write_text(text, encoding="utf-8")


def _recording(name: str, head: str, data: str, text: str, **more: str) -> Case:
    files = {"recording.toml": head, "machine.toml": BARE, data: text, **more}
    return Case(name, files, ("check", "recording.toml"), ("recording.toml", data, *more))


def ring() -> str:
    """A task that is quickly evaluated."""
    return shipped("ring_gauge").read_text().replace("trials = 100000", "trials = 2000")


def ring_points() -> str:
    turns = [2 * math.pi * k / 16 for k in range(16)]
    rows = [f"bore,{25.0004 * math.cos(a):.5f},{25.0004 * math.sin(a):.5f},0" for a in turns]
    return "\n".join(["feature,x_mm,y_mm,z_mm", *rows]) + "\n"


def _other_system(name: str, file: str, text: str) -> Case:
    return Case(name, {file: text}, ("convert", file, "--out", "made"), (file,), survey=True)


def _scenario_with_points() -> str:
    return PLATE.replace('points = { strategy = "grid", n = [3, 3], margin = "5 mm" }', 'points = "top.csv"')


CASES = (
    Case("machine", {"machine.toml": MACHINE, "errors.csv": ERRORS}, ("check", "machine.toml"), ("machine.toml", "errors.csv")),
    Case(
        "etalon",
        {"machine.toml": BARE + '[errors]\ntable = "errors.txt"\ncovariance = "covariance.csv"\n', "errors.txt": ETALON, "covariance.csv": COVARIANCE},
        ("check", "machine.toml"),
        ("errors.txt", "covariance.csv"),
    ),
    Case("scenario", {"plate.toml": PLATE}, ("check", "plate.toml"), ("plate.toml",)),
    Case("points of a plan", {"plate.toml": _scenario_with_points(), "top.csv": PLAN_POINTS}, ("check", "plate.toml"), ("top.csv",)),
    _recording("recording", TOUCHES, "touches.csv", TOUCHES_CSV, **{"log.csv": LOG}),
    _recording("point table", RECORDING + 'data = "p.csv"\nkind = "probe"\nformat = "points"\n[pose]\nshift = "100 100 -100 mm"\n[stylus]\noffset = "0 0 -80 mm"\ntip_diameter = "4 mm"\n', "p.csv", POINTS),
    _recording("iso230", RECORDING + 'data = "runs.csv"\nkind = "displacement"\nformat = "iso230"\n' + LINE, "runs.csv", RUNS),
    _recording("rtl", RECORDING + 'data = "x.rtl"\nkind = "displacement"\n' + LINE, "x.rtl", RTL),
    _recording(
        "scope",
        RECORDING + 'data = "s.csv"\nkind = "path"\nformat = "scope"\n[line]\nat = { Y = "100 mm", Z = "-10 mm" }\n',
        "s.csv",
        SCOPE,
    ),
    Case("set-up", {"setup.toml": SETUP, "machine.toml": BARE}, ("check", "setup.toml"), ("setup.toml",)),
    Case(
        "program",
        {"setup.toml": SETUP, "machine.toml": BARE, "slot.nc": PROGRAM},
        ("nc", "slot.nc", "--setup", "setup.toml"),
        ("slot.nc",),
        survey=True,
    ),
    Case("sinumerik", {"setup.toml": SETUP.replace("fanuc", "sinumerik"), "machine.toml": BARE, "slot.mpf": SINUMERIK}, ("nc", "slot.mpf", "--setup", "setup.toml"), ("slot.mpf",), survey=True),
    Case("heidenhain", {"setup.toml": SETUP.replace("fanuc", "heidenhain"), "machine.toml": BARE, "slot.h": HEIDENHAIN}, ("nc", "slot.h", "--setup", "setup.toml"), ("slot.h",), survey=True),
    Case("design", {"design.toml": DESIGN}, ("calibrate", "--design", "design.toml"), ("design.toml",)),
    Case("cut", {"boss.toml": shop.SCENARIO, "mill.toml": shop.MACHINE, "setup.toml": shop.SETUP, "part.nc": shop.PROGRAM}, ("check", "boss.toml"), ("boss.toml", "setup.toml")),
    Case(
        "positions",
        {"machine.toml": MACHINE, "errors.csv": ERRORS, "at.csv": POSITIONS},
        ("field", "machine.toml", "--at", "at.csv"),
        ("at.csv",),
    ),
    Case("measured points", {"ring.toml": ring(), "p.csv": ring_points()}, ("evaluate", "ring.toml", "--points", "p.csv"), ("p.csv",)),
    Case("measured values", {"ring.toml": ring(), "v.csv": "characteristic,value_mm\ndiameter,50.0008\n"}, ("evaluate", "ring.toml", "--values", "v.csv"), ("v.csv",)),
    _other_system("qif", "part.qif", QIF),
    _other_system("dmis", "part.dmi", DMIS),
    _other_system("dcc", "ring.xml", DCC),
)  # fmt: skip
