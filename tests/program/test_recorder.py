"""The recorder: positions, feeds, arcs and remarks by hand."""

from __future__ import annotations

import math

import pytest

from vcmm.program.faults import ProgramFault
from vcmm.program.frames import rotation, stretch
from vcmm.program.moves import Source
from vcmm.program.radius import SINUMERIK, RadiusCompensation
from vcmm.program.recorder import Recorder, radius_centre
from vcmm.program.setup import Setup, Tool

SETUP = Setup(offsets={"G54": (100.0, 50.0, -10.0), "G55": (1.0, 2.0, 3.0)}, tools={1: Tool(1, 80.0, 10.0)})


def recorder(**more) -> Recorder:
    r = Recorder(file="p.mpf", setup=SETUP, **more)
    r.feed = 300.0
    return r


def test_three_positions_of_one_point():
    # work offset (100, 50, -10), tool length 80: programmed (1, 2, 3) -> tip (101, 52, -7) -> axes (101, 52, 73)
    r = recorder()
    r.change_tool(SETUP.tools[1], "T1")
    r.straight((1.0, 2.0, 3.0), True)
    assert (r.p, r.tip(), r.q) == ((1.0, 2.0, 3.0), (101.0, 52.0, -7.0), (101.0, 52.0, 73.0))
    r.set_offset("G55")  # the axes stay: 101 - 1, 52 - 2, -7 - 3
    assert (r.p, r.q) == ((100.0, 50.0, -10.0), (101.0, 52.0, 73.0))
    r.set_frame(rotation(2, math.pi / 2))  # (x, y) = Rz(90) (50, -100)
    assert r.p == (50.0, -100.0, -10.0)


def test_a_tool_that_stands_aside_in_every_axis():
    # as above, 7 mm in X, -4 mm in Y: the axes stand at (101 + 7, 52 - 4, -7 + 80); the next move begins at the tip where this one ended
    r = recorder()
    r.set_length((7.0, -4.0, 80.0))
    r.straight((1.0, 2.0, 3.0), True)
    assert (r.tip(), r.q) == ((101.0, 52.0, -7.0), (108.0, 48.0, 73.0))
    r.straight((1.0, 2.0, 0.0), False)
    assert r.moves[-1].start == (101.0, 52.0, -7.0)


def test_feeds_in_three_ways():
    r = recorder()
    assert r.rate(10.0, 0.0) == 300.0
    r.feed_mode, r.feed = "G93", 2.0
    assert r.rate(10.0, 0.0) == 20.0
    r.feed_mode, r.feed, r.feed_scale = "G95", 0.1, 25.4
    assert r.rate(10.0, -1000.0) == pytest.approx(2540.0)
    with pytest.raises(ProgramFault, match="spindle is at rest"):
        r.rate(10.0, 0.0)
    r.feed, r.source = None, Source(4, 7, 9)
    with pytest.raises(ProgramFault, match=r"p\.mpf:4:7: no feed") as fault:
        r.rate(10.0, 1.0)
    assert (fault.value.line, fault.value.column) == (4, 7)


def test_an_arc_of_inverse_time_knows_its_length():
    # a quarter circle of radius 10 is 15.708 mm long: two of it per minute are 31.416 mm/min
    r = recorder()
    r.straight((10.0, 0.0, 0.0), True)
    r.feed_mode, r.feed = "G93", 2.0
    r.arc((0.0, 10.0, 0.0), (0.0, 0.0, 0.0), clockwise=False)
    assert r.moves[-1].feed == pytest.approx(10.0 * math.pi)
    assert r.moves[-1].centre == (100.0, 50.0, -10.0)


def test_a_mirror_image_changes_sense_and_side():
    r = recorder()
    r.set_frame(stretch((-1.0, 1.0, 1.0)))
    r.tool_data = SETUP.tools[1]
    r.compensate("left", SINUMERIK, extra=0.5)
    r.straight((10.0, 0.0, 0.0), False)
    r.arc((0.0, 10.0, 0.0), (0.0, 0.0, 0.0), clockwise=False)
    assert r.moves[-1].clockwise is True
    assert r.sides == [RadiusCompensation("right", 5.5, SINUMERIK)] * 2
    assert [m.compensation for m in r.moves] == [None, None]  # set with the centre path


def test_what_radius_compensation_forbids():
    r = recorder()
    r.tool_data = SETUP.tools[1]
    r.compensate("left", SINUMERIK)
    for change in (
        lambda: r.set_offset("G55"),
        lambda: r.to_machine((0.0, 0.0, 0.0), True),
        lambda: r.change_tool(Tool(2), "T2"),
    ):
        with pytest.raises(ProgramFault, match="while radius compensation is on"):
            change()


def test_remarks_are_made_once_of_each_kind():
    r = recorder()
    r.remark("again")
    r.remark("again")
    r.remark("one", 3, "kind")
    r.remark("other", 3, "kind")
    r.remark("again", every=True)
    assert [(m.text, m.column) for m in r.remarks] == [("again", 1), ("one", 3), ("again", 1)]


def test_a_move_in_machine_coordinates_is_never_rewritten():
    r = recorder()
    r.to_machine((1.0, 2.0, 3.0), True, (0.0, 0.0, 0.5))
    move = r.moves[-1]
    assert (move.end, move.rewritable, move.rotary_end) == ((1.0, 2.0, 3.0), False, (0.0, 0.0, 0.5))
    assert r.p == (-99.0, -48.0, 13.0)


def test_tool_axis_and_dwell():
    r = recorder(tool_axis=0)
    r.change_tool(SETUP.tools[1], "T1")
    assert r.tool_offset == (80.0, 0.0, 0.0)
    r.dwell(1.5)
    assert (r.moves[-1].kind, r.moves[-1].seconds) == ("dwell", 1.5)
    with pytest.raises(ProgramFault, match="cannot be negative"):
        r.dwell(-1.0)


def test_centre_of_a_radius():
    # chord (0, 0) to (6, 0), R 5: 4 beside its middle; G2 passes above, its centre lies below
    start, end = (0.0, 0.0, 0.0), (6.0, 0.0, 0.0)
    assert radius_centre(start, end, 5.0, True, "XY") == (3.0, -4.0, 0.0)
    assert radius_centre(start, end, 5.0, False, "XY") == (3.0, 4.0, 0.0)
    assert radius_centre(start, end, -5.0, True, "XY") == (3.0, 4.0, 0.0)
    assert radius_centre(start, end, 2.0, True, "XY") is None
