"""Retraction along the tool, blocks behind PLANE ... STAY, TCPM, and words of tilted planes that must not be passed over."""

from __future__ import annotations

import math
from dataclasses import replace

import pytest

from tests.program.heidenhain.klartext import SETUP, check, moves
from vcmm.core.errors import DataError
from vcmm.program.heidenhain.reader import read
from vcmm.program.moves import Posture

SURVEY = replace(SETUP, strict=False)


def test_m140_retracts_in_a_block_of_its_own_and_at_rapid():
    """Manual: without F the control retracts at rapid; F is that of the block alone, so that the next line has F100 still."""
    text = "L X+1 Z+5 F100\nM140 MB 20\nL M140 MB+10\nL M140 MB 5 F750\nL Z+0"
    check(text, (1, 0, 5), (1, 0, 25), (1, 0, 35), (1, 0, 40), (1, 0, 0))
    found = moves(text)
    assert [m.kind for m in found] == ["line", "rapid", "rapid", "line", "line"]
    assert [m.feed for m in found] == [100, None, None, 750, 100]


def test_m140_mb_max_goes_to_the_reference_point_and_says_so():
    setup = replace(SETUP, reference=(0.0, 0.0, 300.0))
    program = read("BEGIN PGM T MM\nL X+1 Z+5 F100\nM140 MB MAX\nEND PGM T MM\n", "part.h", setup)
    last = program.moves[-1]
    assert (last.kind, last.end, last.rewritable) == ("rapid", (1, 0, 300), False)
    assert [(r.line, r.text) for r in program.warnings][-1] == (
        3, "M140 MB MAX (out to the end of travel): to the reference point, 300 mm",
    )  # fmt: skip


def test_m140_in_a_tilted_plane_goes_along_the_tool():
    """The plane leans by 90 deg about Y: its Z is the X of the part. How far MAX would go is not known there."""
    text = "PLANE SPATIAL SPA+0 SPB+90 SPC+0 TURN FMAX\nL X+0 Y+0 Z+5 FMAX\nL M140 MB 20"
    check(text, (5, 0, 0), (25, 0, 0))
    with pytest.raises(DataError, match="M140 along a tool that leans"):
        moves(text.replace("MB 20", "MB MAX"))
    with pytest.raises(DataError, match="M140 along a tool that leans"):
        moves("L X+0 Z+5 FMAX M128\nL B+30 F500\nL M140 MB 20")


def test_oversize_without_a_sign():
    """DL0.1 DR0. of TOOL CALL: 80.1 mm long."""
    made = moves("TOOL CALL 2 Z S1000 DL0.1 DR0.\nL Z+0 FMAX")
    assert made[-1].tool_offset == (0, 0, pytest.approx(80.1))
    assert moves("TOOL CALL 2 Z DR.25\nL X+0 Y+0 RL F100\nL X+10\nL X+20 R0")[1].end[1] == pytest.approx(3.25)


def test_a_hidden_block_may_carry_its_number():
    """/81 M30 is block 81 behind the sign that hides it: it ends the program, or is passed over with block_delete."""
    text = "L X+1 FMAX\n/81 M30\n82 L X+2 FMAX"
    assert [m.end[0] for m in moves(text)] == [1]
    assert [m.end[0] for m in moves(text, replace(SETUP, block_delete=True))] == [1, 2]
    assert [m.end[0] for m in moves("/ L X+3 FMAX\nL X+4 FMAX")] == [3, 4]


def test_a_tool_length_of_the_program_beside_one_of_the_set_up_is_told():
    text = "BEGIN PGM T MM\nTOOL DEF {} L-50 R+3\nTOOL CALL {} Z S1000\nL Z+0 FMAX\nEND PGM T MM\n"
    program = read(text.format(2, 2), "part.h", SETUP)
    said = [r for r in program.warnings if "TOOL DEF" in r.text]
    assert [(r.line, r.text) for r in said] == [
        (2, "TOOL DEF 2: the length -50 mm of the program counts, not the 80 mm of the set-up")
    ]
    assert program.moves[0].tool_offset[2] == -50


@pytest.mark.parametrize(
    ("words", "posture"),
    [
        ("SEQ-", Posture(sign=-1, words="SEQ-")), ("SYM+ COORD ROT", Posture(larger=1, words="SYM+")), ("", None),
        ("SEQ+ TABLE ROT", Posture(sign=1, words="SEQ+", along=(1.0, 0.0, 0.0))),
    ],
)  # fmt: skip
def test_the_words_of_a_plane_reach_the_moves(words, posture):
    """X of a plane that is turned about X is the X of the part."""
    made = moves(f"PLANE SPATIAL SPA+30 SPB+0 SPC+0 TURN DIST50 FMAX {words}\nL X+0 Y+0 Z+5 FMAX")
    assert made[-1].posture == posture


def test_what_is_not_understood_behind_plane_is_refused():
    with pytest.raises(DataError, match="SEW- behind PLANE is not understood; known are MOVE, TURN"):
        moves("PLANE SPATIAL SPA+30 SPB+0 SPC+0 TURN FMAX SEW-")
    with pytest.raises(DataError, match="MB of PLANE is not understood; program M140 MB"):
        moves("PLANE SPATIAL SPA+30 SPB+0 SPC+0 TURN MB MAX FMAX")
    with pytest.raises(DataError, match=r"SEQ takes \+ or -"):
        moves("PLANE SPATIAL SPA+30 SPB+0 SPC+0 TURN SEQ")


def test_stay_leaves_the_axes_until_a_block_turns_them():
    """The tip is led over the plane with the axes as they stand; A+Q120 B+Q121 C+Q122 turn the tool square to it."""
    plane = "PLANE SPATIAL SPA+0 SPB+90 SPC+0 STAY SEQ-\n"
    stays = moves(f"{plane}L X+0 Y+0 Z+5 FMAX")[-1]
    assert (stays.end, stays.is_tip_led, stays.tool_axis_end) == ((5, 0, 0), True, None)
    by_words = moves(f"{plane}L B+90 C+0 FMAX\nL X+0 Y+0 Z+5 FMAX")[-1]
    assert (by_words.tool_axis_end, by_words.rotary_end) == (None, (0, math.pi / 2, 0))
    square = moves(f"{plane}L A+Q120 B+Q121 C+Q122 FMAX\nL X+0 Y+0 Z+5 FMAX")
    assert len(square) == 1
    assert square[0].tool_axis_end == pytest.approx((1, 0, 0))
    assert square[0].posture.sign == -1
    after = moves(f"{plane}L X+0 Y+0 Z+5 FMAX\nPLANE RESET STAY\nL Z+9 FMAX")[-1]
    assert not after.is_tip_led


def test_spatial_angles_point_the_tool():
    """AXIS SPAT: A+0 B+30 C+90 is Rz(90) Ry(30) z = (0, sin 30, cos 30), whatever axes the machine has; then only B changes."""
    text = "FUNCTION TCPM F TCP AXIS SPAT PATHCTRL AXIS\nL X+0 Y+0 Z+0 A+0 B+30 C+90 F500\nL X+1 B+0 F500"
    first, second = moves(text)
    assert first.tool_axis_end == pytest.approx((0.0, 0.5, math.sqrt(0.75)))
    assert second.tool_axis_end == pytest.approx((0, 0, 1))
    assert (first.is_tip_led, first.sweeps, first.rotary_end) == (True, False, (0, 0, 0))
    with pytest.raises(DataError, match="the first block with AXIS SPAT states A, B and C"):
        moves("FUNCTION TCPM F TCP AXIS SPAT\nL X+0 B+30 F500")


@pytest.mark.parametrize("word", ["F CONT", "REFPNT CENTER-CENTER", "AXIS SOMEHOW"])
def test_words_of_tcpm_that_change_the_path_are_refused(word):
    with pytest.raises(DataError, match=r"of TCPM.* is not understood; take it out"):
        moves(f"FUNCTION TCPM {word}\nL X+0 F500")
    assert moves("FUNCTION TCPM F TCP AXIS POS PATHCTRL VECTOR\nL X+0 B+30 F500")[-1].sweeps


def test_a_rotary_axis_in_a_tilted_plane_is_refused():
    with pytest.raises(DataError, match="a rotary axis in a tilted plane"):
        moves("PLANE SPATIAL SPA+30 SPB+0 SPC+0 TURN FMAX\nL X+0 Y+0 Z+5 FMAX\nL C+40 FMAX")
