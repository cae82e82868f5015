"""Okuma lines in the words of the G-code family."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.okuma.lines import OkumaLines
from vcmm.program.setup import Setup


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
