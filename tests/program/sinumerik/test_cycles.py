"""CYCLE81 to CYCLE83 and CYCLE832, move by move."""

from __future__ import annotations

import pytest

from tests.program.sinumerik.programs import SURVEY, check, moves, told
from vcmm.core.errors import DataError


def test_drilling_cycles():
    check("G0 Z50\nF100\nCYCLE81(10,0,2,-15)", (0, 0, 50), (0, 0, 2), (0, 0, -15), (0, 0, 10))
    modal = moves("G0 Z10 F100\nMCALL CYCLE82(10,0,2,,8,0.5)\nX5\nX7\nMCALL\nX9")
    assert [m.kind for m in modal] == ["rapid", *["rapid", "rapid", "line", "dwell", "rapid"] * 2, "rapid"]
    assert [m.end[2] for m in modal[2:4]] == [2, -8]
    # CYCLE83 to -20: first 8, then 8 - 3 = 5 (to -13), then 3 (DAM is the least; to -16), the last 4 halved: -18, -20
    deep = moves("G0 Z10 F100\nCYCLE83(10,0,2,-20,,-8,,3,0,0,0.5,1)")
    assert [m.end[2] for m in deep if m.kind == "line"] == [-8, -13, -16, -18, -20]
    assert [m.feed for m in deep if m.kind == "line"] == [50, 100, 100, 100, 100]


def test_planes_of_a_cycle_are_inches_after_G70():
    """RFP + SDIS = (0.1 + 0.05) in = 3.81 mm, depth -0.5 in = -12.7 mm, RTP 1 in = 25.4 mm; by DPR from RFP: 2.54 - 12.7 = -10.16."""
    ends = [m.end[2] for m in moves("G70\nG0 Z2\nF10\nCYCLE81(1,0.1,0.05,-0.5)\nCYCLE81(1,0.1,0.05,,0.5)")]
    assert ends == pytest.approx([50.8, 3.81, -12.7, 25.4, 3.81, -10.16, 25.4], abs=1e-9)


def strokes(text: str) -> list[tuple[str, float, float | None]]:
    made = moves(f"G0 X5 Y6 Z50\nM3 S1000 F100\n{text}", SURVEY)[1:]
    return [(m.kind[0], m.end[2], m.seconds if m.kind == "dwell" else m.feed) for m in made]


def test_the_relative_depth_holds_where_both_are_given():
    """Manual: "if a value is entered both for DP and for DPR, the final drilling depth is derived from DPR"."""
    assert [h for _, h, _ in strokes("CYCLE82(2,0,2,0,30,0)")] == [2, -30, 2]


def test_tapping():
    """84: pitch 1.5 x 400 in, x 500 out; MPIT 10 is 1.5 mm; DAM 6 breaks chips by 1 mm. 840: with the speed in force."""
    assert strokes("CYCLE84(10,0,2,-9,,,3,,1.5,,400,500)") == [
        ("r", 2, None),
        ("l", -9, 600),
        ("l", 2, 750),
        ("r", 10, None),
    ]
    assert [f for *_, f in strokes("CYCLE84(10,0,2,-9,,,3,10,,,400)")][1:3] == [600, 600]
    broken = strokes("CYCLE84(10,0,2,-10,,,3,,1,,400,,,,,,6)")
    assert [h for _, h, _ in broken] == [2, -6, -5, -10, 2, 10]
    assert strokes("CYCLE840(10,0,2,-9,,,4,3,1,,1.25)")[1:3] == [("l", -9, 1250), ("l", 2, 1250)]


def test_reaming_and_boring():
    assert strokes("CYCLE85(10,0,2,-9,,0.5,80,240)") == [
        ("r", 2, None), ("l", -9, 80), ("d", -9, 0.5), ("l", 2, 240), ("r", 10, None),
    ]  # fmt: skip
    assert [h for _, h, _ in strokes("CYCLE87(10,0,2,-9,,3)")] == [2, -9, 10]
    assert [h for _, h, _ in strokes("CYCLE89(10,0,2,-9)")] == [2, -9, 2, 10]
    off = [m.end for m in moves("G0 X5 Y6 Z50\nM3 S9 F100\nCYCLE86(10,0,2,-9,,,3,-0.5,0.25,1)", SURVEY)][1:]
    assert off == [
        (5, 6, 2),
        (5, 6, -9),
        (4.5, 6.25, -9),
        (4.5, 6.25, -8),
        (4.5, 6.25, 2),
        (5, 6, 2),
        (5, 6, 10),
    ]


def test_swivelled_planes():
    """CYCLE800 with A = 90 about X: Y lies along Z; mode 57 turns about X, Y, Z; without arguments it ends."""
    text = 'CYCLE800(0,"TC",0,57,10,0,0,90,0,0,0,2,0,1)\nG0 X1 Y3 Z0\nCYCLE800()\nG0 X1 Y0 Z0'
    check(text, (11, 0, 5), (1, 0, 0), setup=SURVEY)
    order = 'CYCLE800(0,"TC",0,27,0,0,0,90,0,0,0,0,0,1)\nG0 X1'  # 27 = 0b011011: A is about Z
    check(order, (0, 1, 0), setup=SURVEY)
    twice = 'CYCLE800(0,"TC",0,57,0,0,0,90,0,0)\nTRANS X5\nCYCLE800(0,"TC",1,57,0,0,0,-90,0,0)\nG0 X1 Y2'
    check(twice, (6, 2, 0), setup=SURVEY)
    tilted = moves('CYCLE800(0,"TC",0,57,10,0,0,90,0,0)\nG0 X1')[-1]
    assert tilted.is_tip_led
    assert tilted.tool_axis_end == pytest.approx((0.0, -1.0, 0.0), abs=1e-12)
    assert told("CYCLE800()") == {}


def test_the_axis_of_a_hole_is_the_one_that_AXN_names():
    """AXN 1 in G17 is X, in G18 (axes Z and X) Z; 3, 0 and nothing: square to the plane. They were drilled square to it, whatever AXN said."""
    ends = [m.end for m in moves("G0 X20 Y5 Z6 F100\nCYCLE83(20,10,2,0,,5,,,,,,,1)")][1:]
    assert ends[0] == (12, 5, 6)
    assert ends[-2:] == [(0, 5, 6), (20, 5, 6)]
    ends = [m.end for m in moves("G18\nG0 X20 Y5 Z16 F100 S1000\nCYCLE840(10,0,2,-8,,0,4,3,0,,1,1)")][1:4]
    assert ends == [(20, 5, 2), (20, 5, -8), (20, 5, 2)]
    assert [h for _, h, _ in strokes("CYCLE84(10,0,2,-9,,,3,,1,,,,3)")] == [2, -9, 2, 10]
    with pytest.raises(
        DataError, match=r"CYCLE84: AXN is 1, 2 or 3, an axis of the plane, and not 4; correct it"
    ):
        moves("S1000 F100\nCYCLE84(10,0,2,-9,,,3,,1,,,,4)")


def test_deep_drilling_as_its_last_parameters_say():
    """VRT 2: back by 2 mm to break chips; DTD 3: seconds at the last depth; DIS1 1.5: as far before the depth on the way back. DAM -0.5 with
    MDEP 2 from 8 mm: 8, 4, 2, 2, 2, 2 to -20."""
    broken = strokes("CYCLE83(10,0,2,-20,,-8,,,1,,,0,3,,2,3)")
    assert [h for kind, h, _ in broken if kind == "l"] == [-8, -6, -14, -12, -20]
    assert [s for kind, _, s in broken if kind == "d"] == [1, 1, 3]
    out = strokes("CYCLE83(10,0,2,-20,,-8,,,,,,1,3,,,,1.5)")
    assert [h for kind, h, _ in out if kind == "r"] == [2, 2, -6.5, 2, -12.5, 10]
    shared = strokes("CYCLE83(10,0,2,-20,,-8,,-0.5,,,,1,3,2)")
    assert [h for kind, h, _ in shared if kind == "l"] == [-8, -12, -14, -16, -18, -20]
    with pytest.raises(DataError, match="add MDEP"):
        strokes("CYCLE83(10,0,2,-20,,-8,,-0.5,,,,1)")


def test_tapping_without_encoder_and_without_a_pitch_goes_at_the_feed_in_force():
    assert strokes("CYCLE840(10,0,2,-9,,,4,3,1)")[1:3] == [("l", -9, 100), ("l", 2, 100)]


def test_arguments_that_no_table_knows_are_told():
    """POCKET4 knows 19 arguments; what stands behind them is told."""
    program = told("F100\nT1 D1\nPOCKET4(10,0,2,-4,20,0,0,4,0,0,300,100,2,21,0,0,0,3,2,7)")
    assert "arguments of POCKET4 behind number 19 (7)" in str(program)
