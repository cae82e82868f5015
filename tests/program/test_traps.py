"""Small programs whose right path the manual says and that were once read wrongly, each in silence. Both levels."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.moves import Program
from vcmm.program.setup import Setup, Tool

TOOLS = {1: Tool(1, 0.0, 10.0), 5: Tool(5, 0.0, 10.0)}


def read(text: str, dialect: str, strict: bool = False) -> Program:
    return interpret(
        text,
        dialect,
        Setup(strict=strict, tools=TOOLS, offsets={"G54": (0.0, 0.0, 0.0), "G55": (100.0, 0.0, 0.0)}),
    )


def ends(text: str, dialect: str, strict: bool = True) -> list[tuple[float, ...]]:
    return [tuple(round(v, 6) for v in m.end) for m in read(text, dialect, strict).moves]


def test_g53_under_g91_is_passed_over_by_fanuc():
    # FANUC B-64304EN, machine coordinate system (G53): "when an incremental command is specified, the G53 command is ignored"
    text = "G21 G90 G54\nG0 X5. Z5.\nG91 G53 G0 Z-10.\nG90 G0 X6.\nM30\n"
    assert ends(text, "fanuc", strict=False) == [(5, 0, 5), (6, 0, 5)]
    assert "G53 under G91" in {a.what for a in read(text, "fanuc").assumed}
    with pytest.raises(DataError, match="3:5: G53 is passed over under G91"):
        read(text, "fanuc", strict=True)
    assert ends(text, "haas") == [
        (5, 0, 5),
        (5, 0, -10),
        (6, 0, -10),
    ]  # a position of the machine whatever G90 and G91 say


def test_m73_restores_the_modes_of_the_caller():
    # LinuxCNC, "M73 save and autorestore modal state": G91 of the subprogram ends with it
    text = "G21 G90 G54\no100 sub\nM73\nG91 G55\nG0 X5\no100 endsub\nG0 X0\no100 call\nG0 X1\nM2\n"
    assert ends(text, "linuxcnc") == [(0, 0, 0), (5, 0, 0), (1, 0, 0)]


def test_m72_leaves_the_motion_code():
    # LinuxCNC, "M70 save modal state": "in particular, the motion mode (G1 etc) is NOT restored"
    made = read("G21 G90 G54 F100\nG1 X1\nM70\nG0 X2\nM72\nX3\nM2\n", "linuxcnc", strict=True).moves
    assert [m.kind for m in made] == ["line", "rapid", "rapid"]


def test_an_index_of_a_tool_is_told():
    # TNC 640, "indexed tools": 5.2 is another length and radius of tool 5
    text = "BEGIN PGM A MM\nTOOL CALL 5.2 Z S100\nL X+10 F100\nEND PGM A MM\n"
    assert "tool 5.2, an index of tool 5" in {a.what for a in read(text, "heidenhain").assumed}
    with pytest.raises(DataError, match=r"TOOL CALL 5.2 takes length and radius of an index of tool 5"):
        read(text, "heidenhain", strict=True)


def test_a_modal_rounding_leaves_the_end_of_the_contour():
    # 840D sl, "RNDM": corners between the blocks; the last one has no follower
    text = "G54 G90 F100\nG0 X0 Y0\nRNDM=2\nG1 X10\nY10\nX0\nRNDM=0\nM30\n"
    assert ends(text, "sinumerik")[1:] == [(8, 0, 0), (10, 2, 0), (10, 8, 0), (8, 10, 0), (0, 10, 0)]


def test_g68_of_mach3_turns_about_a_and_b():
    # Mach3Mill, "G68 A- B- I- R-": A and B are coordinates of the centre, no axes; I adds R to the turn in force
    text = "G21 G90\nG68 A10 B0 R90\nG0 X20 Y0\n{more}G69\nM2\n"
    assert ends(text.format(more=""), "mach3") == [(10, 10, 0)]
    assert not any(m.rotary_end != (0.0, 0.0, 0.0) for m in read(text.format(more=""), "mach3").moves)
    assert ends(text.format(more="G68 A10 B0 I1 R90\nX20 Y0\n"), "mach3")[-1] == (0, 0, 0)  # 180 deg: 10 - 10


def test_g28_1_of_mach3_goes_home():
    # Mach3Mill, "reference axes G28.1"; LinuxCNC stores the position and moves nothing
    text = "G21 G90\nG0 X5\nG28.1 X7\nM2\n"
    assert ends(text, "mach3", strict=False) == [(5, 0, 0), (7, 0, 0), (0, 0, 0)]
    with pytest.raises(DataError, match=r"3:1: G28\.1 of Mach3 sends the axes to their switches"):
        read(text, "mach3", strict=True)


def test_g77_of_a_haas_mill_is_no_turning_cycle():
    # Haas mill operator's manual, G77 back bore; G77 turns on lathes of systems B and C
    text = "G21 G90 G54\nG0 X0 Y0 Z10.\nG77 X5. Z-5. R2. F100.\nG80\nM30\n"
    assert ends(text, "haas", strict=False) == [(0, 0, 10)]
    assert "G77 of Haas (back boring)" in {a.what for a in read(text, "haas").assumed}
    with pytest.raises(DataError, match=r"G77 .back boring. is not understood"):
        read(text, "haas", strict=True)


def test_grbl_has_no_radius_compensation():
    # grbl 1.1: G40 is accepted, G41 and G42 are error:20
    with pytest.raises(DataError, match="grbl has no radius compensation and stops at G41"):
        read("G21 G90\nG41 D1\nG1 X20 F100\nM2\n", "grbl", strict=True)


def test_t_preselects_where_m6_changes_the_tool():
    # 840D sl, "tool change with M6": T prepares, M6 changes; without any M6 in the program T changes
    text = "G54 G90 F100\nT1 {m}\nG0 X0\nT5\nG1 X10\n{m}\nG1 X20\nM30\n"
    assert [m.tool for m in read(text.format(m="M6"), "sinumerik", strict=True).moves] == [1, 1, 5]
    assert [m.tool for m in read(text.format(m=""), "sinumerik", strict=True).moves] == [1, 5, 5]


def test_rots_turns_by_solid_angles():
    # X20 Y10: the new X = (cos 10, 0, -sin 10) = (0.984808, 0, -0.173648), beside it (0, cos 20, sin 20) = (0, 0.939693, 0.342020);
    # normal (0.163176, -0.336824, 0.925417) / 0.998235 = (0.163464, -0.337420, 0.927053); new Y = normal x new X = (0.058592, 0.941354, 0.332294)
    text = "G17 G90 G0 X0 Y0 Z0 F100\nROTS X20 Y10\nG1 X10\nG1 X0 Y10\nG1 Y0 Z10\nROTS\nG1 X5 Z0\nM30\n"
    expected = [
        (0, 0, 0),
        (9.848078, 0, -1.736482),
        (0.58592, 9.41354, 3.32294),
        (1.63464, -3.3742, 9.27053),
        (5, -3.3742, 0),
    ]
    for end, right in zip(ends(text, "sinumerik"), expected, strict=True):
        assert end == pytest.approx(right, abs=2e-5)
    # Z90 X0, first axis Z: the new Z = (0, sin 0, cos 0); X turned about Z by 90 deg is Y: then X' = Y Z-wise in turn, as ROT Z90
    assert ends("G0 X0 Y0 Z0\nROTS Z90 X0\nX10\nM30\n", "sinumerik")[1] == pytest.approx((0, 10, 0))
    assert ends("G0 X0 Y0 Z0\nAROTS Z90\nX10\nM30\n", "sinumerik")[1] == (0, 10, 0)
    framed = "G0 X0 Y0 Z0\n$P_UIFR[1]=CROTS(X,20,Y,10)\nG54\nM30\n"
    with pytest.raises(DataError):
        read("ROTS X1 Y2 Z3\nM30\n", "sinumerik")
    assert read(framed, "sinumerik").moves


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("TRAORI\nPTP\nG1 X10 F100\n", "PTP (under a transformation the axes go from point to point)"),
        ("PTP\nTRAORI\nG1 X10 F100\n", "PTP (under a transformation the axes go from point to point)"),
        ('TANG(C,X,Y,1,"B")\nTANGON(C,90)\nG1 X10 F100\nTANGOF(C)\n', "TANGON (a rotary axis follows the direction of the path)"),
        ("TRAILON(Y,X,2)\nG1 X10 F100\nTRAILOF(Y,X)\n", "TRAILON (an axis that goes along with another)"),
        ("GEOAX(1,C)\nG1 X10 F100\n", "GEOAX (other axes become X, Y, Z)"),
    ],
)  # fmt: skip
def test_what_couples_axes_is_named_as_what_it_is(text, what):
    # each was told as a missing subprogram ("a hole in the path")
    told = {a.what for a in read(text + "M30\n", "sinumerik").assumed}
    assert what in told
    assert not any("subprogram" in t for t in told)
    with pytest.raises(DataError, match=what.split()[0]):
        read(text + "M30\n", "sinumerik", strict=True)


def test_point_to_point_without_a_transformation_is_nothing():
    text = "PTP\nG1 X10 STAT='B10' TU='B100' F100\nCP\nTRAORI\nG1 Y5\nM30\n"
    assert ends(text, "sinumerik") == [(10, 0, 0), (10, 5, 0)]


def test_an_arc_by_its_radius_that_ends_where_it_starts_says_what_the_control_does():
    klartext = "BEGIN PGM A MM\nTOOL CALL 5 Z S1\nL X+10 Y+0 Z+0 R0 F100\nCR X+10 Y+0 R+5 DR+\nEND PGM A MM\n"
    with pytest.raises(DataError, match="a TNC draws no full circle by R"):
        read(klartext, "heidenhain")
    with pytest.raises(DataError, match="one of 0 degrees on a FANUC, which does not move"):
        read("G21 G90 G0 X10. F100.\nG2 X10. R5.\nM30\n", "fanuc")
    with pytest.raises(DataError, match="must end elsewhere than it starts"):
        read("G21 G90 G0 X10. F100.\nG2 X10. R5.\nM30\n", "haas")


def test_g58_leaves_what_g59_has_set_and_the_other_way_round():
    # Siemens, "G58, G59": TRANS X10 and G59 X5: 15; G58 X1: 1 + 5 = 6; G59 X2: 1 + 2 = 3; ATRANS X4: 1 + 2 + 4 = 7; G59 X0: 1; TRANS: 0
    text = "G90 G0 X0 Y0 Z0\nTRANS X10\nG59 X5\nX0\nG58 X1\nX0\nG59 X2\nX0\nATRANS X4\nX0\nG59 X0\nX0\nTRANS\nX0\nM30\n"
    assert [e[0] for e in ends(text, "sinumerik")] == [0, 15, 6, 3, 7, 1, 0]


def test_mod_of_macro_b_has_the_sign_of_its_dividend():
    # FANUC B-64304EN, MOD: negative where the dividend is; -5 = -1 x 3 - 2. LinuxCNC: never negative
    assert ends("G21 G90 G0 X[-5 MOD 3]\nM30\n", "fanuc") == [(-2, 0, 0)]
    assert ends("G21 G90 G0 X[-5 MOD 3]\nM2\n", "linuxcnc") == [(1, 0, 0)]


def test_axes_beside_a_dwell_move_nothing():
    # FANUC: X is the time; the block moved to X2 Y3 in silence
    text = "G21 G90 G0 X1.\nG4 X2. Y3.\nG66 P10 A1.\nG67 X5.\nX2.\nM30\nO10\nM99\n"
    assert ends(text, "fanuc", strict=False) == [(1, 0, 0), (1, 0, 0), (2, 0, 0)]
    assert [u.word for u in read(text, "fanuc").unused] == ["Y3.", "X5."]
    with pytest.raises(DataError, match='2:8: nothing in this block uses the word "Y"'):
        read(text, "fanuc", strict=True)


def test_a_scale_without_a_factor_is_a_setting_of_the_control():
    # FANUC B-64304EN, scaling: where P is left out, parameter 5411 is the factor
    text = "G21 G90 G51 X5. Y0.\nG0 X10.\nG50\nM30\n"
    assert "the factor of G51 without P or I J K (FANUC parameter 5411, by axis 5421)" in {
        a.what for a in read(text, "fanuc").assumed
    }
    with pytest.raises(DataError, match="Haas setting 71"):
        read(text, "haas", strict=True)
