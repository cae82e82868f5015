"""Q parameters: jumps on what is defined, system data, parameters that the control keeps."""

from __future__ import annotations

from dataclasses import replace

from tests.program.heidenhain.klartext import SETUP, check

SURVEY = replace(SETUP, strict=False)


def test_is_defined():
    """FN 9: IF Q5 IS UNDEFINED GOTO LBL 1."""
    text = "FN 9: IF Q5 IS UNDEFINED GOTO LBL 1\nL X+1 FMAX\nLBL 1\nQ5 = 3\nFN 9: IF Q5 IS DEFINED GOTO LBL 2\nL X+2 FMAX\nLBL 2\nL Y+Q5 FMAX"
    check(text, (0, 3, 0))


def test_parameters_that_the_control_keeps():
    """Q108 radius of the tool in the spindle, Q114 its length, Q113 inch."""
    check("TOOL CALL 2 Z\nL X+Q108 Y+Q114 Z+0 FMAX\nL X+Q113 FMAX", (3, 80, 0), (0, 80, 0))
    check("TOOL DEF 9 L+0 R+4\nTOOL CALL 9 Z\nL X+Q108 FMAX", (4, 0, 0))


def test_system_data_that_follow_from_the_program():
    check(
        "TOOL CALL 5 Z\nFN 18: SYSREAD Q1 = ID20 NR1\nFN18: SYSREAD Q2 = ID50 NR2 IDXQ1\nL X+Q1 Y+Q2 FMAX",
        (5, 5, 0),
    )


def test_what_hangs_on_the_machine_alone_is_zero():
    check("FN 18: SYSREAD Q1 = ID1000 NR1\nQ2 = 5 / Q1\nL X+Q2 Y+1 FMAX", (0, 1, 0), setup=SURVEY)
    check(
        'QS1 = "A" || "B"\nQ3 = STRLEN ( SRC_QS1 )\nL X+Q3 Y+1 FMAX', (2, 1, 0)
    )  # a text of two characters: known
