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
