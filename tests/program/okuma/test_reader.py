"""Okuma programs: moves, by hand, and lines in the words of the G-code family."""

from __future__ import annotations

from pathlib import Path

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.okuma.names import OkumaNames, is_system
from vcmm.program.okuma.reader import OkumaLines, is_turning, read
from vcmm.program.reading import guess
from vcmm.program.setup import Setup, Tool

SURVEY = Setup(strict=False)
TURNED = """$PART.MIN%
OMAIN
G50 S2000
NAT01 T010101
G97 S1000 M3
G0 X100. Z5.
G85 NLAP1 D20. F0.3 U0.4 W0.1
NLAP1 G81
G0 X60.
G1 Z-20. F0.15
X100.
G80
G87 NLAP1
V1=0
NLOOP G0 X=V1*2+100
V1=V1+1
IF [V1 LT 3] NLOOP
CALL OSUB DEP=5 Q2
M2
OSUB
G91 G1 Z=-DEP F0.2
G90
RTS
"""


def test_a_turning_program():
    """X counts diameters: passes at radius 50.2, 40.2 and 30.2 (D 20 is 10 mm a side; U 0.4, W 0.1), the contour, loop, calls."""
    program = read(TURNED, "part.min", SURVEY)
    cuts = [m for m in program.moves if m.kind == "line" and m.source.line == 7]
    assert sorted({round(m.start[0], 6) for m in cuts if m.start[0] == m.end[0]}, reverse=True) == [
        40.2,
        30.2,
    ]
    finish = [m.end for m in program.moves if m.source.line in (10, 11)]
    assert finish == [(30, 0, -20), (50, 0, -20)]
    assert [m.end[0] for m in program.moves if m.source.line == 15] == [50, 51, 52]
    assert [m.end[2] for m in program.moves if m.source.line == 21] == [0, -5]
    assert program.moves[-1].feed == pytest.approx(200)
    assert guess(TURNED, Path("part.nc"))[0] == "okuma"


def test_a_contour_before_its_cycle():
    text = (
        "G0 X50. Z5.\nG97 S500 M3\nNL1 G81\nG0 X30.\nG1 Z-10. F0.1\nX50.\nG80\nG85 NL1 D20. F0.3\nG0 X60.\nM2"
    )
    program = read(text, "part.min", SURVEY)
    assert (program.moves[-1].source.line, program.moves[-1].end[0]) == (9, 30)
    assert len([m for m in program.moves if m.source.line == 9]) == 1


def test_a_milling_program():
    """G15 H2 is G55; G56 H1 brings the length in; cycles as Fanuc's."""
    setup = Setup(offsets={"G55": (100.0, 0.0, 0.0)}, tools={1: Tool(1, length=50.0)}, strict=False)
    program = interpret("G15 H2\nT1 M6\nG0 X1. Y2.\nG56 Z10. H1\nG1 Z-1. F100.\nG4 F2\nM2", "okuma", setup)
    assert program.moves[0].end[:2] == (101, 2)
    assert program.moves[-2].end == (101, 2, -1)
    assert program.moves[-2].tool_offset[2] == 50
    assert program.moves[-1].seconds == 2


def test_what_is_missing_is_told_and_refused_in_strict_reading():
    text = "VFST=#81H\nCALL OO30 PAXI=4 PLI=5.9\nG0 X1. Z=PR\nM2"
    told = {a.what: a.line for a in read(text, "part.min", SURVEY).assumed}
    assert told["the setting of VFST"] == 1
    assert told["the value of PR"] == 1
    assert any("OO30" in what for what in told)
    with pytest.raises(DataError, match=r"part.min:1:1: the setting of VFST is not known here"):
        read(text, "part.min", Setup())


def test_lathe_or_mill():
    assert is_turning("G0 X1 Z2")
    assert not is_turning("G0 X1 Y2")
    assert not is_turning("G15 H1\nG0 X1")
    assert is_system("VZOFX")
    assert not is_system("VC12")
    assert OkumaNames(frozenset()).value("#81H") == "129"


def test_the_drawing_of_a_blank_moves_nothing_and_is_no_reason_to_refuse():
    # OSP-P200L, animation: DEF WORK, PS (shape), PT (its tool), END, DRAW
    text = "$A.MIN%\nDEF WORK\nPS LC,[0,0],[100,50]\nPT LF,[0,0]\nEND\nDRAW\nS500 M3\nG0 X50. Z2.\nG1 Z-10. F0.2\nM2"
    for strict in (True, False):
        moves = read(text, "a.min", Setup(strict=strict)).moves
        assert [(m.end[0], m.end[2]) for m in moves] == [(25, 2), (25, -10)]
    with pytest.raises(DataError, match="the setting of VZOFZ is not known here"):
        read(text.replace("DRAW", "VZOFZ=10"), "a.min", Setup())


def lathe(text: str) -> list[str]:
    return [line.strip() for line in OkumaLines(text, True).translate().split("\n")]


def mill(text: str) -> list[str]:
    return [line.strip() for line in OkumaLines(text, False).translate().split("\n")]


def test_names_become_numbers():
    """V1, names of two letters and more, sequence names, names of programs; as many lines as before."""
    assert lathe("$A.MIN%\nOMAIN\nV1=3\nNLOOP G0 X=V1*2\nDEP=V1+1\nIF [V1 LT 5] NLOOP\nGOTO N10\nN10 M2") == [
        "", "O9000", "#600=[3]", "N900000 G0 X[#600*2]", "#601=[#600+1]", "IF [#600 LT 5] GOTO 900000", "GOTO 10", "N10 M2",
    ]  # fmt: skip
    assert lathe("CALL OSUB DEP=5 LEN=V9 Q2\nOSUB\nRTS")[0] == "#600=[5] #601=[0] M98 P9000 L2"


def test_words_of_the_lathe():
    assert lathe("G50 S2000\nT010203\nG2 X5 Z6 L7 F.1\nG4 F2.5\nG13 G0 X1") == [
        "G92 S2000", "T0203", "G2 X5 Z6 R7 F.1", "G4 P2.5", "G0 X1",
    ]  # fmt: skip


def test_a_contour_of_lap():
    """The blocks from G81 to G80; D is a diameter; the flow jumps over them, wherever they stand."""
    got = lathe("G85 NLAP1 D4 F0.3 U0.4 W0.1\nNLAP1 G81\nG0 X40\nN9 G1 Z-2\nG80\nG87 NLAP1")
    assert got == [
        "G71 P900000 Q900001 D2.0000 F0.3 U0.4 W0.1", "N900002 GOTO 900001", "N900000 G0 X40", "N9 G1 Z-2", "N900001",
        "G70 P900000 Q900001",
    ]  # fmt: skip
    assert lathe("NL2 G82\nG0 Z1\nG1 X2\nG80\nG85 NL2 D2")[-1].startswith("G72 P")


def test_words_of_the_mill():
    assert mill("G15 H2\nT5 M6\nG56 HA\nG56 H3\nG53\nM54\nG15 H8") == [
        "G55",
        "T5 M6",
        "G43 H5",
        "G43 H3",
        "G49",
        "G99",
        "G54.1 P2",
    ]


def test_lines_that_go_on():
    assert lathe("G0 X1\n$Z2") == ["G0 X1 Z2", ""]


@pytest.mark.parametrize(
    ("text", "what"),
    [
        ("VZOFX[1]=5", "the setting of VZOFX[1]"), ("G20 HP=4", "G20"), ("DRAW", "DRAW"), ("MODIN OA", "MODIN"), ("G71 X5 Z-20 B60", "the cycle G71"),
        ("G85 NLAP9 D4", "the contour LAP9 of LAP"),
    ],
)  # fmt: skip
def test_what_has_no_like_is_told(text: str, what: str):
    lines = OkumaLines(f"\n{text}", True)
    assert lines.translate().strip() == ""
    assert [(line, told) for line, told, _, _ in lines.assumptions] == [(2, what)]


def test_turret_and_spindle_move_nothing_and_g116_changes_the_tool():
    assert [line.strip() for line in lathe("G13 G140")] == ["G15"]  # of the family: the first spindle
    assert mill("G116 T3")[0].split() == ["T3", "M6"]
    assert lathe("G141")[0].strip() == "G14"  # the second, which the moves carry


def lathe_ends(text: str) -> list[tuple[float, float]]:
    """X (radius) and Z of the ends of a lathe program."""
    return [(m.end[0], m.end[2]) for m in interpret(text, "okuma", Setup(strict=False)).moves]


def test_corners_of_a_lathe_are_no_grooves():
    """G75 G1 X20 L-2: the corner (10, 0) is cut, 2 mm before it and 2 mm behind; G76 rounds. G75 grooved, in silence, and G76 asked for a thread."""
    made = lathe_ends("G0 X40 Z0\nG95 F0.2\nG75 G1 X20 L-2\nG1 Z-20\nM2\n")
    assert made == [(20, 0), (12, 0), (10, -2), (10, -20)]
    made = lathe_ends("G0 X20 Z0\nG95 F0.2\nN10G76G1Z-10L2\nG1 X40\nM2\n")
    assert made == [(10, 0), (10, -8), (12, -10), (20, -10)]


def test_g33_of_a_lathe_is_a_whole_pass():
    """OSP-P200L, "fixed thread cutting cycle": down to X29, along, out, back; the lead is F/J = 3/2: 500 x 1.5 = 750 mm/min."""
    made = interpret(
        "G0 X40 Z5\nG97 S500 M3\nG33 X29 Z-20 F3 J2\nX28\nM2\n", "okuma", Setup(strict=False)
    ).moves
    one = [(14.5, 5), (14.5, -20), (20, -20), (20, 5)]
    assert [(m.end[0], m.end[2]) for m in made[1:]] == [
        *one,
        *((x - 0.5 if x < 20 else x, z) for x, z in one),
    ]
    assert [m.feed for m in made if m.kind == "thread"] == [750, 750]


@pytest.mark.parametrize("code", ["G32", "G35", "G73", "G77", "G78", "G88"])
def test_cycles_of_a_lathe_that_mean_something_else_are_holes(code: str):
    text = f"G0 X40 Z5\nN2{code} X29 Z-20 F3\nM2\n"
    assert lathe_ends(text) == [(20, 5)]
    with pytest.raises(DataError, match=code):
        interpret(text, "okuma", Setup(strict=True))


@pytest.mark.parametrize("code", ["G54", "G98", "G52", "G12.1"])
def test_codes_that_an_osp_control_has_not_are_told(code: str):
    """G54 of an OSP mill is the length of the tool along X, not a work offset; G98 and G52 it has not."""
    text = f"G90 G15 H1\nG0 X0 Y0\n{code} G0 X10 Y5\nM2\n"
    assert any(a.what.startswith(code) for a in interpret(text, "okuma", Setup(strict=False)).assumed)
    with pytest.raises(DataError, match=code):
        interpret(text, "okuma", Setup(strict=True))
