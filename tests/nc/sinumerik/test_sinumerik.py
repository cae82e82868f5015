"""Sinumerik programs: every feature by a number made by hand, refusals by name and place, the sample programs."""

from __future__ import annotations

import math
from dataclasses import replace

import numpy as np
import pytest

from tests.conftest import data_file
from vcmm.core.errors import DataError, ModelLimit
from vcmm.nc.setup import Setup, Tool
from vcmm.nc.sinumerik.reader import read, tokenize

SETUP = Setup(
    offsets={"G54": (0.0, 0.0, 0.0), "G55": (100.0, 50.0, -10.0)},
    tools={1: Tool(1, diameter=10.0), 2: Tool(2, length=80.0, diameter=6.0, name="MILL_6")},
)


def moves(text, setup=SETUP):
    return read(text, "part.mpf", setup).moves


def ends(text, setup=SETUP):
    return np.array([m.end for m in moves(text, setup)])


def check(text, *points, setup=SETUP):
    got = ends(text, setup)
    assert got.shape == (len(points), 3), got
    assert np.allclose(got, points, atol=1e-9), got


def test_tokens_are_lossless():
    text = 'N10 g1x-12.5 Y=R1+2 ; note\r\nMSG("a;b")\n\tIF R1<>1.5EX-3 GOTOF A_1\nA_1: T="MILL_6" %§\n'
    assert "".join(t.text for t in tokenize(text)) == text
    kinds = [t.kind for t in tokenize("X-12.5 R1 AB_1 1.5EX-3 <> ;c")]
    assert [k for k in kinds if k != "space"] == ["word", "word", "name", "number", "symbol", "comment"]


def test_lines_absolute_incremental_and_per_word():
    check(
        "G0 X10 Y20 Z5\nG91 G1 X5 F100\nX=AC(1) Y5\nG90 X=IC(2)",
        (10, 20, 5), (15, 20, 5), (1, 25, 5), (3, 25, 5),
    )  # fmt: skip


def test_kinds_feed_and_source():
    got = moves("G0 X10\n  N20 G1 X20 F=50*4 S1000 M3\nX30 G95 F0.1")
    assert [m.kind for m in got] == ["rapid", "line", "line"]
    assert [m.feed for m in got] == [None, 200.0, 100.0]  # 0.1 mm x 1000 1/min
    assert got[1].source == (2, 3, 29)
    assert got[1].spindle == 1000.0


def test_inch():
    check("G70 G0 X1\nG71 X1", (25.4, 0, 0), (1, 0, 0))
    assert moves("G70 G1 X1 F100")[0].feed == 100.0  # G70 leaves feeds metric
    assert moves("G700 G1 X1 F10")[0].feed == 254.0


@pytest.mark.parametrize(
    "arc",
    ["G3 X10 Y10 I0 J10", "G3 X10 Y10 J10", "G3 X10 Y10 I=AC(0) J=AC(10)", "G3 X10 Y10 CR=10", "G3 X10 Y10 AR=90",
     "G3 I0 J10 AR=90", "CIP X10 Y10 I1=7.071067811865475 J1=2.928932188134524"],
)  # fmt: skip
def test_the_same_quarter_circle_in_all_its_forms(arc):
    # quarter from (0, 0) about (0, 10) to (10, 10); the middle lies at 10 (sin 45, 1 - cos 45)
    (one,) = moves(f"G1 F100\n{arc}")
    assert np.allclose(one.end, (10, 10, 0), atol=1e-9)
    assert np.allclose(one.centre, (0, 10, 0), atol=1e-9)
    assert one.clockwise is False
    assert one.turns == 1


def test_long_way_round_and_turns():
    (one,) = moves("G1 F100\nG3 X10 Y10 CR=-10")  # the other centre, three quarters
    assert np.allclose(one.centre, (10, 0, 0), atol=1e-9)
    (helix,) = moves("G1 F100\nG2 X0 Y0 Z-6 I5 TURN=2")  # a full circle and two more
    assert (helix.turns, helix.clockwise, helix.end) == (3, True, (0, 0, -6))


def test_planes():
    (one,) = moves("G18 G1 F100\nG2 X10 Z10 K10 I0")  # about (x, z) = (0, 10); G18: first axis Z, second X
    assert (one.plane, one.centre) == ("ZX", (0, 0, 10))
    (two,) = moves("G19 G1 F100\nG3 Y10 Z10 J0 K10")
    assert (two.plane, two.centre) == ("YZ", (0, 0, 10))


def test_arc_that_does_not_fit():
    with pytest.raises(
        DataError, match=r"part.mpf:1:1: .*radius 10.0000 mm at its start, 11.0000 mm at its end"
    ):
        moves("G2 X21 Y0 I10 J0 F100")
    with pytest.raises(DataError, match="CR=4 fits no arc"):
        moves("G2 X10 CR=4 F100")


def test_work_offsets_and_machine_coordinates():
    check("G54 G0 X1 Y1\nG55 X1\nG500 Z1\nSUPA X0 Y0 Z0", (1, 1, 0), (101, 1, 0), (101, 1, 1), (0, 0, 0))
    last = moves("G55 G0 X1\nG53 Z0")[-1]
    assert last.rewritable is False
    assert last.end == (101, 0, 0)


def test_frames():
    check("G0\nTRANS X100 Y20\nX2 Y2\nATRANS X5\nX2 Y2\nTRANS\nX3 Y3", (102, 22, 0), (107, 22, 0), (3, 3, 0))
    # turn by 90 deg: (10, 0) -> (0, 10); ATRANS inside it shifts along the turned axes: (10 + 5, 0) -> (0, 15)
    check("G0\nROT RPL=90\nX10 Y0\nATRANS X5\nX10 Y0", (0, 10, 0), (0, 15, 0))
    # AROT after TRANS: (100, 0) + R30 (10, 0) = (100 + 8.660254, 5)
    check("G0\nTRANS X100\nAROT RPL=30\nX10 Y0", (100 + 10 * math.cos(math.pi / 6), 5, 0))
    # RPY: about Z by 90, then about the new X by 90: (0, 0, 1) -> R_z R_x (0, 0, 1) = R_z (0, -1, 0) = (1, 0, 0)
    check("G0\nROT X90 Z90\nX0 Y0 Z1", (1, 0, 0))
    check("G0\nSCALE X2 Y2\nX10 Y5", (20, 10, 0))


def test_mirror_turns_arcs_and_the_side_of_the_tool():
    text = "T1 D1\nG1 F100\nMIRROR X0\nG0 X-20 Y0\nG41 G1 X0 Y0\nX20\nG3 X30 Y10 CR=10\nG40 G1 X50"
    got = moves(text)
    # mirrored: x -> -x. The tool is left of +x, now right of -x, at y = +5; the arc about (20, 10) becomes clockwise
    assert np.allclose(
        [m.end for m in got[:4]], [(20, 0, 0), (0, 5, 0), (-20, 5, 0), (-25, 10, 0)], atol=1e-9
    )
    assert got[2].compensation == "right"
    assert got[3].clockwise is True
    assert np.allclose(got[3].centre, (-20, 10, 0))


def test_radius_compensation_with_arc_and_mitre_corners():
    contour = "T1 D1\nG0 X-20 Y0\n{} G42 G1 X0 Y0 F100\nX20\nY20\nG40 X40"
    # right of +x: y = -5; around the corner (20, 0) to x = 25
    arc = [(-20, 0, 0), (0, -5, 0), (20, -5, 0), (25, 0, 0), (25, 20, 0), (40, 20, 0)]
    check(contour.format("G450"), *arc)
    check(contour.format("G451"), (-20, 0, 0), (0, -5, 0), (25, -5, 0), (25, 20, 0), (40, 20, 0))


def test_rounding_and_chamfer():
    check("G1 F100\nX20 RND=5\nY20", (15, 0, 0), (20, 5, 0), (20, 20, 0))
    check("G1 F100\nX20 CHR=5\nY20", (15, 0, 0), (20, 5, 0), (20, 20, 0))
    s = 4 / math.sqrt(2)  # CHF is the width across: 4 mm across cut off 4 / sqrt 2 on each side
    check("G1 F100\nX20 CHF=4\nY20", (20 - s, 0, 0), (20, s, 0), (20, 20, 0))
    rounded = moves("G1 F100\nX20 RND=5\nY20")[1]
    assert (rounded.kind, rounded.centre, rounded.clockwise) == ("arc", (15, 5, 0), False)
    with pytest.raises(ModelLimit, match=r"part.mpf:2:1: a rounding of radius 50 mm does not fit"):
        moves("G1 F100\nX20 RND=50\nY20")


def test_rounding_between_line_and_arc():
    # line y = 0 to (10, 0), then clockwise about (20, 0), R = 10, from heading +y. Rounding r = 2 on the left: centre at
    # height 2, distance 10 + 2 from (20, 0): x = 20 - sqrt(144 - 4) = 8.167840; it touches the line below its centre
    got = moves("G1 F100\nX10 RND=2\nG2 X20 Y10 I10 J0")
    x = 20 - math.sqrt(140)
    assert np.allclose(got[1].centre, (x, 2, 0), atol=1e-9)
    assert np.allclose(got[0].end, (x, 0, 0), atol=1e-9)
    assert np.allclose(got[1].end, (20 + (x - 20) * 10 / 12, 2 * 10 / 12, 0), atol=1e-9)


def test_exact_stop_and_tolerance():
    got = moves("G60 G1 X1 F100\nX2\nG64 X3\nG9 X4\nX5\nCYCLE832(0.02,1)\nX6\nG642 CTOL=0.01\nX7")
    assert [m.exact_stop for m in got] == [True, True, False, True, False, False, False]
    assert [m.tolerance for m in got] == [None, None, None, None, None, 0.02, 0.01]


def test_dwell():
    got = moves("S600 M3\nG4 F1.5\nG4 S30")
    assert [m.seconds for m in got] == [1.5, 3.0]  # 30 turns at 600 1/min


def test_tools_by_number_and_name():
    program = read('T="MILL_6"\nM6\nG0 Z0\nT1 M6\nZ0', "part.mpf", SETUP)
    assert [m.tool for m in program.moves] == [2, 1]
    assert program.moves[0].tool_offset == (0, 0, 80)
    assert program.moves[0].start == (0, 0, -80)  # the axes stand at zero, the tip 80 mm below
    assert program.tools == {1: "T1", 2: "MILL_6"}
    without = read("T2 D1\nG0 Z0\nD0 Z0", "part.mpf", SETUP)  # no M6 anywhere: T changes the tool
    assert [m.tool_offset[2] for m in without.moves] == [80, 0]


def test_the_tool_length_stays_along_z():
    program = read("T2 D1\nG0 Z0\nG18 G1 F100\nG2 X10 Z10 K10 I0\nG17 G0 X0", "part.mpf", SETUP)
    assert {m.tool_offset for m in program.moves} == {(0, 0, 80)}
    assert any("stays along Z" in r.text for r in program.warnings)


def test_constant_surface_speed_and_diameters():
    # G96 S100 at the mean diameter 40: 1000 x 100 / (pi x 40) = 795.77 1/min
    got = moves("DIAMON G18 LIMS=2000\nG97 S500 M4\nG0 X40 Z0\nG96 S100 G1 Z-10 F0.2")
    assert got[0].end == (20, 0, 0)
    assert math.isclose(got[1].spindle, -1e5 / (math.pi * 40), rel_tol=1e-12)
    assert math.isclose(got[1].feed, 0.2 * 1e5 / (math.pi * 40), rel_tol=1e-12)
    kept = moves("DIAMON G18 G96 S100 M3 G0 X40\nG1 Z-10 F0.2\nG97\nX80")[
        -1
    ]  # G97 without S keeps the speed reached
    assert math.isclose(kept.spindle, 1e5 / (math.pi * 40), rel_tol=1e-12)


@pytest.mark.parametrize(
    ("text", "value"),
    [
        ("2+3*4", 14), ("(2+3)*4", 20), ("-R1+1", -2), ("7 DIV 2", 3), ("7 MOD 4", 3), ("SIN(30)*2", 1), ("ATAN2(1,1)", 45),
        ("SQRT(POT(3)+POT(4))", 5), ("ROUND(2.5)", 3), ("TRUNC(-2.7)", -2), ("1.5EX1", 15), ("R[R1-2]", 9), ("BOUND(1,3,7)", 3),
        ("1 + 2 == 3", 1), ("NOT 0 AND 1", 1), ("2 > 1 == 1", 1), ("10-4-3", 3), ("12/2/3", 2),
    ],
)  # fmt: skip
def test_expressions(text, value):
    assert np.allclose(ends(f"R1=3 G0\nX={'9' if text == 'R[R1-2]' else text}")[0][0], value)


def test_parameters_and_variables():
    check("DEF REAL a_1=2, b_1\nDEF INT nn\nnn=2.6\nb_1=a_1*2 R[5]=7 G0\nX=a_1 Y=b_1 Z=R5+nn", (2, 4, 10))


def test_control_structures():
    loop = "R1=0 G0\n{}\nR1=R1+1\nX=R1\n{}"
    for head, tail in (
        ("WHILE R1<3", "ENDWHILE"),
        ("REPEAT", "UNTIL R1>=3"),
        ("LOOP\nIF R1>2 GOTOF OUT", "ENDLOOP\nOUT: ;"),
    ):
        check(loop.format(head, tail), (1, 0, 0), (2, 0, 0), (3, 0, 0))
    check("G0\nFOR R1=1 TO 3\nX=R1\nENDFOR", (1, 0, 0), (2, 0, 0), (3, 0, 0))
    branch = "R1={} G0\nIF R1==1\nX1\nELSE\nIF R1==2\nX2\nENDIF\nY3\nENDIF"
    check(branch.format(1), (1, 0, 0))
    check(branch.format(2), (2, 0, 0), (2, 3, 0))
    check(branch.format(5), (0, 3, 0))
    case = "R1={} G0\nCASE R1 OF 1 GOTOF A_A 2 GOTOF B_B DEFAULT GOTOF C_C\nA_A: X1\nB_B: X2\nC_C: X3"
    assert [len(ends(case.format(n))) for n in (1, 2, 7)] == [3, 2, 1]


def test_jumps_and_repeated_parts():
    check("G0\nGOTOF N40\nX1\nN40 X2\nGOTOC NOWHERE\nX3", (2, 0, 0), (3, 0, 0))
    check("G0 G91\nPART: X1\nX2\nREPEAT PART P=2", *[(v, 0, 0) for v in (1, 3, 4, 6, 7, 9)])
    check("G0 G91\nONE: X1\nX2\nREPEATB ONE P2", *[(v, 0, 0) for v in (1, 3, 4, 5)])
    check("G0 G91\nAA: X1\nBB: X2\nX4\nREPEAT AA BB", *[(v, 0, 0) for v in (1, 3, 7, 8, 10)])


def test_subprograms_of_the_same_file():
    check("G0\nSLOT(5, 7)\nX0\nM30\nPROC SLOT(REAL xx, REAL yy)\nX=xx Y=yy\nRET\n", (5, 7, 0), (0, 7, 0))
    check("%_N_MAIN_MPF\nG0\nL100\nX0\nM30\n%_N_L100_SPF\nX9\nM17", (9, 0, 0), (0, 0, 0))


def test_drilling_cycles():
    check("G0 Z50\nF100\nCYCLE81(10,0,2,-15)", (0, 0, 50), (0, 0, 2), (0, 0, -15), (0, 0, 10))
    modal = moves("G0 Z10 F100\nMCALL CYCLE82(10,0,2,,8,0.5)\nX5\nX7\nMCALL\nX9")
    assert [m.kind for m in modal] == ["rapid", *["rapid", "rapid", "line", "dwell", "rapid"] * 2, "rapid"]
    assert [m.end[2] for m in modal[2:4]] == [2, -8]
    # CYCLE83 to -20: first 8, then 8 - 3 = 5 (to -13), then 3 (DAM is the least; to -16), the last 4 halved: -18, -20
    deep = moves("G0 Z10 F100\nCYCLE83(10,0,2,-20,,-8,,3,0,0,0.5,1)")
    assert [m.end[2] for m in deep if m.kind == "line"] == [-8, -13, -16, -18, -20]
    assert [m.feed for m in deep if m.kind == "line"] == [50, 100, 100, 100, 100]


@pytest.mark.parametrize(
    ("text", "message"),
    [
        ("G1 X1 F100\nBSPLINE X5", r"part.mpf:2:1: BSPLINE \(spline\)"),
        ("N5 TRAORI", "part.mpf:1:4: TRAORI"),
        ("G0 X1\nG33 Z5 K1", "part.mpf:2:1: G33"),
        ("G0 X1\n  CALL_ME(3)", "part.mpf:2:3: CALL_ME is neither a subprogram"),
        ("G1 X=depth F1", "part.mpf:1:6: the variable DEPTH is not defined"),
        ("DEF REAL depth\nX=depht", 'Did you mean "DEPTH"'),
        ("G1 X5", "part.mpf:1:1: no feed"),
        ("G0 X5 X6", "part.mpf:1:7: X stands twice"),
        ("IF R1==1\nG0 X1", "part.mpf:1:1: this is never closed; add ENDIF"),
        ("ENDWHILE", "closes nothing"),
        ("GOTOF FINE\nM30\nFIN: M30", 'there is no FINE further down.*Did you mean "FIN"'),
        ("G41 G1 X5 F100", "no known radius; state its diameter"),
        ("T1 D2", "part.mpf:1:4: D2"),
        ("G0 X=1/0", "part.mpf:1:7: division by zero"),
        ("G0 U5", "part.mpf:1:4: the address U is not understood"),
        ("X=", "the line ends"),
        ("X1 )", r"part.mpf:1:4: \"\)\" cannot be understood"),
        ("G0\nAA: X1 REPEATB AA", "the repeated part holds its own REPEAT"),
        ("LOOP\nENDLOOP", "seems to be endless"),
        ("DEF STRING[10] name", "takes REAL, INT or BOOL"),
        ("G0 $P_UIFR[1,X,TR]=5", "system variables"),
        ("T1 D1\nG41 G1 X9 F9\nTRANS X1", "part.mpf:3:1: a frame .* while radius compensation is on"),
        ("G2 X10 Y0 I5 J0 F100\nROT X30\nG2 X0 Y0 I-5 J0", "an arc of the plane XY under a rotation out of that plane"),
    ],
)  # fmt: skip
def test_refused_by_name_and_place(text, message, monkeypatch):
    monkeypatch.setattr("vcmm.nc.sinumerik.flow.LONGEST", 1000)
    with pytest.raises(DataError, match=message):
        moves(text)


def test_block_skip():
    from dataclasses import replace

    assert len(moves("G0 X1\n/X2\nX3")) == 3
    assert len(moves("G0 X1\n/X2\nX3", replace(SETUP, block_delete=True))) == 2


# The sample programs: their comments say what they mean.


def sample(name):
    return data_file(f"data/nc/mit/sinumerik_{name}.mpf").read_bytes().decode()


def test_sample_arcs():
    got = moves(sample("arc"))
    assert [m.kind for m in got] == ["line", "arc", "line", "arc", "arc", "line", "arc"]
    assert np.allclose(got[-1].centre, (80, 60, 10))  # CR=20 over a chord of 40: a half circle
    assert got[4].end == (0, 0, 10)


def test_sample_jumps_loops_frames():
    assert [m.end[0] for m in moves(sample("goto"))] == [0, 30, 40, 50]
    # 101 rows of 1 mm from 950 to 1050, two moves each, and three moves before them
    assert len(moves(sample("loop"))) == 3 + 2 * 101
    assert np.allclose(
        ends(sample("trans_reset")), [(1, 1, 0), (102, 22, 0), (13, 3, 0), (4, 4, 0), (55, 5, 0), (6, 6, 0)]
    )


def test_sample_splines_are_refused():
    with pytest.raises(DataError, match=r"part.mpf:10:1: BSPLINE"):
        moves(sample("spline"))


@pytest.mark.parametrize("name", ["arc", "goto", "loop", "spline", "trans_reset"])
def test_samples_are_lossless(name):
    assert "".join(t.text for t in tokenize(sample(name))) == sample(name)


def test_skip_levels_and_words_behind_a_message():
    """/2 is one of ten switches; the text of MSG ends with its bracket."""
    text = 'G1 X10 F100\n/2 X20\n/ X30\nMSG("A (B) M30") X40\n'
    setup = Setup(offsets={"G54": (0.0, 0.0, 0.0)})
    assert [m.end[0] for m in read(text, "part.mpf", setup).moves] == [10, 20, 30, 40]
    skipping = replace(setup, block_delete=True)
    assert [m.end[0] for m in read(text, "part.mpf", skipping).moves] == [10, 40]
