"""Klartext programs, each worked out by hand (HEIDENHAIN iTNC 530 and TNC 640, conversational programming and cycle manuals)."""

from __future__ import annotations

import pytest

from tests.program.pencil import check

PROGRAMS = {
    "lines, increments, both ways to write an arc": (
        "L X+10 Y+0 R0 FMAX\nL Z-2 F100\nCC X+0 Y+0\nC X+0 Y+10 DR+\nCR X-10 Y+20 R+10 DR-\nL IX-5 IY+2",
        "R 10 0 0; L . . -2; A 0 10 . (0 0 +); A -10 20 . (0 20 -); L -15 22 .",
    ),
    "CR with a negative radius takes the long way": (
        "L X+10 Y+0 FMAX\nCR X+0 Y+10 R-10 DR+ F100",
        "R 10 0 0; A 0 10 . (10 10 +)",
    ),
    "CT goes on along the tangent": ("L X+10 Y+0 F100\nCT X+20 Y+10", "L 10 0 0; A 20 10 . (10 10 +)"),
    "polar: line, arc, and a helix of one turn": (
        "CC X+10 Y+10\nLP PR+10 PA+0 FMAX\nLP PA+90 F100\nCP PA+180 DR+\nCP IPA+360 IZ-3 DR+",
        "R 20 10 0; L 10 20 .; A 0 10 . (10 10 +); A 0 10 -3 (10 10 +)",
    ),
    "RND and CHF between two lines": (
        "L X+20 Y+0 F100\nRND R5\nL Y+20\nCHF 3\nL X+0",
        "L 15 0 0; A 20 5 . (15 5 +); L . 17 .; L 17 20 .; L 0 . .",
    ),
    "a part of the program three times in all": (
        "LBL 1\nL IX+5 F100\nL IY+1\nLBL 0\nCALL LBL 1 REP 2",
        "L 5 0 0; L . 1 .; L 10 . .; L . 2 .; L 15 . .; L . 3 .",
    ),
    "a subprogram behind M30": ("CALL LBL 5\nL X+9 FMAX\nM30\nLBL 5\nL IX+2 F100\nLBL 0", "L 2 0 0; R 9 0 0"),
    "Q parameters count a loop": (
        "FN 0: Q1 = +0\nLBL 2\nQ1 = Q1 + 1\nL X+Q1 F100\nFN 12: IF +Q1 LT +3 GOTO LBL 2",
        "L 1 0 0; L 2 . .; L 3 . .",
    ),
    "cycle 200 in two pecks, from 50 down to the second clearance": (
        "L Z+50 FMAX\nCYCL DEF 200 BOHREN ~\nQ200=2 ~\nQ201=-8 ~\nQ206=100 ~\nQ202=5 ~\nQ210=0 ~\nQ203=+0 ~\nQ204=20 ~\nQ211=0\nL X+10 Y+0 FMAX M99",
        "R 0 0 50; R 10 . .; R . . 2; L . . -5; R . . 2; R . . -3; L . . -8; R . . 20",
    ),
    "datum shift, and back; FMAX holds in its block alone": (
        "CYCL DEF 7.0 NULLPUNKT\nCYCL DEF 7.1 X+10\nCYCL DEF 7.2 IY+5\nL X+1 Y+1 FMAX\nCYCL DEF 7.0 NULLPUNKT\nCYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y+0\nL X+0 Y+0",
        "R 11 6 0; L 0 0 .",
    ),
    "rotation by 90 degrees, mirror, scale": (
        "CYCL DEF 10.0 DREHUNG\nCYCL DEF 10.1 ROT+90\nL X+10 Y+0 FMAX\nCYCL DEF 10.0 DREHUNG\nCYCL DEF 10.1 ROT+0\nCYCL DEF 8.0 SPIEGELN\nCYCL DEF 8.1 X\n"
        "L X+5 Y+0\nCR X+0 Y+5 R+5 DR+ F100\nCYCL DEF 8.0 SPIEGELN\nCYCL DEF 8.1\nCYCL DEF 11.0 MASSFAKTOR\nCYCL DEF 11.1 SCL 2\nL X+3 Y+4",
        "R 0 10 0; L -5 0 0; A 0 5 . (0 0 -); L 6 8 .",
    ),
    "cycle 220: four holes on a circle of diameter 20 about (50, 0)": (
        "L Z+10 FMAX\nCYCL DEF 200 BOHREN Q200=1 Q201=-2 Q206=100 Q202=2 Q210=0 Q203=0 Q204=10 Q211=0\n"
        "CYCL DEF 220 MUSTER KREIS Q216=50 Q217=0 Q244=20 Q245=0 Q246=360 Q247=0 Q241=4 Q200=1 Q203=0 Q204=10 Q301=1",
        "R 0 0 10; R 60 . .; R . . 1; L . . -2; R . . 10; R 50 10 .; R . . 1; L . . -2; R . . 10; R 40 0 .; R . . 1; L . . -2; R . . 10; "
        "R 50 -10 .; R . . 1; L . . -2; R . . 10",
    ),
    "CYCL CALL PAT over two points": (
        "L Z+10 FMAX\nCYCL DEF 200 BOHREN Q200=1 Q201=-2 Q206=100 Q202=2 Q210=0 Q203=0 Q204=10 Q211=0\n"
        "PATTERN DEF POS1 (X+5 Y+5 Z+0) POS2 (X+9 Y+5 Z+0)\nCYCL CALL PAT FMAX",
        "R 0 0 10; R 5 5 .; R . . 1; L . . -2; R . . 10; R 9 . .; R . . 1; L . . -2; R . . 10",
    ),
    "APPR LT and DEP LT along the tangent": (
        "TOOL CALL 1 Z S1000\nL X-40 Y-20 R0 FMAX\nAPPR LT X-10 Y+0 LEN20 RR F100\nL X+30\nDEP LT LEN15",
        "R -40 -20 0; R -30 -5 .; L -10 . .; L 30 . .; L 45 . .",
    ),
    "machine coordinates with M91": ("L X+100 Y+50 Z+10 FMAX\nL Z+0 FMAX M91", "R 100 50 10; R . . 0"),
}


@pytest.mark.parametrize("name", PROGRAMS)
def test_a_program_means_what_was_worked_out_by_hand(name: str):
    text, path = PROGRAMS[name]
    check("heidenhain", f"BEGIN PGM HAND MM\n{text}\nEND PGM HAND MM\n", path)
