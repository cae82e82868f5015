"""APPR and DEP: auxiliary points by hand."""

from __future__ import annotations

from itertools import pairwise

import numpy as np
import pytest

from tests.program.heidenhain.klartext import check, ends, moves, sample
from vcmm.core.errors import ModelLimit
from vcmm.program.heidenhain.reader import read
from vcmm.program.setup import Setup, Tool


def test_approach_and_departure_on_lines():
    frame = "TOOL CALL 5 Z\nL X-30 Y-30 FMAX\nAPPR {} RL F100\nL Y+50\nDEP {}"
    # first element along +y from (0, 0): PH 10 before it, the tool 5 to the left; the way to it at rapid, depth at PH
    check(
        frame.format("LT X+0 Y+0 Z-2 LEN10", "LT LEN10"),
        (-30, -30, 0), (-5, -10, 0), (-5, -10, -2), (-5, 0, -2), (-5, 50, -2), (-5, 60, -2),
    )  # fmt: skip
    check(
        frame.format("LN X+0 Y+0 LEN10", "LN LEN10"),  # across: 10 + 5 away
        (-30, -30, 0), (-15, 0, 0), (-5, 0, 0), (-5, 50, 0), (-15, 50, 0),
    )  # fmt: skip
    got = moves(frame.format("LT X+0 Y+0 Z-2 LEN10", "LT LEN10"))
    assert [m.kind for m in got] == ["rapid", "rapid", "rapid", "line", "line", "line"]
    assert got[-1].compensation is None
    assert got[-2].compensation == "left"
    assert all(a.end == b.start for a, b in pairwise(got))


def test_approach_and_departure_on_arcs():
    # the centre path begins at (-5, 0); R = 8 to the left of it: centre (-13, 0). CCA 90: from (-13, -8), counterclockwise
    got = moves("TOOL CALL 5 Z\nL X-30 Y-30 FMAX\nAPPR CT X+0 Y+0 CCA90 R8 RL F100\nL Y+50\nDEP CT CCA90 R8")
    assert np.allclose(
        [m.end for m in got], [(-30, -30, 0), (-13, -8, 0), (-5, 0, 0), (-5, 50, 0), (-13, 58, 0)], atol=1e-9
    )
    assert [m.centre for m in got if m.kind == "arc"] == [(-13, 0, 0), (-13, 50, 0)]
    assert [m.clockwise for m in got if m.kind == "arc"] == [False, False]
    other = moves("TOOL CALL 5 Z\nL X-30 Y-30 FMAX\nAPPR CT X+0 Y+0 CCA90 R-8 RL F100\nL Y+50\nDEP LN LEN5")
    assert np.allclose(other[2].centre, (3, 0, 0), atol=1e-9)  # on the other side: -5 + 8
    assert other[2].clockwise is True


def test_approach_and_departure_on_line_and_arc():
    # centre of the arc (-13, 0), R = 8, start (-13 - 8 sqrt 2, 0 - ...): from (-33, -8) the line y = -8 touches the circle below
    got = moves(
        "TOOL CALL 5 Z\nL X-33 Y-8 FMAX\nAPPR LCT X+0 Y+0 R8 RL F100\nL Y+50\nDEP LCT X-33 Y+58 Z+9 R8"
    )
    assert np.allclose(
        [m.end for m in got],
        [(-33, -8, 0), (-13, -8, 0), (-5, 0, 0), (-5, 50, 0), (-13, 58, 0), (-33, 58, 0), (-33, 58, 9)], atol=1e-9,
    )  # fmt: skip
    assert [m.kind for m in got] == ["rapid", "line", "arc", "line", "arc", "line", "line"]


def test_approach_without_contour():
    with pytest.raises(ModelLimit, match=r"part.h:3:1: APPR is not followed by a contour element"):
        moves("TOOL CALL 5 Z\nAPPR LT X+20 Y+0 LEN10 RL F100")


def test_sample_with_approach_along_a_tangent():
    program = read(sample("PROFILE"), "part.h", Setup(tools={1: Tool(1, diameter=10.0)}))
    # the operator's positions are not known: all corners fall on (7, 7), (-7, -7): the square, right-hand, one radius outside
    box = np.array([m.end[:2] for m in program.moves if m.compensation])
    assert np.allclose(np.abs(box).max(axis=0)[1], 12)
    assert [m.kind for m in program.moves].count("arc") == 3


def test_approach_and_departure_by_polar_coordinates():
    """APPR PLCT is APPR LCT with the point given by PR and PA about the pole."""
    head, tail = "TOOL CALL 5 Z\nL X-50 Y-20 Z+5 FMAX\n", "L Y+30\nL X+20\n"
    plain = ends(f"{head}APPR LCT X+10 Y+0 R8 RL F100\n{tail}DEP LCT X+40 Y-10 R5 F100")
    polar = ends(
        f"{head}CC X+0 Y+0\nAPPR PLCT PR+10 PA+0 R8 RL F100\n{tail}CC X+40 Y+0\nDEP PLCT PR+10 PA-90 R5 F100"
    )
    assert np.allclose(plain, polar)
