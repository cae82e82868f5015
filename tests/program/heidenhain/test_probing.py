"""TCH PROBE 0, by hand, and what the cycles have in common."""

from __future__ import annotations

import pytest

from vcmm.core.errors import DataError
from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool
from vcmm.program.touching import box_faces

BOX = box_faces((50.0, 20.0, -230.0), (100.0, 60.0, 30.0))
TOOLS = {9: Tool(9, length=120.0, diameter=6.0, shape="probe")}
SETUP = Setup(offsets={"G54": (100.0, 50.0, -200.0)}, tools=TOOLS, surfaces=BOX)


def program(*lines: str) -> str:
    return "\n".join(["BEGIN PGM P MM", "TOOL CALL 9 Z S10", "L Z+50 FMAX", *lines, "END PGM P MM"])


def test_a_coordinate_goes_into_its_parameter():
    # expected at X-49, the face lies at -50: from -49 - 2 - 3 = -54 the ball stops at -53, Q5 = -50
    text = program(
        "TCH PROBE 0.0 REF. PLANE Q5 X+", "TCH PROBE 0.1 X-49 Y+0 Z-5", "L X+Q5 FMAX", "L X+Q115 FMAX"
    )
    found = interpret(text, "heidenhain", SETUP)
    assert found.touches[0].tip == (47.0, 50.0, -205.0)
    ends = [m.end[0] for m in found.moves]
    assert ends[-5:] == [46.0, 47.0, 46.0, 50.0, 47.0]


def test_a_datum_in_one_axis():
    # the top found at Z0 is to read +2: the zero goes 2 mm down
    text = program(
        "TCH PROBE 419 DATUM IN ONE AXIS ~\n Q263=+0 ~\n Q264=+0 ~\n Q261=+0 ~\n Q320=+0 ~\n Q260=+20 ~\n Q272=+3 ~\n Q267=-1 ~\n Q305=+0 ~\n Q333=+2 ~\n Q303=-1",
        "L Z+2 FMAX",
    )
    found = interpret(text, "heidenhain", SETUP)
    assert found.touches[0].tip == (100.0, 50.0, -200.0)
    assert found.moves[-1].end[2] == pytest.approx(-200.0)


def test_words_out_of_range_are_said():
    cycle = "TCH PROBE 419 DATUM ~\n Q263=+0 ~\n Q264=+0 ~\n Q261=+0 ~\n Q272={} ~\n Q267={} ~\n Q305={}"
    with pytest.raises(DataError, match=r"Q272 = 4 must be 1, 2 or 3"):
        interpret(program(cycle.format(4, -1, 0)), "heidenhain", SETUP)
    with pytest.raises(DataError, match=r"Q267 = 0 must be -1 or \+1"):
        interpret(program(cycle.format(3, 0, 0)), "heidenhain", SETUP)
    with pytest.raises(DataError, match=r"writes preset 7 \(Q305\)"):
        interpret(program(cycle.format(3, -1, 7)), "heidenhain", SETUP)


def test_what_is_missing_is_said():
    with pytest.raises(DataError, match="419 needs Q264"):
        interpret(program("TCH PROBE 419 DATUM IN ONE AXIS ~\n Q263=+0 ~\n Q272=1"), "heidenhain", SETUP)
    with pytest.raises(DataError, match=r"as in TCH PROBE 0\.0"):
        interpret(program("TCH PROBE 0.0 REF. PLANE Q5"), "heidenhain", SETUP)
    with pytest.raises(
        DataError, match=r"TCH PROBE 405 \(it turns the C axis\) is not understood; known are 0, 400, 401"
    ):
        interpret(program("TCH PROBE 405 ROT IN C-AXIS"), "heidenhain", SETUP)


def test_another_preset_keeps_its_other_axes_and_feeds_are_per_minute():
    both = Setup(offsets={**SETUP.offsets, "G55": (10.0, 20.0, 30.0)}, tools=TOOLS, surfaces=BOX)
    text = program(
        "M136",
        "TCH PROBE 419 DATUM ~\n Q263=-49 ~\n Q264=+0 ~\n Q261=-5 ~\n Q272=1 ~\n Q267=1 ~\n Q305=2 ~\n Q333=0",
        "CYCL DEF 247 DATUM ~\n Q339=2",
        "L X+0 Y+0 Z+0 FMAX",
    )
    found = interpret(text, "heidenhain", both)
    assert found.moves[-1].end == pytest.approx((50.0, 20.0, 30.0))
    assert {m.feed for m in found.moves if m.kind == "line"} == {2000.0}
