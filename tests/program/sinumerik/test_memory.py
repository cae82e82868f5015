"""Variables of all types, arrays, system variables."""

from __future__ import annotations

import pytest

from tests.program.sinumerik.programs import SURVEY, check, moves, told
from vcmm.core.errors import DataError


def test_arrays_and_texts():
    check(
        "DEF REAL _F[3,2]=SET(7,8), _G[2]\n_F[1,0]=4\n_G[1]=_F[1,0]+_F[0,0]\nG0 X=_G[1] Y=_G[0]", (11, 0, 0)
    )
    check(
        'DEF STRING[10] _S="AB"\nIF _S=="ab"\nG0 X1\nENDIF\nIF _S<<"C"=="ABC"\nG0 X2\nENDIF',
        (1, 0, 0),
        (2, 0, 0),
    )
    check('DEF STRING[9] _GOAL="END_"<<2\nGOTOF _GOAL\nG0 X1\nEND_2: G0 X2', (2, 0, 0))
    check('R1=NUMBER("2.5")+STRLEN("abc")\nG0 X=R1', (5.5, 0, 0))


def test_axes_by_name():
    """$P_AXN1 is the first axis of the plane: X with G17, Z with G18."""
    check("DEF AXIS _A,_B=Y\n_A=$P_AXN1\nG0 AX[_A]=5 AX[_B]=6", (5, 6, 0))
    check("DEF AXIS _A\nG18\n_A=$P_AXN1\nG0 AX[_A]=5", (0, 0, 5))
    check("G1 F100 X1\nPOS[X]=9 FA[X]=500", (1, 0, 0), (9, 0, 0))
    assert [m.kind for m in moves("G1 F100 X1\nPOS[X]=9")] == ["line", "rapid"]


def test_system_variables_that_follow_from_the_program():
    check("G0 X7\nG0 Y=$P_EP[X]+1", (7, 0, 0), (7, 8, 0), setup=SURVEY)
    check("G18\nIF $P_GG[6]==2\nG0 X1\nENDIF", (1, 0, 0), setup=SURVEY)


def test_work_offsets_are_set():
    """$P_UIFR[2,X,TR]=30 is the X of G55."""
    check(
        "$P_UIFR[2,X,TR]=30\n$P_UIFR[5,Z,TR]=4\nG55\nG0 X1 Y0 Z0\nG505\nG0 X0 Y0 Z0", (31, 50, -10), (0, 0, 4)
    )


def test_what_only_the_machine_knows_is_told_once():
    text = "R1=_GUD+$AN_VERSION\nIF $A_IN[3]==1\nG0 X9\nENDIF\nG0 X=R1 Y=R55\n_ZAHL=R55"
    assert told(text) == {
        "the variable _GUD, which is not the program's own": (1, "0"), "the system variable $AN_VERSION": (1, "0"),
        "the system variable $A_IN[3]": (2, "0"), "the value of R55": (5, "0"), "the variable _ZAHL, which is not the program's own": (6, "0"),
    }  # fmt: skip
    with pytest.raises(DataError, match="the variable _GUD is not defined"):
        moves(text)


def test_bad_values():
    with pytest.raises(DataError, match='"x" is no number'):
        moves('R1=NUMBER("x")')
    with pytest.raises(DataError, match="the radius of an arc is CR="):
        moves("G2 X5 Y5 R=R10 F100", SURVEY)
    with pytest.raises(DataError, match="the function CALCPOSI is not understood"):
        moves("R1=CALCPOSI(1,2)")


@pytest.mark.parametrize(
    "text",
    [
        'R1="A"*2',
        'G0 X="A"',
        'DEF STRING[3] _S="A"\nG0 X=-_S',
        'FOR R1=1 TO "B"\nENDFOR',
        'IF "A">1\nENDIF',
        'AX[""]=1 G0 X=SIN("A")',
    ],
)
def test_a_text_where_a_number_is_due_is_refused(text: str):
    with pytest.raises(DataError):
        moves(text)


def test_frames_as_values():
    """$P_UIFR[1] is G54: a shift, and a turn of 90 deg about Z inside it: X 1 lies along Y."""
    check("$P_UIFR[1]=CTRANS(X,10,Y,5):CROT(Z,90)\nG54 G0 X1 Y0", (10, 6, 0))
    check("DEF FRAME _F\n_F=CTRANS(X,7)\n$P_UIFR[2]=_F\nG55 G0 X1", (8, 0, 0))
    assert "the setting of $P_UIFR[1]" in told("$P_UIFR[1]=CROT(X,30)")
