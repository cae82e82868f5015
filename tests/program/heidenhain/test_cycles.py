"""CYCL DEF: frames, dwell, tolerance, drilling."""

from __future__ import annotations

import math

from tests.program.heidenhain.klartext import check, moves

S = math.sqrt(0.5)


def test_datum_shift_rotation_mirror_scale():
    shift = "CYCL DEF 7.0 DATUM SHIFT\nCYCL DEF 7.1 X+100\nCYCL DEF 7.2 IY+20\n"
    check(
        shift + "L X+1 Y+2 FMAX\nCYCL DEF 7.0\nCYCL DEF 7.1 X+0\nCYCL DEF 7.2 Y+0\nL X+3 FMAX",
        (101, 22, 0),
        (3, 22, 0),
    )
    turned = (
        shift
        + "CYCL DEF 10.0 ROTATION\nCYCL DEF 10.1 ROT+90\nL X+10 Y+0 FMAX\nCYCL DEF 10.1 IROT-45\nL X+10 Y+0 FMAX"
    )
    check(turned, (100, 30, 0), (100 + 10 * S, 20 + 10 * S, 0))
    check(
        "CYCL DEF 8.0\nCYCL DEF 8.1 X\nL X+5 Y+1 FMAX\nCYCL DEF 8.0\nCYCL DEF 8.1\nL X+5 FMAX",
        (-5, 1, 0),
        (5, 1, 0),
    )
    check("CYCL DEF 11.0\nCYCL DEF 11.1 SCL 0.5\nL X+5 FMAX", (2.5, 0, 0))
    check("CYCL DEF 247 DATUM SETTING ~\n Q339=+2 ;DATUM NUMBER\nL X+1 Y+0 Z+0 FMAX", (101, 50, -10))


def test_dwell_and_tolerance():
    got = moves(
        "CYCL DEF 9.0 DWELL TIME\nCYCL DEF 9.1 DWELL 1.5\nCYCL DEF 32.0 TOLERANCE\nCYCL DEF 32.1 T0.05\nL X+1 FMAX"
    )
    assert got[0].seconds == 1.5
    assert got[1].tolerance == 0.05


DRILL = (
    "CYCL DEF 200 DRILLING ~\n Q200=2 ;SET-UP ~\n Q201=-15 ;DEPTH ~\n Q206=250 ;FEED ~\n Q202=10 ;PECK ~\n"
    " Q210=0 ;TOP ~\n Q203=+0 ;SURFACE ~\n Q204=20 ;2ND ~\n Q211=0.5 ;BOTTOM\n"
)


def test_drilling():
    # surface 0: clearance 2, to -10, out, back to 2 above, to -15, dwell, out to the second clearance 20
    got = moves(f"{DRILL}L X+30 Y+50 Z+50 FMAX M99\nL X+40 FMAX")
    assert [m.end[2] for m in got] == [50, 2, -10, 2, -8, -15, -15, 20, 20]
    assert [m.kind for m in got][:4] == ["rapid", "rapid", "line", "rapid"]
    assert {m.feed for m in got} == {None, 250}
    assert len(moves(f"{DRILL}L X+30 Z+50 FMAX\nCYCL CALL")) == 8
    # TNC 640, "Calling a cycle": "program the first cycle call with M89", after every positioning block until M99
    assert len(moves(f"{DRILL}L X+30 Z+50 FMAX M89\nL X+40 FMAX\nL X+50 FMAX M99\nL X+60 FMAX")) == 4 + 3 * 7
    assert (
        len(moves(f"{DRILL}L X+30 Z+50 FMAX M89\n{DRILL}L X+40 FMAX\nL X+50 FMAX")) == 3 + 7
    )  # a new cycle ends it
    assert len(moves(f"{DRILL}L X+30 Z+50 FMAX M89\nCYCL CALL\nL X+50 FMAX")) == 2 + 2 * 7
    assert len(moves(f"{DRILL}L X+30 Z+50 FMAX\nM89\nL X+40 FMAX\nL X+50 FMAX M99")) == 3 + 2 * 7
