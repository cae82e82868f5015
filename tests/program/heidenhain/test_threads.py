"""Cycle 262, by the rules of the manual."""

from __future__ import annotations

import pytest

from tests.program.pencil import SETUP, check
from vcmm.program.interpret import interpret

CYCLE = (
    "BEGIN PGM T MM\nTOOL CALL 1 Z S1000\nL Z+50 FMAX\nCYCL DEF 262 Q335=20 Q239={pitch} Q201=-6 Q355={steps} Q253=750 Q351={way} Q200=2 Q203=0 Q204=20 Q207=200\n"
    "L X+30 Y+0 FMAX M99\nEND PGM T MM\n"
)


def test_a_right_hand_thread_in_climb_rises_one_turn_from_its_depth():
    """Tool 10 mm in a thread of 20: the centre runs on 5 mm, counter-clockwise, from -6 to -4.5."""
    check(
        "heidenhain",
        CYCLE.format(pitch="+1.5", steps=0, way="+1"),
        "R 0 0 50; R 30 . .; R . . 2; L . . -6; A 35 0 . (32.5 0 +); A 35 0 -4.5 (30 0 +); A 30 0 . (32.5 0 +); R . . 20",
    )


@pytest.mark.parametrize(
    ("pitch", "way", "clockwise", "heights"),
    [("+1.5", "-1", True, (-4.5, -6)), ("-1.5", "+1", False, (-4.5, -6)), ("-1.5", "-1", True, (-6, -4.5))],
)
def test_hand_and_sense_decide_which_way_the_helix_goes(
    pitch: str, way: str, clockwise: bool, heights: tuple[float, float]
):
    moves = interpret(CYCLE.format(pitch=pitch, steps=0, way=way), "heidenhain", SETUP).moves
    helix = next(m for m in moves if m.kind == "arc" and m.start[2] != m.end[2])
    assert (helix.clockwise, helix.start[2], helix.end[2]) == (clockwise, *heights)


def test_one_helix_along_the_thread_and_several_apart():
    """6 mm deep, pitch 1.5: four turns in one; with Q355 = 2 two helices 3 mm apart."""
    whole = [
        m
        for m in interpret(CYCLE.format(pitch="+1.5", steps=1, way="+1"), "heidenhain", SETUP).moves
        if m.turns > 1
    ]
    assert [(m.turns, m.start[2], m.end[2]) for m in whole] == [(4, -6, 0)]
    several = [
        m
        for m in interpret(CYCLE.format(pitch="+1.5", steps=2, way="+1"), "heidenhain", SETUP).moves
        if m.kind == "arc"
    ]
    assert [(m.start[2], m.end[2]) for m in several if m.start[2] != m.end[2]] == [(-6, -4.5), (-3, -1.5)]


def test_what_is_assumed_is_told():
    told = interpret(CYCLE.format(pitch="+1.5", steps=0, way="+1"), "heidenhain", SETUP).assumed
    assert [(a.line, a.what) for a in told] == [(5, "how cycle 262 leads in and out")]
