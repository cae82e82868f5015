"""M functions: what changes the path, and what is named."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from tests.program.heidenhain.klartext import SETUP, check, moves
from vcmm.core.errors import DataError
from vcmm.program.heidenhain.reader import read
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool

SURVEY = replace(SETUP, strict=False, reference=(0.0, 0.0, 400.0))


def told(text: str) -> list[str]:
    return [a.what for a in read(f"BEGIN PGM T MM\n{text}\nEND PGM T MM", "t.h", SURVEY).assumed]


def test_the_shorter_way_round():
    """M126: from 350 to 10 deg over 360; M127: back over 180."""
    made = moves("L C+350 FMAX\nL C+10 FMAX M126\nL C+350 FMAX M127", setup=SURVEY)
    assert [round(math.degrees(m.rotary_end[2])) for m in made] == [350, 370, 350]


def test_feed_per_turn():
    """M136: mm per turn; M137: per minute."""
    made = moves("TOOL CALL 5 Z S1000\nL X+1 F0.2 M3 M136\nL X+2\nL X+3 F500 M137", setup=SURVEY)
    assert [m.feed for m in made] == [200, 200, 500]
    teeth = replace(SURVEY, tools={5: replace(SETUP.tools[5], teeth=4)})
    assert moves("TOOL CALL 5 Z S1000\nL X+1 FZ0.05 M3", setup=teeth)[0].feed == 200


def test_back_along_the_tool():
    """M140 MB 50: 50 mm up; MB MAX: to the end of travel, taken at the reference point."""
    check(
        "L X+1 Z+10 FMAX\nL M140 MB 50 F750\nL M140 MB MAX", (1, 0, 10), (1, 0, 60), (1, 0, 400), setup=SURVEY
    )


def test_machine_coordinates_of_all_axes():
    """M91: rotary axes too; increments count from the last M91 position."""
    made = moves("L X+5 FMAX\nL C+90 X+100 FMAX M91\nL IX+10 FMAX M91", setup=SURVEY)
    assert [m.end[0] for m in made] == [5, 100, 110]
    assert math.degrees(made[-1].rotary_end[2]) == 90


def test_named_once_each_and_refused_in_strict_reading():
    assert told("L X+1 FMAX M116\nL X+2 FMAX M120 LA5\nL X+3 FMAX M116") == [
        "M116 (feed of rotary axes in mm/min)", "M120 (contour looked ahead)",
    ]  # fmt: skip
    assert told("L X+1 Y+2 W-5 FMAX") == ["the axis W"]
    assert "M128" in told("FUNCTION TCPM F TCP AXIS POS PATHCTRL AXIS\nL A+10 FMAX\nFUNCTION RESET TCPM")[0]
    with pytest.raises(DataError, match="M97 is not understood"):
        moves("L X+1 FMAX M97")


def test_m143_deletes_the_basic_rotation():
    """90 degrees in the set-up: X10 lies at (0, 10); behind M143 it lies at (10, 0). It was passed over in silence."""
    setup = Setup(
        strict=True,
        offsets={"G54": (0.0, 0.0, 0.0)},
        rotations={"G54": math.pi / 2},
        tools={5: Tool(5, 0.0, 10.0)},
    )
    text = "BEGIN PGM A MM\nTOOL CALL 5 Z S100\nL X+10 Y+0 R0 F100\nM143\nL X+10 Y+0\nEND PGM A MM\n"
    ends = [tuple(round(v, 9) for v in m.end[:2]) for m in interpret(text, "heidenhain", setup).moves]
    assert ends == [(0, 10), (10, 0)]


def test_m94_and_m138_name_axes_without_numbers():
    text = "BEGIN PGM A MM\nTOOL CALL 5 Z S100\nL X+10 R0 F100\nM94 C\nM138 A C\nL X+20 M94\nEND PGM A MM\n"
    made = interpret(text, "heidenhain", Setup(strict=False, tools={5: Tool(5, 0.0, 10.0)}))
    assert [m.end[0] for m in made.moves] == [10, 20]
    assert {a.what.split()[0] for a in made.assumed} >= {"M94", "M138"}
