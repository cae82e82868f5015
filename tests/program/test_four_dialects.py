"""One part in four languages gives the same moves: contour with arcs, inside corner, compensation, work offset, tool length.

All joints are tangential or inside corners, and the lead-in runs along the first element, so that the controls' own ways
at outside corners and at the entry do not matter.
"""

from __future__ import annotations

import numpy as np
import pytest

from vcmm.program.interpret import interpret
from vcmm.program.setup import Setup, Tool

SETUP = Setup(offsets={"G54": (200.0, 100.0, -300.0)}, tools={3: Tool(3, length=75.0, diameter=8.0)})

G_CODE = """{start}
N10 G17 G21 G90 G94 G40
N20 T3 M6
N30 S3000 M3
N40 G54 {length}G0 X-30. Y0.
N50 G0 Z5.
N60 G1 Z-3. F150.
N70 G41 {register}X-10. Y0. F400.
N80 X40.
N90 G3 X50. Y10. I0. J10.
N100 G1 Y40.
N110 X0.
N120 G3 X-10. Y30. R10.
N130 G1 Y0.
N140 Y-20.
N150 G40 Y-40.
N160 G0 Z50.
N170 M30
{end}
"""
SINUMERIK = """; the same part
N10 G17 G71 G90 G94 G40 G450
N20 T3 M6
N30 S3000 M3
N40 G54 G0 X-30 Y0
N50 Z5
N60 G1 Z-3 F150
N70 G41 X-10 Y0 F400
N80 X40
N90 G3 X50 Y10 CR=10
N100 G1 Y=IC(30)
DEF REAL left_x=0
N110 X=left_x
N120 G3 X-10 Y30 I0 J-10
N130 G1 Y0
N140 Y-20
N150 G40 Y-40
N160 G0 Z50
N170 M30
"""
KLARTEXT = """0 BEGIN PGM PART MM
1 BLK FORM 0.1 Z X-10 Y+0 Z-20
2 BLK FORM 0.2 X+50 Y+40 Z+0
3 TOOL CALL 3 Z S3000
4 L X-30 Y+0 R0 FMAX M3
5 L Z+5 FMAX
6 L Z-3 F150
7 L X-10 Y+0 RL F400
8 L X+40
9 CC X+40 Y+10
10 C X+50 Y+10 DR+
11 L IY+30
12 Q1 = 5 - 5
13 L X+Q1
14 CR X-10 Y+30 R+10 DR+
15 L Y+0
16 L Y-20
17 L Y-40 R0
18 L Z+50 FMAX M30
19 END PGM PART MM
"""
PROGRAMS = {
    "linuxcnc": G_CODE.format(start="%", end="%", length="G43 H3 ", register=""),
    "fanuc": G_CODE.format(start="%\nO0001", end="%", length="G43 H3 ", register="D3 "),
    "sinumerik": SINUMERIK,
    "heidenhain": KLARTEXT,
}
# By hand, work coordinates: tool radius 4 on the left; arcs R 10 become R 6; the corner (50, 40) is an inside one.
EXPECTED = [
    ("rapid", (-30, 0)), ("rapid", None), ("line", None), ("line", (-10, 4)), ("line", (40, 4)), ("arc", (46, 10)),
    ("line", (46, 36)), ("line", (0, 36)), ("arc", (-6, 30)), ("line", (-6, 0)), ("line", (-6, -20)), ("line", (-10, -40)),
    ("rapid", None),
]  # fmt: skip


def summary(name):
    program = interpret(PROGRAMS[name], name, SETUP)
    assert program.dialect == name
    return [
        (
            m.kind, np.round(m.start, 9).tolist(), np.round(m.end, 9).tolist(),
            None if m.centre is None else np.round(m.centre, 9).tolist(), m.clockwise, m.turns, m.feed, m.spindle, m.tool,
            tuple(m.tool_offset), m.compensation, m.offset, m.plane,
        )
        for m in program.moves
        if m.start != m.end
    ]  # fmt: skip


def trimmed(moves):
    """Without the first way down: the dialects differ in whether the tool length moves the axis at once."""
    return moves[2:]


@pytest.mark.parametrize("name", PROGRAMS)
def test_expected_by_hand(name):
    moves = summary(name)
    assert [m[0] for m in moves] == [kind for kind, _ in EXPECTED]
    for move, (_, point) in zip(moves, EXPECTED):
        if point is not None:
            assert np.allclose(move[2][:2], (200 + point[0], 100 + point[1]), atol=1e-9)
    assert {m[2][2] for m in moves[2:-1]} == {-303.0}
    assert {m[9] for m in moves[1:]} == {(0.0, 0.0, 75.0)}
    assert [m[10] for m in moves] == [None] * 3 + ["left"] * 8 + [None] * 2


@pytest.mark.parametrize("name", [n for n in PROGRAMS if n != "linuxcnc"])
def test_all_dialects_say_the_same(name):
    assert trimmed(summary(name)) == trimmed(summary("linuxcnc"))
