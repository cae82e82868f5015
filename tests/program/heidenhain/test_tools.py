"""TOOL CALL and TOOL DEF."""

from __future__ import annotations

from tests.program.heidenhain.klartext import SETUP, moves
from vcmm.program.heidenhain.reader import read


def test_tools():
    program = read(
        'TOOL CALL "MILL_6" Z S2000 DL+0.5\nL Z+0 FMAX M3\nTOOL CALL S500\nL Z+1 FMAX', "part.h", SETUP
    )
    assert [m.tool_offset for m in program.moves] == [(0, 0, 80.5)] * 2
    assert [m.spindle for m in program.moves] == [2000, 500]
    assert program.tools == {2: "MILL_6"}
    (one,) = moves("TOOL DEF 7 L+12 R+3\nTOOL CALL 7 Z\nL Z+0 FMAX")
    assert one.tool_offset == (0, 0, 12)


def test_tool_axis():
    (one,) = moves("TOOL CALL 2 Y\nCR Z+10 X+10 R+10 DR+ F100")
    assert (one.plane, one.tool_offset, one.start) == ("ZX", (0, 80, 0), (0, -80, 0))
