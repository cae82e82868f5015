"""One right set of files for each reader that came last: exports of measuring software, nominal points, knowledge, routes, reversal, placing."""

from __future__ import annotations

import math

from tests.hostile.corpus import (  # fmt: skip
    AXES,
    BARE,
    MACHINE,
    POSITIONS,
    RECORDING,
    SETUP,
    TOUCHES,
    TOUCHES_CSV,
    Case,
    ring,
    ring_points,
)
from tests.plate import PLATE

CALYPSO = "planid\tpartnb\tid\ttype\tidsymbol\tactual\tnominal\tuppertol\tlowertol\tdeviation\tunit\n" + "".join(
    f"ring\t{p}\tdiameter\tD1\tdiameter\t50,00{a}\t50,0000\t0,0040\t-0,0040\t0,00{a}\tmm\n" for p, a in ((17, 12), (18, 21))
) + "END\n"  # fmt: skip
PCDMIS = """DIM diameter= LOCATION OF CIRCLE CIR1  UNITS=MM ,$
GRAPH=OFF  TEXT=OFF  MULT=10.00  OUTPUT=BOTH
AX    NOMINAL       MEAS       +TOL       -TOL        DEV     OUTTOL
D     50.0000    50.0012     0.0040     0.0040     0.0012     0.0000
END OF DIMENSION diameter
DIM POS1= TRUE POSITION OF CIRCLE CIR1  UNITS=MM ,$
AX    NOMINAL       MEAS       +TOL       -TOL      BONUS        DEV     OUTTOL
X      0.0000     0.0031                                      0.0031
TP        RFS     0.0062     0.0500                0.0000     0.0062     0.0000
END OF DIMENSION POS1
"""
NOMINAL = "x_mm,y_mm,z_mm,nx,ny,nz\n" + "".join(
    f"{x},{y},{20 - 0.001 * x * x:.4f},{0.002 * x / math.hypot(1, 0.002 * x):.6f},0,{1 / math.hypot(1, 0.002 * x):.6f}\n"
    for x in range(-30, 31, 10)
    for y in range(-30, 31, 10)
)
BLADE = """vcmm = "scenario/1"
machine = "machine.toml"
[part.features]
blade = { type = "points", nominal = "blade.csv" }
[[part.characteristics]]
name = "blade"
type = "surface_profile"
of = "blade"
zone = "0.05 mm"
[pose]
shift = "300 250 -250 mm"
[plan]
touch = { speed = "5 mm/s", approach = "3 mm", clearance = "20 mm" }
styli.down = { offset = "0 0 -120 mm", tip_diameter = "4 mm" }
[[plan.steps]]
feature = "blade"
stylus = "down"
points = { strategy = "nominal", every = 2 }
"""
PLACED = """
[placement]
x = ["250 mm", "350 mm"]
turn_z = ["0 deg", "90 deg", "180 deg"]
faces_down = ["-z"]
objective = "U/T"
weights = { "bore diameter" = 0.7, "bore square to top" = 0.3 }
process = { "bore diameter" = { mean = "0.001 mm", u = "0.003 mm" } }
[surroundings]
head = { diameter = "60 mm", length = "100 mm" }
clamps = { left = { centre = "-80 0 0 mm", size = "20 20 20 mm", on = "part" } }
table = "-390 mm"
safe = "2 mm"
wall = "5 mm"
"""
KLIPPER = "# step_dist=0.0025\ntime,mcu_pos_z,frame_t,bed_t\n" + "".join(
    f"2021/06/13-05:42:{i:02d},{-1000 + 4 * i},21.{i},23.4\n" for i in range(10, 20)
)
FACE = "C_deg,instrument,setup,d_um\n" + "".join(
    f"{45 * i},{probe},{setup},{0.002 * math.cos(math.pi * i / 2) + 0.001 * (probe == 'outer'):.6f}\n"
    for setup in ("normal", "reversed")
    for i in range(16)
    for probe in ("centre", "outer")
)
REVERSAL = 'vcmm = "recording/1"\ndata = "face.csv"\nkind = "displacement"\n[noise]\nu = "1 nm"\n[reversal]\ntest = "face"\nprobes = { centre = "0 mm", outer = "25 mm" }\nharmonics = 3\n'
KNOWN = "tool_radius[1].dr_um,scatter.value#2_um\n" + "0.5,0.1\n" * 12
LENGTHS = "X_mm,Y_mm,Z_mm,offset_z_mm,from_x_mm,from_y_mm,from_z_mm,setup,d_um\n" + "".join(
    f"{20 * i},{(37 * i) % 200},{-((53 * i) % 150)},-100,-200,-150,-{300 + 100 * (i % 2)},s{1 + i % 2},{0.3 * (i % 5)}\n" for i in range(24)
)  # fmt: skip
TRACED = RECORDING + (
    'data = "lengths.csv"\nkind = "length"\nobserved = "indicated - true"\n[nuisance]\nstation = "setup"\nzero = "setup"\n[noise]\nu = "0.3 um"\n'
    '[instrument]\nname = "LaserTracer"\nu = { scale = "0.2 um/m" }\nredraw = "machine"\n'
)
CERTIFIED = 'vcmm = "machine/1"\nname = "m"\nkind = "cmm"\nstructure = "w X\' b Y Z t"\n' + AXES + """[certificate]
E0_MPE = "1.8 um + L/350"
R0_MPL = "1.5 um"
P_Form_Sph_1x25 = "1.8 um"
prior = "limit"
"""  # fmt: skip
TOGETHER = """[[inputs]]
names = ["scale_expansion[X].alpha", "channel.temp_air_C"]
covariance = [[0.25, 0.005], [0.005, 0.01]]
"""
ALTAZ = "az_deg,alt_deg,d_az_arcsec,d_alt_arcsec\n" + "".join(
    f"{30 * i},{20 + 4 * i},{i % 3},{i % 2}\n" for i in range(12)
)
OKUMA = """G15 H1
G0 X10 Y10
G56 Z20 H1
S1000 M3
V1=5
G1 Z-2 F100
NLAP1 X=V1*[2]
V1=V1+1
IF [V1 LT 8] NLAP1
G2 X24 Y20 I0 J10
M2
"""
LINUXCNC = """G21 G90 G94 G54
T1 M6
G43 H1
S1000 M3
#<depth> = 2.5
G0 X0 Y0 Z5
o100 repeat [3]
G91 G1 X1 F100
G90
o100 endrepeat
G1 Z-[#<depth>*2]
M2
"""
ROUTES = {
    "ring.toml": ring(),
    "calibrated.csv": "characteristic,value_mm,U_um,k\ndiameter,50.0002,0.3,2\n",
    "repeats.csv": "characteristic,value_mm,temp_part_C\n" + "".join(f"diameter,50.000{i % 4},20.{i}\n" for i in range(10)),
    "positions.csv": "position,characteristic,value_mm\n" + "".join(f"{p},diameter,50.000{(3 * p + i) % 7}\n" for p in range(4) for i in range(5)),
    "standards.csv": "standard,name,calibrated_mm,U_um,k,reading_mm\n" + "".join(f"length,b{i % 2},{50 + 50 * (i % 2)},0.1,2,{50 + 50 * (i % 2) + 0.0001 * i}\n" for i in range(6)),
}  # fmt: skip
PROBED = SETUP.replace(
    "[stock]",
    """[tools.9]
length = "120 mm"
diameter = "6 mm"
shape = "probe"
[tools.4]
length = "60 mm"
offset_x = "10 mm"
shape = "turning"
nose_radius = "0.8 mm"
orientation = 3
width = "3 mm"
[tools.5]
length = "80 mm"
diameter = "8 mm"
shape = "bull"
corner_radius = "1 mm"
driven = "x"
[[surfaces]]
offset = "G54"
point = "12 0 0 mm"
diameter = "30 mm"
inside = true
height = "20 mm"
[[surfaces]]
offset = "G54"
point = "0 0 0 mm"
normal = [0, 0, 1]
[temperature]
air = "21 degC"
part = "20.5 degC"
[stock]""",
).replace("[offsets]", "set_with = 9\nwork_spindles = { G55 = 2 }\n[offsets]")
CUT_SETUP = SETUP.replace("[control]", "[control]\ncompensation = []")
WRONG_MILL = BARE + '[[effects]]\neffect = "scale_factor"\naxis = "X"\nk = "60 um/m"\n'


def _read(name: str, head: str, data: str, text: str, *mutated: str, **more: str) -> Case:
    files = {"recording.toml": head, "machine.toml": BARE, data: text, **more}
    return Case(name, files, ("check", "recording.toml"), mutated or ("recording.toml", data))


def _ring_values(name: str, file: str, text: str) -> Case:
    return Case(
        name,
        {"ring.toml": ring(), file: text},
        ("evaluate", "ring.toml", "--values", file),
        (file,),
        survey=True,
    )


def _program(dialect: str, file: str, text: str) -> Case:
    files = {"setup.toml": SETUP.replace("fanuc", dialect), "machine.toml": BARE, file: text}
    return Case(dialect, files, ("nc", file, "--setup", "setup.toml"), (file,), survey=True)


NEWEST = (
    _ring_values("calypso", "ring_chr.txt", CALYPSO),
    _ring_values("pc-dmis", "report.txt", PCDMIS),
    Case("list of points", {"ring.toml": ring(), "p.asc": ring_points().replace(",", " ").split("\n", 1)[1]}, ("evaluate", "ring.toml", "--points", "p.asc"), ("p.asc",), survey=True),
    Case("nominal points", {"blade.toml": BLADE, "machine.toml": MACHINE.replace('[errors]\ntable = "errors.csv"\nuncertainty', "[unused]\nuncertainty").split("[unused]")[0], "blade.csv": NOMINAL}, ("check", "blade.toml"), ("blade.toml", "blade.csv")),
    Case("placement", {"plate.toml": PLATE + PLACED}, ("check", "plate.toml"), ("plate.toml",)),
    _read("klipper", RECORDING + 'data = "log.csv"\nkind = "displacement"\nformat = "klipper"\n[line]\nat = { X = "100 mm", Y = "100 mm", Z = "-10 mm" }\n', "log.csv", KLIPPER),
    _read("altaz", 'vcmm = "recording/1"\nname = "r"\nmachine = "mount.toml"\ndata = "a.csv"\nkind = "angle"\nformat = "altaz"\n', "a.csv", ALTAZ, **{"mount.toml": 'vcmm = "machine/1"\nstructure = "w b C B t"\n[axes.C]\ntravel = ["-400 deg", "400 deg"]\n[axes.B]\ntravel = ["-100 deg", "100 deg"]\n'}),
    Case("reversal", {"face.toml": REVERSAL, "face.csv": FACE}, ("test", "face.toml", "--iso", "230-7", "--trials", "40"), ("face.toml", "face.csv")),
    _read("known", TOUCHES.replace("[noise]", '[known]\ndata = "known.csv"\n[noise]'), "touches.csv", TOUCHES_CSV, "recording.toml", "known.csv", **{"known.csv": KNOWN, "log.csv": "time_s,temp_air_C\n0,20\n60,21\n120,20\n"}),
    _read("lengths", TRACED, "lengths.csv", LENGTHS),
    Case("certificate", {"machine.toml": CERTIFIED}, ("check", "machine.toml"), ("machine.toml",)),
    Case("known together", {"machine.toml": MACHINE + TOGETHER, "errors.csv": "X EXX\n0 0.001\n600 0.002\n"}, ("check", "machine.toml"), ("machine.toml",)),
    Case("probes and driven tools", {"setup.toml": PROBED, "machine.toml": BARE}, ("check", "setup.toml"), ("setup.toml",)),
    _program("okuma", "part.min", OKUMA),
    _program("linuxcnc", "part.ngc", LINUXCNC),
    Case("calibrated part", ROUTES, ("routes", "ring.toml", "--calibrated", "calibrated.csv", "--repeats", "repeats.csv"), ("calibrated.csv", "repeats.csv")),
    Case("several positions", ROUTES, ("routes", "ring.toml", "--positions", "positions.csv", "--standards", "standards.csv"), ("positions.csv", "standards.csv")),
    Case("compensated points", {"setup.toml": CUT_SETUP.replace("machine.toml", "mill.toml"), "mill.toml": WRONG_MILL, "p.csv": POSITIONS}, ("compensate", "mill.toml", "--points", "p.csv", "--out", "made.csv"), ("p.csv",)),
)  # fmt: skip
