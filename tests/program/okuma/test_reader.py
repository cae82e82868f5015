"""Okuma programs: moves, by hand."""

from __future__ import annotations

from pathlib import Path

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.okuma.names import OkumaNames, is_system
from vcmm.program.okuma.reader import is_turning, read
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
